#include "ssjs/base/config_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <locale>
#include <numeric>
#include <sstream>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kLongestKey = 60;  // what comes after it is no misspelling

/// Least number of insertions, deletions and substitutions that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

/// What the edit distance is at least: an edit changes, adds or takes away one character, wherever it stands ("bag distance").
std::size_t least_edit_distance(std::string_view a, std::string_view b) {
  std::array<std::ptrdiff_t, 256> surplus{};
  for (const char each : a) ++surplus[static_cast<unsigned char>(each)];
  for (const char each : b) --surplus[static_cast<unsigned char>(each)];
  std::ptrdiff_t only_a = 0;
  std::ptrdiff_t only_b = 0;
  for (const std::ptrdiff_t each : surplus) (each > 0 ? only_a : only_b) += std::abs(each);
  return static_cast<std::size_t>(std::max(only_a, only_b));
}

}  // namespace

bool FieldSetter::is_wanted(std::string_view key) {
  keys_.push_back(full_key(key));
  if (keys_.back() != key_) return false;
  found_ = true;
  return true;
}

double FieldSetter::number(const Rule& rule) const {
  std::istringstream in(text_);
  in.imbue(std::locale::classic());  // a point is a point wherever the program runs
  double value = 0.0;
  if (!(in >> value) || in.peek() != std::istringstream::traits_type::eof()) throw InvalidArgument(key_, text_, "must be a number");
  if (!std::isfinite(value) || !rule.holds(value)) throw InvalidArgument(key_, value, rule.text());
  return value;
}

int FieldSetter::whole_number(const Rule& rule) const {
  const double value = number(rule);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max())
    throw InvalidArgument(key_, text_, "must be a whole number");
  return static_cast<int>(value);
}

void FieldSetter::field(std::string_view key, double& value, const Rule& rule, std::string_view) {
  if (is_wanted(key)) value = number(rule);
}

void FieldSetter::field(std::string_view key, int& value, const Rule& rule, std::string_view) {
  if (is_wanted(key)) value = whole_number(rule);
}

void FieldSetter::field(std::string_view key, bool& value, std::string_view) {
  if (!is_wanted(key)) return;
  if (text_ != "true" && text_ != "false") throw InvalidArgument(key_, text_, "must be true or false");
  value = text_ == "true";
}

void FieldSetter::field(std::string_view key, std::optional<double>& value, const Rule& rule, std::string_view) {
  if (!is_wanted(key)) return;
  value = text_ == "none" ? std::nullopt : std::optional<double>(number(rule));
}

void FieldSetter::field(std::string_view key, std::optional<int>& value, const Rule& rule, std::string_view) {
  if (!is_wanted(key)) return;
  value = text_ == "none" ? std::nullopt : std::optional<int>(whole_number(rule));
}

void FieldSetter::check_choice(const std::vector<std::string>& names) const {
  if (std::find(names.begin(), names.end(), text_) != names.end()) return;
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  throw InvalidArgument(key_, text_, "must be one of " + all);
}

void FieldSetter::finish() const {
  if (found_) return;
  const std::string_view asked = std::string_view(key_).substr(0, kLongestKey);
  // The most promising first: what follows the one whose bound is above the least distance so far is no nearer.
  std::vector<std::pair<std::size_t, std::size_t>> promising;  // bound, index
  for (std::size_t i = 0; i < keys_.size(); ++i) promising.emplace_back(least_edit_distance(asked, keys_[i]), i);
  std::sort(promising.begin(), promising.end());
  std::pair<std::size_t, std::size_t> nearest(std::numeric_limits<std::size_t>::max(), 0);  // distance, index
  for (const auto& candidate : promising) {
    if (candidate > nearest) break;
    nearest = std::min(nearest, {edit_distance(asked, keys_[candidate.second]), candidate.second});
  }
  const std::string hint = keys_.empty() ? "" : "; the nearest is " + keys_[nearest.second];
  throw InvalidArgument("setting", key_, "is not known" + hint);
}

std::string FieldLister::text_of(double value) {
  std::array<char, 32> digits{};
  const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

}  // namespace ssjs
