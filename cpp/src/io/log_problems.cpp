#include "ssjs/io/log_problems.hpp"

namespace ssjs {

void LogProblems::add(std::string_view what, std::uint64_t offset, Loss loss) {
  for (LogProblem& known : all_) {
    if (known.what != what) continue;
    ++known.count;
    return;
  }
  all_.push_back({std::string(what), 1, offset, loss});
}

}  // namespace ssjs
