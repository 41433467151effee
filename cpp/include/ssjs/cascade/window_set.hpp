/// Training and validation windows: equal-sized 8-bit pictures, each with the recording that it comes from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/base/random.hpp"

namespace ssjs {

class WindowSet {
 public:
  explicit WindowSet(cv::Size window);

  /// `picture`: CV_8UC1 of the window's size.
  void add(const cv::Mat& picture, int recording = 0);
  void append(const WindowSet& other);

  [[nodiscard]] cv::Size window() const { return window_; }
  [[nodiscard]] std::size_t size() const { return recordings_.size(); }
  [[nodiscard]] cv::Mat operator[](std::size_t index) const;  ///< a view, valid until the set changes
  [[nodiscard]] int recording(std::size_t index) const { return recordings_[index]; }
  [[nodiscard]] WindowSet select(const std::vector<std::size_t>& indices) const;

  /// FNV-1a over the window's size, the recordings and the pixels: equal digests mean equal sets.
  [[nodiscard]] std::uint64_t digest() const;

 private:
  cv::Size window_;
  std::vector<unsigned char> pixels_;
  std::vector<int> recordings_;
};

/// The box of an object as a window: grown to the window's proportions about its centre, then resampled as the
/// detector resamples pictures. None if the grown box does not lie in the image.
[[nodiscard]] cv::Mat window_of(const cv::Mat& image, const cv::Rect& box, cv::Size window);

struct SampleSplit {
  std::vector<std::size_t> training;
  std::vector<std::size_t> validation;
};

/// Whole recordings are drawn for validation, of all choices one that holds as nearly `validation_fraction` of the samples as can
/// be, of two equally near the smaller; at least one recording trains. Windows of one recording resemble each other: a split among
/// them would flatter. With a single recording nothing is left for validation.
[[nodiscard]] SampleSplit split_by_recording(const std::vector<int>& recordings, double validation_fraction, const Rng& rng);

}  // namespace ssjs
