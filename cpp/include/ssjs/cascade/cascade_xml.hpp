/// OpenCV's cascade files (`opencv-cascade-classifier`, Haar features), as CascadeClassifier of OpenCV 3 and 4 reads them.
#pragma once

#include <string>
#include <string_view>

#include "ssjs/cascade/haar_cascade.hpp"

namespace ssjs {

/// The cascade as XML. Provenance has no place in it. Numbers are written so that they come back bit for bit.
[[nodiscard]] std::string to_opencv_xml(const HaarCascade& cascade);

/// `name` is what errors call the text. Stumps and trees are read; entities are not expanded; sizes are bounded. Throws FileError
/// with the offset of what is wrong.
[[nodiscard]] HaarCascade from_opencv_xml(std::string_view xml, const std::string& name);

[[nodiscard]] HaarCascade read_opencv_xml(const std::string& path);
void write_opencv_xml(const HaarCascade& cascade, const std::string& path);

}  // namespace ssjs
