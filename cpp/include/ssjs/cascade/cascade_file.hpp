/// Cascades in this library's own form: JSON with a version and the model's provenance.
#pragma once

#include <string>
#include <string_view>

#include "ssjs/cascade/haar_cascade.hpp"

namespace ssjs {

/// Numbers come back bit for bit; equal models give equal text.
[[nodiscard]] std::string to_json(const HaarCascade& cascade);

/// `name` is what errors call the text. Throws FileError on anything but a whole model of a known version.
[[nodiscard]] HaarCascade from_json(std::string_view json, const std::string& name);

/// By content: this library's form, or OpenCV's XML.
[[nodiscard]] HaarCascade load_cascade(const std::string& path);

/// The file is whole or not there: written beside `path`, then renamed. A path that ends in .xml gets OpenCV's form.
void save_cascade(const HaarCascade& cascade, const std::string& path);

}  // namespace ssjs
