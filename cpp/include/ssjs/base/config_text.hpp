/// Sets single fields of a configuration by key and text, for callers that do not know its structs: an embedding program, a file of keys.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

/// Walks a configuration (see config_field.hpp) until it meets `key`, full path with dots, and gives that field the value of `text`.
class FieldSetter : public NestedVisitor<FieldSetter> {
 public:
  FieldSetter(std::string key, std::string text) : key_(std::move(key)), text_(std::move(text)) {}

  void field(std::string_view key, double& value, const Rule& rule, std::string_view description);
  void field(std::string_view key, int& value, const Rule& rule, std::string_view description);
  void field(std::string_view key, bool& value, std::string_view description);
  /// "none" empties it.
  void field(std::string_view key, std::optional<double>& value, const Rule& rule, std::string_view description);
  void field(std::string_view key, std::optional<int>& value, const Rule& rule, std::string_view description);
  template <class Enum>
  void choice(std::string_view key, Enum& value, const Choices<Enum>& choices, std::string_view) {
    if (!is_wanted(key)) return;
    std::vector<std::string> names;
    for (const auto& [name, each] : choices) {
      if (name == text_) value = each;
      names.push_back(name);
    }
    check_choice(names);
  }

  /// Throws InvalidArgument with the nearest key when nothing had the name.
  void finish() const;

 private:
  [[nodiscard]] bool is_wanted(std::string_view key);
  [[nodiscard]] double number(const Rule& rule) const;
  [[nodiscard]] int whole_number(const Rule& rule) const;
  void check_choice(const std::vector<std::string>& names) const;

  std::string key_, text_;
  std::vector<std::string> keys_;  ///< all that were met
  bool found_ = false;
};

/// set_field(config, "split.longest_m", "150"). Throws InvalidArgument for an unknown key (naming the nearest one), for text that is no
/// such value and for a value outside its rule; the configuration is unchanged then.
template <class Config>
void set_field(Config& config, const std::string& key, const std::string& text) {
  FieldSetter setter(key, text);
  config.visit(setter);
  setter.finish();
}

}  // namespace ssjs
