/// A survey with a down-looking camera: the vehicle's navigation as it was measured, and the frames along its true track.
/// Thesis 5.3; docs/math/auv.md to, docs/math/camera_simulation.md
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/pinhole_camera.hpp"
#include "ssjs/sensors/pinhole.hpp"
#include "ssjs/simulation/auv_survey.hpp"
#include "ssjs/simulation/frame_renderer.hpp"
#include "ssjs/simulation/seabed_texture.hpp"

namespace ssjs {

/// The camera of the vehicle. The lens is Brown's with two radial coefficients. docs/math/optical.md (V-1), (V-2)
struct SimulatedCameraConfig {
  int width_px = 320;
  int height_px = 240;
  double focal_px = 320.0;
  double lens_k1 = -0.12, lens_k2 = 0.02;
  double frames_per_s = 3.0;
  CameraConfig mount;  ///< its mounting alone is used
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("width_px", width_px, Rule::closed(16, 4096), "columns of a frame");
    v.field("height_px", height_px, Rule::closed(16, 4096), "rows of a frame");
    v.field("focal_px", focal_px, Rule::positive(), "focal length");
    v.field("lens_k1", lens_k1, Rule::closed(-1, 1), "radial distortion with the square of the distance from the axis");
    v.field("lens_k2", lens_k2, Rule::closed(-1, 1), "... and with its fourth power");
    v.field("frames_per_s", frames_per_s, Rule::positive(), "frames in a second, the first at the start");
    v.section("mount", mount, "where the camera sits and looks");
  }
  /// The principal point is the middle of the frame.
  [[nodiscard]] PinholeCamera pinhole() const;
};

struct CameraSurveyConfig {
  SurveyWorldConfig lines = default_lines();  ///< its landmarks are not used
  AuvSimulationConfig vehicle = default_vehicle();
  SeabedTextureConfig seabed;
  SimulatedCameraConfig camera;
  FrameLightConfig light;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("lines", lines, "the lines");
    v.section("vehicle", vehicle, "motion and navigation sensors");
    v.section("seabed", seabed, "relief and colours");
    v.section("camera", camera, "the camera");
    v.section("light", light, "lamp, water, exposure and noise");
  }

  /// 20 m x 20 m in a grid of 5 m.
  [[nodiscard]] static SurveyWorldConfig default_lines();
  /// A small, slow vehicle 2.5 m above the seabed, with the inertial unit and the velocity log that fit into one.
  [[nodiscard]] static AuvSimulationConfig default_vehicle();
};

class CameraSurvey {
 public:
  /// `rays`: of the pixels of `config.camera` with its lens. Streams of the seed: those of simulate_survey(), SeabedTexture and
  /// FrameRenderer. Throws InvalidArgument for a configuration out of its rules or a path that cannot be driven.
  CameraSurvey(const CameraSurveyConfig& config, CameraRays rays, std::uint64_t seed);
  CameraSurvey(const CameraSurvey&) = delete;
  CameraSurvey& operator=(const CameraSurvey&) = delete;
  CameraSurvey(CameraSurvey&&) = delete;
  CameraSurvey& operator=(CameraSurvey&&) = delete;
  ~CameraSurvey() = default;

  /// Without sightings: those are in the frames.
  [[nodiscard]] const SimulatedSurvey& survey() const { return survey_; }
  [[nodiscard]] const SeabedTexture& seabed() const { return seabed_; }
  [[nodiscard]] int frames() const { return frames_; }
  [[nodiscard]] double frame_time_s(int frame) const;
  /// Red, green, blue, row by row. From several threads at once, in any order: the same bytes.
  [[nodiscard]] std::vector<std::uint8_t> frame(int number) const;

 private:
  CameraSurveyConfig config_;
  SeabedTexture seabed_;
  FrameRenderer renderer_;
  SimulatedSurvey survey_;
  int frames_;
};

}  // namespace ssjs
