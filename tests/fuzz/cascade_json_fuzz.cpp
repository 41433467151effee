// Any bytes as a cascade in the project's own JSON: a model that is whole or a FileError, nothing else. What is whole comes back from its
// own text unchanged.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/cascade_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const ssjs::HaarCascade cascade = ssjs::from_json(text, "fuzz.json");
    if (!(ssjs::from_json(ssjs::to_json(cascade), "again.json") == cascade)) std::abort();
  } catch (const ssjs::FileError& error) {
    if (error.path() != "fuzz.json") std::abort();  // the second reading must not fail
  }
  return 0;
}
