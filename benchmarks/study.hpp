/// The mission studies of the program ssjs_study. Each prints its tables.
#pragma once

#include <cstdint>
#include <string>

namespace ssjs::benchmarks {

struct StudyOptions {
  int rounds = 5;                     ///< repetitions; tables show medians
  int seeds = 5;                      ///< missions whose accuracy is averaged
  int laps = 40;                      ///< of the revisited circuit
  int columns = 200, rows = 100;      ///< landmarks of the explored field
  std::string association = "known";  ///< or "jcbb"
  int limit_s = 60;                   ///< processor time of one point of the growth study
  std::string method;                 ///< of the growth study, or part of a fault's name; empty: all
  std::uint64_t seed = 0;
  std::string csv;  ///< one line a closing; empty: no file
};

/// Scenario S: a bare EKF, the pipeline's EKF and SSJS on the same events, interleaved.
void study_grid_survey(const StudyOptions& options);
void study_methods(const StudyOptions& options);

/// The global level per closing while a fixed area is driven again and again.
void study_revisit(const StudyOptions& options);

/// The global level per closing in a growing field: a landmark is seen from neighbouring lines only.
void study_exploration(const StudyOptions& options);

/// Every method over the number of landmarks, to where it stops being usable.
void study_growth(const StudyOptions& options);

/// The same closings with the dense covariance and with sparse port factors, by the number of live bases.
void study_crossover(const StudyOptions& options);

/// Everything that can go wrong on the way from the sensors of an underwater vehicle to its estimator: the table of docs/faults.md.
void study_faults(const StudyOptions& options);

}  // namespace ssjs::benchmarks
