/// Python views of the self-describing configurations (ssjs/base/config_field.hpp).
#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs::bindings {

namespace py = pybind11;

/// Lists every field as a dictionary, keys dotted.
class FieldLister : public NestedVisitor<FieldLister> {
 public:
  template <class Value>
  void field(std::string_view key, Value& value, const Rule& rule, std::string_view description) {
    if constexpr (std::is_same_v<Value, std::optional<double>> || std::is_same_v<Value, std::optional<int>>) {
      constexpr bool is_float = std::is_same_v<Value, std::optional<double>>;
      append(key, is_float ? "optional_float" : "optional_int", value ? py::cast(*value) : py::none(), rule.text(), description);
    } else {
      append(key, std::is_same_v<Value, double> ? "float" : "int", py::cast(value), rule.text(), description);
    }
  }
  void field(std::string_view key, bool& value, std::string_view description) { append(key, "bool", py::cast(value), "", description); }
  template <class Enum>
  void choice(std::string_view key, Enum& value, const Choices<Enum>& choices, std::string_view description) {
    py::list names;
    py::object present = py::none();
    for (const auto& [name, choice] : choices) {
      names.append(name);
      if (choice == value) present = py::cast(name);
    }
    append(key, "choice", present, "", description);
    fields_[fields_.size() - 1]["choices"] = names;
  }
  [[nodiscard]] py::list fields() const { return fields_; }

 private:
  void append(std::string_view key, const char* type, const py::object& value, const std::string& rule, std::string_view description) {
    py::dict entry;
    entry["key"] = full_key(key);
    entry["type"] = type;
    entry["default"] = value;
    entry["choices"] = py::none();
    entry["rule"] = rule;
    entry["description"] = std::string(description);
    fields_.append(entry);
  }
  py::list fields_;
};

template <class Config>
[[nodiscard]] py::list fields_of() {
  Config config;
  FieldLister lister;
  config.visit(lister);
  return lister.fields();
}

/// Sets fields from a flat dictionary with dotted keys; keys without a field stay in unused().
class FieldSetter : public NestedVisitor<FieldSetter> {
 public:
  explicit FieldSetter(const py::dict& values) : unused_(values.attr("copy")()) {}

  template <class Value>
  void field(std::string_view key, Value& value, const Rule&, std::string_view) {
    set(key, value);
  }
  void field(std::string_view key, bool& value, std::string_view) { set(key, value); }
  template <class Enum>
  void choice(std::string_view key, Enum& value, const Choices<Enum>& choices, std::string_view) {
    std::string name;
    if (!take(key, name)) return;
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& choice) { return choice.first == name; });
    if (found == choices.end()) {
      std::string known;
      for (const auto& choice : choices) known += (known.empty() ? "" : ", ") + choice.first;
      throw InvalidArgument(full_key(key), name, "must be one of " + known);
    }
    value = found->second;
  }
  [[nodiscard]] const py::dict& unused() const { return unused_; }

 private:
  template <class Value>
  bool take(std::string_view key, Value& value) {
    const std::string full = full_key(key);
    if (!unused_.contains(full.c_str())) return false;
    const py::object given = unused_.attr("pop")(full);
    try {
      value = given.cast<Value>();
    } catch (const py::cast_error&) {
      throw InvalidArgument(full, py::str(given).cast<std::string>(), "is of the wrong type");
    }
    return true;
  }
  template <class Value>
  void set(std::string_view key, Value& value) {
    take(key, value);
  }
  py::dict unused_;
};

/// A configuration out of its defaults and a flat dictionary. Unknown keys throw InvalidArgument; rules are not checked here.
template <class Config>
[[nodiscard]] Config config_from(const py::dict& values, Config config = {}) {
  FieldSetter setter(values);
  config.visit(setter);
  for (const auto& [key, value] : setter.unused()) {
    throw InvalidArgument(py::str(key).cast<std::string>(), py::str(value).cast<std::string>(), "no such configuration key");
  }
  return config;
}

}  // namespace ssjs::bindings
