/// Regions and objects as columns of numbers.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/imaging/regions.hpp"

namespace ssjs::bindings {

namespace py = pybind11;

/// One value of each of many things as an array.
template <class Value, class Things, class Get>
py::array_t<Value> column(const Things& things, const Get& get) {
  py::array_t<Value> values(static_cast<py::ssize_t>(things.size()));
  std::transform(things.begin(), things.end(), values.mutable_data(), get);
  return values;
}

/// `width` values of each of many things as the rows of an array.
template <class Value, std::size_t width, class Things, class Get>
py::array_t<Value> rows(const Things& things, const Get& get) {
  py::array_t<Value> values({things.size(), width});
  Value* next = values.mutable_data();
  for (const auto& thing : things) {
    const std::array<Value, width> row = get(thing);
    next = std::copy(row.begin(), row.end(), next);
  }
  return values;
}

inline std::array<double, 2> xy(const cv::Point2d& point) { return {point.x, point.y}; }
inline std::array<int, 4> xywh(const cv::Rect& box) { return {box.x, box.y, box.width, box.height}; }

/// object_of_region: for each region the index of its object, from 0; the other columns have a row for each object.
inline py::dict object_table(const std::vector<RegionObject>& objects, std::size_t region_count) {
  py::array_t<int> object_of_region(static_cast<py::ssize_t>(region_count));
  int index = 0;
  for (const RegionObject& object : objects) {
    for (const int label : object.labels) object_of_region.mutable_at(label - 1) = index;
    ++index;
  }
  py::dict dict;
  dict["object_of_region"] = object_of_region;
  dict["area_px"] = column<std::int64_t>(objects, [](const RegionObject& object) { return object.area_px; });
  dict["centroid_px"] = rows<double, 2>(objects, [](const RegionObject& object) { return xy(object.centroid_px); });
  dict["bounding_box_px"] = rows<int, 4>(objects, [](const RegionObject& object) { return xywh(object.bounding_box); });
  return dict;
}

}  // namespace ssjs::bindings
