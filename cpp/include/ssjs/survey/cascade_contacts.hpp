/// A trained cascade as what proposes contacts in a survey; the contours it knows may verify. docs/cascade.md "In a survey"
/// side of the ground-range picture (port mirrored) -> windows -> detections -> box of the echo in each
#pragma once

#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/cascade/cascade_detector.hpp"
#include "ssjs/imaging/sonar_image.hpp"
#include "ssjs/survey/contact.hpp"

namespace ssjs {

struct CascadeContactsConfig {
  double scale_factor = 1.1;
  int min_neighbours = 3;
  double min_score = 0.0;
  double max_overlap = 0.3;
  DetectionVerifier verify = DetectionVerifier::kNone;
  double min_contour_score = 0.05;
  double echo_level = 110.0;
  int smallest_echo_px = 6;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("scale_factor", scale_factor, Rule{1.0, 4.0, true, false}, "each scale is so many times the one before it");
    v.field("min_neighbours", min_neighbours, Rule::not_negative(), "a detection is made of more windows than this");
    v.field("min_score", min_score, Rule::any(), "detections with a lower score are dropped");
    v.field("max_overlap", max_overlap, Rule::closed(0, 1), "windows that share more than this part of the lesser one are one detection");
    v.choice("verify", verify, Choices<DetectionVerifier>{{"none", DetectionVerifier::kNone}, {"contour", DetectionVerifier::kContour}},
             "contour: compare the boundary of the echo in each detection with those of the objects trained on");
    v.field("min_contour_score", min_contour_score, Rule::closed(0, 1),
            "contour: what less than this part of known objects is as unlike the others as is dropped");
    v.field("echo_level", echo_level, Rule::closed(0, 255), "what is brighter inside a detection is its echo, after gain normalisation");
    v.field("smallest_echo_px", smallest_echo_px, Rule::at_least(1), "detections with a smaller echo are dropped");
  }
};

class CascadeContacts {
 public:
  /// Throws InvalidArgument for a model that contradicts itself, that knows no contours although they are to verify, or that was trained on
  /// pictures smoothed or continued beyond their borders, which those of a survey are not.
  CascadeContacts(HaarCascade cascade, const CascadeContactsConfig& config);

  /// Boxes of echoes: port before starboard, best score first. picture: CV_8U, port to the left of `nadir_column`.
  [[nodiscard]] std::vector<ContactBox> boxes(const SonarImage& picture, int nadir_column) const;

 private:
  [[nodiscard]] std::vector<cv::Rect> echoes(const SonarImage& side, const CascadeDetector& detector, CascadeSide seen) const;

  CascadeContactsConfig config_;
  double margin_;  ///< part of an object's size that the model's windows hold on each side of it
  CascadeDetector starboard_;
  CascadeDetector port_;
};

/// The box of an object inside the window that it was found in; an odd rest lies right of it, mirrored: left of it.
[[nodiscard]] cv::Rect object_in_window(const cv::Rect& window, double margin, CascadeSide seen);

}  // namespace ssjs
