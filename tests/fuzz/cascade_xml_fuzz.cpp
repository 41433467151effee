// Any bytes as a cascade in OpenCV's XML: a model that is whole or a FileError, nothing else. What is whole comes back from its own text
// unchanged.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/cascade_xml.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const ssjs::HaarCascade cascade = ssjs::from_opencv_xml(text, "fuzz.xml");
    if (!(ssjs::from_opencv_xml(ssjs::to_opencv_xml(cascade), "again.xml") == cascade)) std::abort();
  } catch (const ssjs::FileError& error) {
    if (error.path() != "fuzz.xml") std::abort();  // the second reading must not fail
  }
  return 0;
}
