#include "ssjs/imaging/ground_truth.hpp"

#include <map>
#include <sstream>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Runs with the index of their object; objects without a run are not allowed.
GroundTruth truth_of_runs(const cv::Size& size, bool is_boxes, const std::vector<MaskRun>& runs, int objects) {
  GroundTruth truth{size, is_boxes, std::vector<TruthObject>(static_cast<std::size_t>(objects))};
  for (const MaskRun& run : runs) {
    TruthObject& object = truth.objects[static_cast<std::size_t>(run.component)];
    const int pixels = run.end - run.first;
    object.runs.push_back(run);
    object.area_px += pixels;
    object.centroid_px += pixels * cv::Point2d(0.5 * (static_cast<double>(run.first) + run.end - 1), run.row);
    object.bounding_box |= cv::Rect(run.first, run.row, pixels, 1);
  }
  for (TruthObject& object : truth.objects) object.centroid_px /= static_cast<double>(object.area_px);
  return truth;
}

template <class Value>
GroundTruth truth_of_values(const cv::Mat& labels) {
  std::vector<MaskRun> runs;  // with the label as component, to begin with
  std::map<int, int> index_of;
  for (int row = 0; row < labels.rows; ++row) {
    const Value* values = labels.ptr<Value>(row);
    for (int first = 0; first < labels.cols;) {
      const auto value = static_cast<int>(values[first]);
      if (value < 0) throw InvalidArgument("labels", value, "must not be negative");
      int end = first + 1;
      while (end < labels.cols && values[end] == values[first]) ++end;
      if (value != 0) {
        runs.push_back({row, first, end, value});
        index_of[value] = 0;
      }
      first = end;
    }
  }
  int objects = 0;
  for (auto& [label, index] : index_of) index = objects++;
  for (MaskRun& run : runs) run.component = index_of.at(run.component);
  return truth_of_runs(labels.size(), false, runs, objects);
}

}  // namespace

GroundTruth truth_of_mask(const cv::Mat& mask) {
  const MaskComponents components = foreground_components(mask);
  return truth_of_runs(mask.size(), false, components.runs, components.count);
}

GroundTruth truth_of_labels(const cv::Mat& labels) {
  if (labels.dims > 2 || labels.channels() != 1) throw InvalidArgument("labels", cv::typeToString(labels.type()), "must have one channel");
  if (labels.depth() == CV_8U) return truth_of_values<unsigned char>(labels);
  if (labels.depth() == CV_16U) return truth_of_values<unsigned short>(labels);
  if (labels.depth() == CV_32S) return truth_of_values<int>(labels);
  throw InvalidArgument("labels", cv::typeToString(labels.type()), "must hold integers (CV_8U, CV_16U or CV_32S)");
}

GroundTruth truth_of_boxes(const cv::Size& size, const std::vector<cv::Rect>& boxes) {
  std::vector<MaskRun> runs;
  int objects = 0;
  for (const cv::Rect& box : boxes) {
    const cv::Rect inside = box & cv::Rect({0, 0}, size);
    if (inside.empty()) {
      std::ostringstream text;
      text << box;
      throw InvalidArgument("boxes[" + std::to_string(objects) + "]", text.str(), "has no pixel in the picture");
    }
    for (int row = inside.y; row < inside.y + inside.height; ++row) runs.push_back({row, inside.x, inside.x + inside.width, objects});
    ++objects;
  }
  return truth_of_runs(size, true, runs, objects);
}

}  // namespace ssjs
