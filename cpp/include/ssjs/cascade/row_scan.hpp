/// The inner loop of detection: the cascade on all windows of one row, side by side where many are still in, one by one after that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ssjs/cascade/haar_cascade.hpp"

namespace ssjs {

/// A cascade laid out for pictures whose integral images share one geometry.
class RowScan {
 public:
  struct Hit {
    int index = 0;  ///< windows from the left, `column_step` pixels apart
    double score = 0;
  };

  /// What a thread uses again and again.
  struct Scratch {
    std::vector<double> variances;
    std::vector<float> norms;  ///< 0: not to be looked at
    std::vector<double> sums;
    std::vector<Hit> standing;
  };

  /// `geometry`: an integral image as wide and with the column step of those to be scanned.
  RowScan(const HaarCascade& cascade, const IntegralImage& geometry);

  /// The windows of the row whose top is row `y` of the image: `usable[i]` tells whether window i is to be looked at. Appends
  /// those that pass. With `skip_after_first_stage` a window next to the right of one that failed the first stage is passed over.
  void scan(const IntegralImage& image, int y, const std::vector<unsigned char>& usable, bool skip_after_first_stage, Scratch& scratch,
            std::vector<Hit>& hits) const;

 private:
  struct Rectangle {
    std::array<std::int32_t, 4> corners{};  ///< as offsets into the sums
    float weight = 0;
  };
  struct Node {
    std::array<Rectangle, 3> rectangles;
    float threshold = 0;
    int left = 0;
    int right = 0;
    float left_leaf = 0;  ///< of stumps
    float right_leaf = 0;
    bool tilted = false;
  };
  struct Tree {
    std::size_t first_node = 0;
    std::size_t first_leaf = 0;
  };
  struct Stage {
    std::size_t first_tree = 0;
    std::size_t trees = 0;
    bool stumps = true;
    double pass_mark = 0;
  };

  void normalise(const IntegralImage& image, std::ptrdiff_t base, const std::vector<unsigned char>& usable, Scratch& scratch) const;
  void sum_stage_side_by_side(const Stage& stage, const IntegralImage& image, std::ptrdiff_t base, Scratch& scratch) const;
  [[nodiscard]] double sum_stage(const Stage& stage, const IntegralImage& image, std::ptrdiff_t base, float norm) const;

  cv::Size window_;
  std::vector<Node> nodes_;
  std::vector<float> leaves_;
  std::vector<Tree> trees_;
  std::vector<double> most_to_come_;  ///< per tree: what it and those after it in the stage can add at most
  std::vector<Stage> stages_;
  std::array<std::int32_t, 4> inner_{};
};

}  // namespace ssjs
