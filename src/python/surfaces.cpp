// Surfaces of terms as objects.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/forward/term_moments.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/report/exports.h"
#include "aberfit/report/result.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/surface_spectrum.h"
#include "parts.h"
#include "views.h"

namespace py = pybind11;

namespace aberfit::internal {
namespace {

using Row = std::vector<double>;

using TermSurface = GivenSurface;

// Rows: (n, m, a), (fx, fy, A, B), (power, a); see the Python part.
TermSurface make(double radius, const std::vector<Row>& zernike, const std::vector<Row>& fourier,
                 const std::vector<Row>& spherical) {
  TermSurface surface;
  surface.terms.radius = radius;
  std::vector<double> values;
  for (const Row& row : zernike) {
    const ZernikeMode mode{int(row[0]), int(row[1])};
    require_zernike_mode(mode);
    surface.terms.zernike.push_back(mode);
    values.push_back(row[2]);
  }
  for (const Row& row : fourier) {
    surface.terms.fourier.push_back({row[0], row[1]});
    values.insert(values.end(), {row[2], row[3]});
  }
  for (const Row& row : spherical) {
    surface.terms.spherical.push_back(int(row[0]));
    values.push_back(row[1]);
  }
  surface.coefficients = Eigen::Map<Eigen::VectorXd>(values.data(), Eigen::Index(values.size()));
  return surface;
}

std::vector<Row> zernikes_of(const TermSurface& self) {
  std::vector<Row> rows;
  for (std::size_t j = 0; j < self.terms.zernike.size(); ++j) {
    const ZernikeMode mode = self.terms.zernike[j];
    rows.push_back({double(mode.n), double(mode.m), self.coefficients[Eigen::Index(j)]});
  }
  return rows;
}

std::vector<Row> waves_of(const TermSurface& self) {
  std::vector<Row> rows;
  for (std::size_t j = 0; j < self.terms.fourier.size(); ++j) {
    const FourierMode mode = self.terms.fourier[j];
    const Eigen::Index at = self.terms.fourier_begin() + 2 * Eigen::Index(j);
    rows.push_back({mode.fx, mode.fy, self.coefficients[at], self.coefficients[at + 1]});
  }
  return rows;
}

std::vector<Row> powers_of(const TermSurface& self) {
  std::vector<Row> rows;
  for (std::size_t j = 0; j < self.terms.spherical.size(); ++j)
    rows.push_back(
        {double(self.terms.spherical[j]), self.coefficients[self.terms.spherical_begin() + Eigen::Index(j)]});
  return rows;
}

py::tuple field_at(const TermSurface& self, Eigen::ArrayXd x, Eigen::ArrayXd y) {
  SurfaceField field;
  {
    const py::gil_scoped_release release;
    const SurfaceOperator map(self.terms, std::move(x), std::move(y), available_threads());
    map.apply(self.coefficients, &field);
  }
  return py::make_tuple(owned(std::move(field.height)), owned(std::move(field.slope_x)),
                        owned(std::move(field.slope_y)));
}

Aperture aperture_of(const TermSurface& self, double inner_radius) {
  if (inner_radius > 0) return AnnulusAperture{2 * inner_radius, 2 * self.terms.radius};
  return CircleAperture{2 * self.terms.radius};
}

std::pair<double, double> moments(const TermSurface& self, double inner_radius) {
  const py::gil_scoped_release release;
  const auto found =
      term_moments(aperture_of(self, inner_radius), self.terms, self.coefficients, available_threads());
  if (!found) throw ComputationError("the terms have too many cycles across for exact moments");
  return {found->rms_height, found->rms_slope_per_axis};
}

Eigen::VectorXd spectrum(const TermSurface& self, const Eigen::ArrayXd& low, const Eigen::ArrayXd& high) {
  const py::gil_scoped_release release;
  Eigen::VectorXd values;
  zernike_spectrum(self.terms, low, high)->evaluate(self.coefficients, &values, nullptr);
  return values;
}

py::tuple estimated(const TermSurface& self, int grid_size) {
  Eigen::ArrayXd low, high;
  Eigen::VectorXd values;
  {
    const py::gil_scoped_release release;
    estimated_spectrum(self.terms, {}, grid_size, available_threads(), &low, &high)
        ->evaluate(self.coefficients, &values, nullptr);
  }
  return py::make_tuple(low, high, values);
}

// The file of one export as its name and its bytes.
py::tuple exported(const TermSurface& self, const std::string& format, double wavelength, int grid_size,
                   double inner_radius, const std::string& title) {
  const std::vector<std::string>& names = export_names();
  const auto found = std::find(names.begin(), names.end(), format);
  if (found == names.end()) throw std::invalid_argument("unknown format " + format);
  const Aperture aperture = aperture_of(self, inner_radius);
  std::pair<std::string, std::string> file;
  {
    const py::gil_scoped_release release;
    file = export_file(ExportFormat(found - names.begin()),
                       {self.terms, self.coefficients, aperture, wavelength, grid_size, title});
  }
  return py::make_tuple(file.first, py::bytes(file.second));
}

TermSurface read_csv(const std::string& path) {
  TermSurface surface;
  surface.coefficients = read_coefficients_csv(path, &surface.terms);
  return surface;
}

}  // namespace

void add_surfaces(py::module_& module) {
  py::class_<TermSurface>(module, "TermSurface")
      .def(py::init(&make), py::arg("radius"), py::arg("zernike"), py::arg("fourier"), py::arg("spherical"))
      .def_property_readonly("radius", [](const TermSurface& self) { return self.terms.radius; })
      .def_property_readonly("zernike", &zernikes_of)
      .def_property_readonly("fourier", &waves_of)
      .def_property_readonly("spherical", &powers_of)
      .def("field", &field_at)
      .def("moments", &moments)
      .def("spectrum", &spectrum)
      .def("estimated", &estimated)
      .def("exported", &exported)
      .def("csv",
           [](const TermSurface& self) { return coefficients_csv(self.terms, self.coefficients, {}); });
  module.def("read_coefficients_csv", &read_csv);
  module.def("read_codev_zfr", &read_codev_zfr);
  module.def("export_names", &export_names);
  module.def("noll_index", [](int n, int m) { return noll_index({n, m}); });
  module.def("osa_index", [](int n, int m) { return osa_index({n, m}); });
  module.def("fringe_index", [](int n, int m) { return fringe_index({n, m}); });
  module.def("zernike_norm", [](int n, int m) { return zernike_norm({n, m}); });
  const auto pair = [](ZernikeMode mode) { return std::make_pair(mode.n, mode.m); };
  module.def("from_noll", [pair](int j) { return pair(zernike_from_noll(j)); });
  module.def("from_osa", [pair](int j) { return pair(zernike_from_osa(j)); });
  module.def("from_fringe", [pair](int j) { return pair(zernike_from_fringe(j)); });
}

}  // namespace aberfit::internal
