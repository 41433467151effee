/// The studies of the program ssjs_segmentation_study. Each prints its tables.
#pragma once

namespace ssjs::benchmarks {

struct SegmentationStudyOptions {
  int rounds = 25;     ///< repetitions; tables show medians
  int seeds = 10;      ///< scenes
  int side_px = 8000;  ///< of the square picture whose memory is measured
};

/// Thresholds and the whole chain against OpenCV's Otsu + Canny + findContours, on one thread, interleaved.
void study_times(const SegmentationStudyOptions& options);

/// Largest memory beyond the picture's own, bytes a pixel.
void study_memory(const SegmentationStudyOptions& options);

/// Improved Otsu against maximum entropy on the paper's three scenes, by the level and the looks of the seabed and the object's level.
void study_scenes(const SegmentationStudyOptions& options);

/// Thresholds under a gain gradient of 60 %, by contrast, filter and gain normalisation.
void study_gain(const SegmentationStudyOptions& options);

}  // namespace ssjs::benchmarks
