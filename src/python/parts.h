#pragma once
#include <pybind11/pybind11.h>

namespace aberfit::internal {

// Each file of this folder adds a part to the module.
void add_errors(pybind11::module_& module);
void add_studies(pybind11::module_& module);
void add_surfaces(pybind11::module_& module);
void add_theory(pybind11::module_& module);

}  // namespace aberfit::internal
