#include "ssjs/io/sonar_log.hpp"

#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/io/jsf.hpp"
#include "ssjs/io/xtf.hpp"

namespace ssjs {

void Tally::count(std::string_view choice) {
  const auto known = counts_.find(choice);
  if (known != counts_.end()) {
    ++known->second;
  } else {
    counts_.emplace(choice, 1);
  }
}

std::string Tally::leading() const {
  std::string choice;
  std::uint64_t most = 0;
  for (const auto& [name, count] : counts_) {
    if (count <= most) continue;
    most = count;
    choice = name;
  }
  return choice;
}

std::unique_ptr<SonarLogReader> open_sonar_log(const std::string& path, const SonarLogConfig& config) {
  auto file = std::make_unique<FileBytes>(path);
  if (looks_like_jsf(*file)) return std::make_unique<JsfReader>(std::move(file), config);
  if (looks_like_xtf(*file)) return std::make_unique<XtfReader>(std::move(file), config);
  throw FileError(path, 0, "is neither an XTF nor a JSF log: it starts with the mark of neither; export it as one of them");
}

}  // namespace ssjs
