/// What was wrong in a log: each kind once, with its count and the first place. Bounded whatever the file holds.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ssjs {

/// Whether part of the recording could not be used, or the reader only had to decide something.
enum class Loss { kNothing, kData };

struct LogProblem {
  std::string what;
  std::uint64_t count = 0;
  std::uint64_t first_offset = 0;  ///< byte of the log
  Loss loss = Loss::kNothing;
};

class LogProblems {
 public:
  /// what: a fixed text, so that their number is bounded; offset: byte of the record concerned.
  void add(std::string_view what, std::uint64_t offset, Loss loss);
  [[nodiscard]] const std::vector<LogProblem>& all() const { return all_; }  ///< in the order of their first appearance

 private:
  std::vector<LogProblem> all_;
};

}  // namespace ssjs
