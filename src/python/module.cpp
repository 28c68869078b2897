// The compiled part of the Python package `aberfit`, whose Python part gives it the names that users see.
#include "parts.h"

PYBIND11_MODULE(_aberfit, module) {
  module.doc() = "Compiled part of aberfit; import `aberfit` instead.";
  module.attr("__version__") = ABERFIT_VERSION;
  aberfit::internal::add_errors(module);
  aberfit::internal::add_surfaces(module);
  aberfit::internal::add_studies(module);
  aberfit::internal::add_theory(module);
}
