// ssjs_cli._core: the C++ library seen from Python. Shapes and units as in the headers; long calls release the interpreter lock.
#include <pybind11/pybind11.h>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/base/version.hpp"

namespace ssjs::bindings {

void add_errors(py::module_& module) {
  py::register_exception_translator([](std::exception_ptr raised) {
    try {
      if (raised) std::rethrow_exception(raised);
    } catch (const Cancelled&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const FileError& error) {
      PyErr_SetString(PyExc_OSError, error.what());
    } catch (const Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  module.def(
      "version", [] { return std::string(kVersion); }, "Version of the library.");
}

}  // namespace ssjs::bindings

PYBIND11_MODULE(_core, module) {
  module.doc() = "The C++ core of ssjs.";
  using namespace ssjs::bindings;
  add_errors(module);
  add_pipeline(module);
  add_evaluation(module);
  add_simulation(module);
  add_features(module);
  add_cascade(module);
}
