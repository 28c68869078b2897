// Theory alone: power spectral densities, and the mean focus of rough mirrors.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cmath>
#include <mutex>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/halo_kernel.h"
#include "aberfit/theory/scatter_function.h"
#include "parts.h"
#include "study_text.h"
#include "views.h"

namespace py = pybind11;

namespace aberfit::internal {
namespace {

template <typename Function>
Eigen::ArrayXd each(const Eigen::ArrayXd& points, const Function& function) {
  return points.unaryExpr(function);
}

// The study of a text whose roughness is needed.
std::shared_ptr<const Study> rough_study(const StudyText& text) {
  const auto study = std::make_shared<const Study>(text.read());
  if (!study->psd) throw InputError(text.path, "/roughness", kMissing, "a roughness is needed");
  return study;
}

RadialPsd in_band(const RadialPsd& psd, double f_min, double f_max) {
  return f_min > 0 || std::isfinite(f_max) ? psd.band(f_min, f_max) : psd;
}

std::pair<double, double> rms_in_band(const RadialPsd& psd, double f_min, double f_max) {
  const PsdMoments found = psd_moments(in_band(psd, f_min, f_max));
  return {found.rms_height(), found.rms_slope_per_axis()};
}

// The mean focus of a mirror, and the scatter of its roughness.
class MeanLight {
 public:
  explicit MeanLight(const StudyText& text)
      : study_(rough_study(text)),
        psd_(*study_->psd),
        spot_(std::make_shared<const GeneralisedHarveyShack>(psd_, study_->mirror, study_->aperture,
                                                             study_->wavelength)),
        light_(mean_light(spot_, study_->wavelength * study_->mirror.focal_length, available_threads())) {}

  const GeneralisedHarveyShack& spot() const { return *spot_; }
  const Study& study() const { return *study_; }
  const FocalLight& light() const { return *light_; }
  const RadialPsd& psd() const { return psd_; }
  ScatterFunction scatter(double f_min, double f_max) const {
    return ScatterFunction(in_band(psd_, f_min, f_max), study_->wavelength);
  }

 private:
  std::shared_ptr<const Study> study_;
  RadialPsd psd_;
  std::shared_ptr<const GeneralisedHarveyShack> spot_;
  std::unique_ptr<const FocalLight> light_;
};

HaloKernel kernel_of(const MeanLight& self, double pixel, int pixels, double f_min, double f_max) {
  return halo_kernel(self.scatter(f_min, f_max), pixel / self.study().mirror.focal_length, pixels);
}

void add_psd(py::module_& module) {
  py::class_<RadialPsd>(module, "RadialPsd")
      .def(py::init([](const StudyText& text) { return RadialPsd(*rough_study(text)->psd); }))
      .def("__call__", [](const RadialPsd& self, const Eigen::ArrayXd& f) { return each(f, self); })
      .def_property_readonly("f_min", &RadialPsd::f_min)
      .def_property_readonly("f_max", &RadialPsd::f_max)
      .def("rms", &rms_in_band)
      .def("autocorrelation",
           [](const RadialPsd& self, const Eigen::ArrayXd& r) { return autocorrelation(self, r); })
      .def("structure_function",
           [](const RadialPsd& self, const Eigen::ArrayXd& r) { return structure_function(self, r); });
}

}  // namespace

void add_theory(py::module_& module) {
  const auto unlocked = py::call_guard<py::gil_scoped_release>();
  add_psd(module);
  module.attr("MOST_PIXELS") = kMostKernelPixels;
  py::class_<HaloKernel>(module, "HaloKernel")
      .def_property_readonly("fraction", [](const HaloKernel& self) { return owned(self.fraction); })
      .def_readonly("core", &HaloKernel::core)
      .def_readonly("halo", &HaloKernel::halo)
      .def_readonly("beyond", &HaloKernel::beyond);
  py::class_<MeanLight>(module, "MeanLight")
      .def(py::init<const StudyText&>(), unlocked)
      .def_property_readonly("focal_length",
                             [](const MeanLight& self) { return self.study().mirror.focal_length; })
      .def(
          "encircled_energy",
          [](const MeanLight& self, const Eigen::ArrayXd& radius, double dz) {
            const MeanSpot plane = self.spot().at_plane(dz);
            return each(radius, [&](double r) { return plane.encircled_energy(r); });
          },
          unlocked)
      .def(
          "irradiance",
          [](const MeanLight& self, const Eigen::ArrayXd& radius, double dz) {
            const MeanSpot plane = self.spot().at_plane(dz);
            return each(radius, [&](double r) { return plane.irradiance(r); });
          },
          unlocked)
      .def(
          "encircled_energy_radius",
          [](const MeanLight& self, const Eigen::ArrayXd& fraction, double dz) {
            const MeanSpot plane = self.spot().at_plane(dz);
            return each(fraction, [&](double share) { return plane.encircled_energy_radius(share); });
          },
          unlocked)
      .def(
          "transfer",
          [](const MeanLight& self, const Eigen::ArrayXd& frequency) {
            return *self.light().round_transfer(frequency);
          },
          unlocked)
      .def(
          "image",
          [](const MeanLight& self, double dz, double half_width, int pixels) {
            return self.light().image(dz, half_width, pixels);
          },
          unlocked)
      .def(
          "bsdf",
          [](const MeanLight& self, const Eigen::ArrayXd& theta, double f_min, double f_max) {
            const ScatterFunction scatter = self.scatter(f_min, f_max);
            return each(theta, [&](double angle) { return scatter.bsdf(angle); });
          },
          unlocked)
      .def(
          "scattered_within",
          [](const MeanLight& self, const Eigen::ArrayXd& theta, double f_min, double f_max) {
            const ScatterFunction scatter = self.scatter(f_min, f_max);
            return each(theta, [&](double angle) { return scatter.within(angle); });
          },
          unlocked)
      .def("halo_kernel", &kernel_of, unlocked)
      .def_property_readonly("g", [](const MeanLight& self) { return self.spot().g(); })
      .def_property_readonly("tis", [](const MeanLight& self) { return self.spot().tis(); })
      .def_property_readonly("psd", &MeanLight::psd);
}

}  // namespace aberfit::internal
