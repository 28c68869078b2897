#include "aberfit/core/errors.h"

#include <stdexcept>

#include "parts.h"

namespace py = pybind11;

namespace aberfit::internal {
namespace {

// Python's classes. They live as long as the interpreter.
PyObject *input_error = nullptr, *computation_error = nullptr;

void raise_input_error(const std::string& message, const std::string& file, const std::string& pointer,
                       const std::string& found, const std::string& allowed) {
  const py::object error = py::reinterpret_borrow<py::object>(input_error)(message);
  error.attr("file") = file;
  error.attr("pointer") = pointer;
  error.attr("found") = found;
  error.attr("allowed") = allowed;
  PyErr_SetObject(input_error, error.ptr());
}

void translate(std::exception_ptr problem) {
  if (!problem) return;
  try {
    std::rethrow_exception(problem);
  } catch (const InputError& error) {
    raise_input_error(error.what(), error.file(), error.pointer(), error.found(), error.allowed());
  } catch (const FieldError& error) {
    raise_input_error(error.what(), "", error.field(), error.found(), error.allowed());
  } catch (const ComputationError& error) {
    PyErr_SetString(computation_error, error.what());
  } catch (const Interrupted& error) {
    PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
  }
}

}  // namespace

void add_errors(py::module_& module) {
  input_error = PyErr_NewExceptionWithDoc("aberfit.InputError",
                                          "Bad input. `file`, `pointer` (a JSON pointer into the study), "
                                          "`found` and `allowed` say where, what was "
                                          "found and what is allowed.",
                                          PyExc_ValueError, nullptr);
  computation_error = PyErr_NewExceptionWithDoc(
      "aberfit.ComputationError", "A computation without any result.", PyExc_RuntimeError, nullptr);
  module.attr("InputError") = py::reinterpret_borrow<py::object>(input_error);
  module.attr("ComputationError") = py::reinterpret_borrow<py::object>(computation_error);
  py::register_exception_translator(translate);
}

}  // namespace aberfit::internal
