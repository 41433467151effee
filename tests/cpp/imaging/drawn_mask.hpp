/// Masks drawn as text: '#' is set, anything else clear.
#pragma once

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ssjs {

inline cv::Mat drawn(const std::vector<std::string>& rows, int set = 255) {
  cv::Mat mask = cv::Mat::zeros(static_cast<int>(rows.size()), static_cast<int>(rows.at(0).size()), CV_8U);
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (rows[static_cast<std::size_t>(y)].at(static_cast<std::size_t>(x)) == '#')
        mask.at<unsigned char>(y, x) = static_cast<unsigned char>(set);
    }
  }
  return mask;
}

/// The text of a mask of 0 and 255; other values are shown as '?'.
inline std::string text(const cv::Mat& mask) {
  std::string rows = "\n";
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      const int value = mask.at<unsigned char>(y, x);
      rows += value == 255 ? '#' : value == 0 ? '.' : '?';
    }
    rows += "\n";
  }
  return rows;
}

inline void expect_mask(const cv::Mat& mask, const std::vector<std::string>& rows) { EXPECT_EQ(text(mask), text(drawn(rows))); }

}  // namespace ssjs
