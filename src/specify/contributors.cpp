#include "aberfit/specify/contributors.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/roughness/k_correlation.h"
#include "aberfit/scene/aperture.h"
#include "budget_values.h"

namespace aberfit {
using namespace internal;

namespace {

// For Kolmogorov's phase PSD r0^(-5/3) f^(-11/3): Gamma(11/6)^2/(2 pi^(11/3)) (24/5 Gamma(6/5))^(5/6).
double kolmogorov_constant() {
  return std::pow(std::tgamma(11.0 / 6), 2) / (2 * std::pow(kPi, 11.0 / 3)) *
         std::pow(4.8 * std::tgamma(1.2), 5.0 / 6);
}
constexpr double kFinestTurbulence = 1e4;  // in units of 1/r0
constexpr double kNormal = 1e-12;          // limit of (1 - cos)/(1 + cos) for normal incidence
constexpr double kOfDirections = 1e-6;     // error of the mean over directions for inclined beams
constexpr int kFewest = 4, kMost = 64;     // directions in a quarter turn
constexpr double kTilting = 100;           // correlation length of jitter over the aperture

PsdModel sum_of(const std::vector<std::pair<std::string, PsdModel>>& surfaces, std::size_t without) {
  SumPsd sum;
  for (std::size_t k = 0; k < surfaces.size(); ++k)
    if (k != without) sum.parts.push_back(surfaces[k].second);
  return sum.parts.size() == 1 ? sum.parts.front() : PsdModel(sum);
}

constexpr std::size_t kAll = std::size_t(-1);

double across(const Task& task) { return 2 * aperture_radius(task.aperture); }

}  // namespace

// With c = cos(incidence), a beam with coordinates x (along the plane of incidence) and y meets the surface
// at (x/c, y) with the effective height c h, whose PSD is c^3 S(|(c f cos t, f sin t)|) in the direction t.
// The mean over directions is a sum of PSDs with frequencies scaled by 1/hypot(c cos t, sin t), at midpoints
// of a quarter turn; the error falls as ((1 - c)/(1 + c))^(2 directions).
PsdModel in_pupil(const OtherSurface& surface) {
  const double cosine = std::cos(surface.incidence), halved = surface.is_wavefront ? 0.5 : 1;
  const double base = (1 - cosine) / (1 + cosine);
  if (base < kNormal) return scaled(surface.psd, cosine * halved, surface.footprint);
  const int count =
      std::clamp(int(std::ceil(0.5 * std::log(kOfDirections) / std::log(base))), kFewest, kMost);
  SumPsd sum;
  for (int k = 0; k < count; ++k) {
    const double t = 0.5 * kPi * (k + 0.5) / count;
    const double stretch = 1 / std::hypot(cosine * std::cos(t), std::sin(t));
    const double heights = halved * stretch * std::sqrt(std::pow(cosine, 3) / count);
    sum.parts.push_back(scaled(surface.psd, heights, stretch * surface.footprint));
  }
  return sum;
}

PsdModel in_pupil(const Atmosphere& atmosphere) {
  PowerLawPsd law;
  law.amplitude = std::pow(atmosphere.wavelength / (4 * kPi), 2) * kolmogorov_constant() *
                  std::pow(atmosphere.r0, -5.0 / 3);
  law.exponent = 11.0 / 3;
  law.f_max = kFinestTurbulence / atmosphere.r0;
  if (atmosphere.outer_scale > 0)
    return k_correlation_model({*law.amplitude * std::pow(atmosphere.outer_scale, law.exponent),
                                atmosphere.outer_scale, law.exponent},
                               0, law.f_max);
  return law;
}

// exp(-2 pi^2 jitter^2 x^2/lambda^2) over shears x of the pupil, as (4 pi/lambda)^2 rms^2 x^2/length^2.
PsdModel in_pupil_of_jitter(double jitter, double across) {
  const double length = kTilting * across;
  return GaussianPsd{jitter * length / std::sqrt(8.0), length};
}

std::vector<std::pair<std::string, PsdModel>> pupil_surfaces(const PsdModel& own, const Contributors& others,
                                                             double across) {
  std::vector<std::pair<std::string, PsdModel>> surfaces{{"mirror", own}};
  for (const OtherSurface& surface : others.surfaces) surfaces.emplace_back(surface.name, in_pupil(surface));
  if (others.atmosphere) surfaces.emplace_back("atmosphere", in_pupil(*others.atmosphere));
  if (others.jitter > 0) surfaces.emplace_back("jitter", in_pupil_of_jitter(others.jitter, across));
  return surfaces;
}

TaskAt with_contributors(const TaskAt& own, const Contributors& others, const std::vector<Budget>& budgets) {
  for (const Budget& budget : budgets) {
    const bool is_light =
        budget.of_light
            ? !std::holds_alternative<PatchBsdf>(*budget.of_light)
            : !budget.of_surface && std::holds_alternative<EncircledEnergyRadius>(budget.statistic);
    if (!is_light)
      throw FieldError("solve.so_that", budget.key + " with other contributors",
                       "ee radii and diameters, hew, ensquared sides, fwhm, strehl, tis, mtf, pssn (a path "
                       "of several mirrors has no height and no scatter function)");
  }
  return [own, others](const std::vector<double>& values) {
    Task task = own(values);
    task.psd = sum_of(pupil_surfaces(*task.psd, others, across(task)), kAll);
    return task;
  };
}

std::vector<BudgetUse> uses_of_budget(const Task& own, const Contributors& others,
                                      const std::vector<Budget>& budgets, int threads) {
  const auto surfaces = pupil_surfaces(*own.psd, others, across(own));
  const std::vector<SolveUnknown> none;
  const auto values_of = [&](const PsdModel& psd) {
    const TaskAt task_at = [&](const std::vector<double>&) {
      Task task = own;
      task.psd = psd;
      return task;
    };
    const Eigen::ArrayXd values = BudgetValues(task_at, none, budgets, Theory::kGhs, 0, 1).at({});
    return std::vector<double>(values.begin(), values.end());
  };
  std::vector<BudgetUse> uses(surfaces.size());
  parallel_for(surfaces.size(), threads, [&](std::size_t k) {
    uses[k].name = surfaces[k].first;
    uses[k].alone = values_of(surfaces[k].second);
    uses[k].without = values_of(surfaces.size() > 1 ? sum_of(surfaces, k) : surfaces[k].second);
  });
  return uses;
}

}  // namespace aberfit
