/// Frames of a camera as arrays.
#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "arrays.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs::bindings {

/// Grey (rows, columns) or colour (rows, columns, 3: red, green, blue), 8 bits; copied, as the frame may be looked at without the lock.
[[nodiscard]] inline cv::Mat frame_from(const py::array& array) {
  const bool is_colour = array.ndim() == 3 && array.shape(2) == 3;
  if ((array.ndim() != 2 && !is_colour) || mat_depth(array.dtype()) != CV_8U || array.size() == 0) {
    throw InvalidArgument("frame", array_text(array), "must be uint8 of shape (rows, columns) or (rows, columns, 3)");
  }
  const auto dense = py::array_t<unsigned char, py::array::c_style | py::array::forcecast>::ensure(array);
  cv::Mat frame(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), is_colour ? CV_8UC3 : CV_8U);
  std::copy_n(dense.data(), dense.size(), frame.data);
  return frame;
}

[[nodiscard]] inline py::array frame_array(const cv::Mat& frame) {
  if (frame.channels() == 1) return picture_array(frame);
  py::array_t<unsigned char> array({frame.rows, frame.cols, frame.channels()});
  for (int r = 0; r < frame.rows; ++r) std::copy_n(frame.ptr(r), frame.cols * frame.channels(), array.mutable_data(r, 0, 0));
  return array;
}

}  // namespace ssjs::bindings
