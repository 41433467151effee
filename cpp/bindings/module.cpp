// ssjs_cli._core: the C++ library seen from Python. Shapes and units as in the headers; long calls release the interpreter lock.
#include <pybind11/pybind11.h>

#include <string>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/base/version.hpp"

namespace ssjs::bindings {

namespace {

/// Messages may quote files, and files may hold anything: what is no UTF-8 is replaced.
void raise(PyObject* type, const std::string& message) {
  PyObject* text = PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "replace");
  if (text == nullptr) return;  // the error that is set by now says why
  PyErr_SetObject(type, text);
  Py_DECREF(text);
}

}  // namespace

void add_errors(py::module_& module) {
  py::register_exception_translator([](std::exception_ptr raised) {
    try {
      if (raised) std::rethrow_exception(raised);
    } catch (const Cancelled&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const FileError& error) {
      raise(PyExc_OSError, error.what());
    } catch (const Error& error) {
      raise(PyExc_ValueError, error.what());
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
  add_levelled(module);
  add_evaluation(module);
  add_simulation(module);
  add_underwater_simulation(module);
  add_features(module);
  add_imaging(module);
  add_segmentation(module);
  add_optical(module);
  add_visual_odometry(module);
  add_mosaic(module);
  add_cascade(module);
  add_survey(module);
  add_sonar_loop(module);
  add_season(module);
  add_io(module);
}
