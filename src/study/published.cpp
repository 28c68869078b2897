#include "aberfit/study/published.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "aberfit/core/constants.h"

namespace aberfit {
namespace {

struct Values {
  double gx, gy, wavelength, focal_length, diameter, rms, correlation_length, f_min, f_max;
  double deflection(double gradient) const { return wavelength / (4 * kPi) * gradient; }
  double per_axis() const { return deflection(std::sqrt((gx * gx + gy * gy) / 2)); }
};

using Formula = std::pair<std::string, std::function<double(const Values&)>>;

const std::vector<Formula>& formulas() {
  static const std::vector<Formula> table = {
      {"total_gradient", [](const Values& v) { return std::hypot(v.gx, v.gy); }},
      {"deflection_x", [](const Values& v) { return v.deflection(v.gx); }},
      {"deflection_y", [](const Values& v) { return v.deflection(v.gy); }},
      {"mean_deflection", [](const Values& v) { return std::sqrt(kPi / 2) * v.per_axis(); }},
      {"rms_deflection", [](const Values& v) { return v.deflection(std::hypot(v.gx, v.gy)); }},
      {"focal_shift_std",
       [](const Values& v) {
         return v.per_axis() * v.diameter / 2 / (v.focal_length * std::numbers::sqrt2);
       }},
      {"largest_angle", [](const Values& v) { return std::asin(v.wavelength * v.f_max); }},
      {"paper_ratio_r",
       [](const Values& v) { return 2 * v.rms * v.diameter / (1.22 * v.wavelength * v.correlation_length); }},
      {"uniform_psd_2d",
       [](const Values& v) { return v.rms * v.rms / (kPi * (v.f_max * v.f_max - v.f_min * v.f_min)); }},
      {"uniform_psd_1d", [](const Values& v) { return v.rms * v.rms / (v.f_max - v.f_min); }},
      {"uniform_slope_total",
       [](const Values& v) {
         return 2 * kPi * v.rms * std::sqrt((v.f_max * v.f_max + v.f_min * v.f_min) / 2);
       }},
  };
  return table;
}

}  // namespace

const std::vector<std::string>& published_formulas() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Formula& formula : formulas()) list.push_back(formula.first);
    return list;
  }();
  return names;
}

double evaluate_formula(const std::string& name, const FormulaInputs& inputs, const Study& study) {
  const double unknown = std::nan("");
  const Values values{inputs.gradient_x.value_or(unknown),
                      inputs.gradient_y.value_or(unknown),
                      inputs.wavelength.value_or(study.wavelength),
                      inputs.focal_length.value_or(study.mirror.focal_length),
                      inputs.diameter.value_or(2 * aperture_radius(study.aperture)),
                      inputs.rms.value_or(unknown),
                      inputs.correlation_length.value_or(unknown),
                      inputs.f_min.value_or(unknown),
                      inputs.f_max.value_or(unknown)};
  for (const Formula& formula : formulas())
    if (formula.first == name) return formula.second(values);
  return unknown;
}

}  // namespace aberfit
