/// Where numpy arrays and cv::Mat meet: pictures go in and come out without a copy.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/error.hpp"

namespace ssjs::bindings {

namespace py = pybind11;

/// "float64 of shape (3, 4)"
inline std::string array_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>() + " of shape " + py::str(array.attr("shape")).cast<std::string>();
}

/// What cv::Mat calls a numpy type, none if a picture does not hold it. Truth values are bytes of 0 and 1.
inline std::optional<int> mat_depth(const py::dtype& type) {
  const char kind = type.kind();
  const auto bytes = type.itemsize();
  if (kind == 'b' || (kind == 'u' && bytes == 1)) return CV_8U;
  if (kind == 'u' && bytes == 2) return CV_16U;
  if (kind == 'i' && bytes == 4) return CV_32S;
  return std::nullopt;
}

inline std::string depth_name(int depth) { return depth == CV_8U ? "uint8" : depth == CV_16U ? "uint16" : "int32"; }

/// A two-dimensional array seen as a one-channel cv::Mat. Rows may be apart (slices of rows and columns are), pixels within a row
/// may not: then, and for foreign byte orders, the array is copied. Lives and dies with the interpreter lock held.
class Picture {
 public:
  /// depths: what is allowed of CV_8U (also for bool), CV_16U, CV_32S.
  Picture(const py::array& array, const std::string& argument, const std::vector<int>& depths) : array_(array) {
    const std::optional<int> depth = mat_depth(array.dtype());
    bool allowed = false;
    std::string names;
    for (const int known : depths) {
      allowed = allowed || depth == known;
      names += (names.empty() ? "" : " or ") + depth_name(known);
    }
    if (array.ndim() != 2 || !allowed) throw InvalidArgument(argument, array_text(array), "must be a two-dimensional array of " + names);
    constexpr auto kMost = static_cast<py::ssize_t>(std::numeric_limits<int>::max());
    if (array.shape(0) > kMost || array.shape(1) > kMost)
      throw InvalidArgument(argument, array_text(array), "has too many rows or columns");

    if (!array_.dtype().attr("isnative").cast<bool>()) array_ = array_.attr("astype")(array_.dtype().attr("newbyteorder")("="));
    const py::ssize_t pixel = array_.itemsize();
    const bool rows_apart = array_.shape(0) > 1 && array_.strides(0) < pixel * array_.shape(1);
    const bool pixels_apart = array_.shape(1) > 1 && array_.strides(1) != pixel;
    if (rows_apart || pixels_apart) array_ = py::array::ensure(array_.attr("copy")("C"));
    // The library takes pictures as const cv::Mat& and leaves them untouched; cv::Mat has no constructor for constant data.
    void* data = const_cast<void*>(array_.data());
    const auto step = array_.shape(0) > 1 ? static_cast<std::size_t>(array_.strides(0)) : static_cast<std::size_t>(cv::Mat::AUTO_STEP);
    mat_ = cv::Mat(static_cast<int>(array_.shape(0)), static_cast<int>(array_.shape(1)), *depth, data, step);
  }
  [[nodiscard]] const cv::Mat& mat() const { return mat_; }

 private:
  py::array array_;  ///< owns the pixels
  cv::Mat mat_;
};

/// A mask: uint8 or bool, nonzero where set.
inline Picture mask_picture(const py::array& array, const std::string& argument) { return {array, argument, {CV_8U}}; }

/// A mask that may be left out: an empty cv::Mat then.
class OptionalMask {
 public:
  OptionalMask(const std::optional<py::array>& array, const std::string& argument) {
    if (array) picture_.emplace(*array, argument, std::vector<int>{CV_8U});
  }
  [[nodiscard]] cv::Mat mat() const { return picture_ ? picture_->mat() : cv::Mat(); }

 private:
  std::optional<Picture> picture_;
};

/// The pixels of a cv::Mat as an array that keeps them alive.
inline py::array picture_array(const cv::Mat& mat) {
  const auto type = mat.depth() == CV_8U    ? py::dtype::of<unsigned char>()
                    : mat.depth() == CV_16U ? py::dtype::of<unsigned short>()
                                            : py::dtype::of<int>();
  auto* kept = new cv::Mat(mat);
  const py::capsule owner(kept, [](void* pointer) { delete static_cast<cv::Mat*>(pointer); });
  const auto step = static_cast<py::ssize_t>(mat.step[0]);
  return py::array(type, {static_cast<py::ssize_t>(mat.rows), static_cast<py::ssize_t>(mat.cols)}, {step, type.itemsize()}, kept->data,
                   owner);
}

}  // namespace ssjs::bindings
