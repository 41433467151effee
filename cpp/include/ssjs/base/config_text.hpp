/// Sets single fields of a configuration by key and text, for callers that do not know its structs: an embedding program, a file of keys.
/// And the other way: all fields as text.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

/// Each field with its full key, in the order of the description.
using FieldTexts = std::vector<std::pair<std::string, std::string>>;

/// Numbers with the fewest digits that give the same number back, so that equal texts are equal configurations.
class FieldLister : public NestedVisitor<FieldLister> {
 public:
  void field(std::string_view key, double& value, const Rule&, std::string_view) { put(key, text_of(value)); }
  void field(std::string_view key, int& value, const Rule&, std::string_view) { put(key, std::to_string(value)); }
  void field(std::string_view key, bool& value, std::string_view) { put(key, value ? "true" : "false"); }
  void field(std::string_view key, std::optional<double>& value, const Rule&, std::string_view) {
    put(key, value ? text_of(*value) : "none");
  }
  void field(std::string_view key, std::optional<int>& value, const Rule&, std::string_view) {
    put(key, value ? std::to_string(*value) : "none");
  }
  template <class Enum>
  void choice(std::string_view key, Enum& value, const Choices<Enum>& choices, std::string_view) {
    for (const auto& [name, each] : choices) {
      if (each == value) put(key, name);
    }
  }

  [[nodiscard]] FieldTexts take_texts() { return std::move(texts_); }

 private:
  void put(std::string_view key, std::string text) { texts_.emplace_back(full_key(key), std::move(text)); }
  [[nodiscard]] static std::string text_of(double value);

  FieldTexts texts_;
};

template <class Config>
[[nodiscard]] FieldTexts field_texts(Config config) {
  FieldLister lister;
  config.visit(lister);
  return lister.take_texts();
}

}  // namespace ssjs
