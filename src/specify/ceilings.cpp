#include "aberfit/specify/ceilings.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/roughness/k_correlation.h"
#include "aberfit/specify/solve.h"

namespace aberfit {
namespace {

constexpr double kDefaultLowest = 1, kDefaultHighest = 1000;  // cycles across the aperture
// Heights with g = 4 pi sigma/lambda from 0.01 to 100. Only the first root is needed, so the step is coarse.
constexpr SolveOptions kHeights{.step = 2, .decades = 2};
constexpr int kMostBelow = 2;  // further ranges below it
constexpr double kPerMillimetre = 1000;

// Limiting height of a PSD with a single parameter, its height.
struct Ceiling {
  double rms = kInfinity;
  std::size_t binding = 0;
  std::string reason;
  Specification found;
};

Ceiling ceiling_of(const Task& task, const std::vector<Budget>& budgets,
                   const std::function<PsdModel(double rms)>& psd) {
  const TaskAt task_at = [&](const std::vector<double>& rms) {
    Task changed = task;
    changed.psd = psd(rms[0]);
    return changed;
  };
  SolveUnknown height{"/roughness/psd/rms", task.wavelength / (4 * kPi), Dimension::kLength};
  Ceiling ceiling;
  ceiling.found = solve_specification(task_at, {height}, budgets, kHeights, {});
  // If the perfect mirror meets all budgets, a sufficiently small height does as well.
  const auto perfect_holds = [&] {
    return std::all_of(ceiling.found.perfect.begin(), ceiling.found.perfect.end(),
                       [](const BudgetState& state) { return state.margin > 0; });
  };
  for (int k = 0; k < kMostBelow && ceiling.found.status == SolveStatus::kNoSolution && perfect_holds();
       ++k) {
    height.start *= std::pow(10.0, -2 * kHeights.decades);
    const int so_far = ceiling.found.evaluations;
    ceiling.found = solve_specification(task_at, {height}, budgets, kHeights, {});
    ceiling.found.evaluations += so_far;
  }
  for (const SolvePoint& solution : ceiling.found.solutions) {
    if (!solution.holds_below || !(solution.at[0] < ceiling.rms)) continue;
    ceiling.rms = solution.at[0];
    ceiling.binding = solution.binding;
  }
  ceiling.reason = ceiling.found.reason;
  return ceiling;
}

// Returns S2 at 1 cycle/m of the surface whose profiles have f^-B (Abel's relation, PHYSICS 3).
double surface_of_line(double exponent) { return k_correlation_1d_to_2d({1, 1, exponent}).amplitude; }

class Finder {
 public:
  Finder(const Task& task, const std::vector<Budget>& budgets, const Ceilings& band)
      : task_(task), budgets_(budgets), band_(band) {}

  OctaveCeiling octave(double f, Specification* found) const {
    const double low = f / std::sqrt(2.0), high = f * std::sqrt(2.0);
    Ceiling ceiling = ceiling_of(task_, budgets_, [=](double rms) -> PsdModel {
      return UniformPsd{rms, low, high};
    });
    *found = std::move(ceiling.found);
    return {f, ceiling.rms, ceiling.rms * ceiling.rms / (high - low), ceiling.binding, ceiling.reason};
  }

  LineCeiling line(double exponent, Specification* found) const {
    const auto psd = [&](double rms) -> PsdModel {
      PowerLawPsd law;
      law.rms = rms;
      law.exponent = exponent + 1;
      law.f_min = band_.f_min;
      law.f_max = band_.f_max;
      return law;
    };
    Ceiling ceiling = ceiling_of(task_, budgets_, psd);
    *found = std::move(ceiling.found);
    LineCeiling line{exponent, kInfinity, ceiling.rms, ceiling.binding, kNaN, kNaN, ceiling.reason};
    if (!std::isfinite(line.rms)) return line;
    const RadialPsd surface(psd(line.rms));
    const double middle = std::sqrt(band_.f_min * band_.f_max);
    line.level =
        surface(middle) / surface_of_line(exponent) * middle * std::pow(middle / kPerMillimetre, exponent);
    line.headroom = kInfinity;
    for (const OctaveCeiling& octave : band_.octaves) {
      const double f = octave.frequency;
      const double used = psd_moments(surface.band(f / std::sqrt(2.0), f * std::sqrt(2.0))).rms_height();
      if (!(octave.rms / used < line.headroom)) continue;
      line.headroom = octave.rms / used;
      line.closest = f;
    }
    return line;
  }

 private:
  const Task& task_;
  const std::vector<Budget>& budgets_;
  const Ceilings& band_;
};

void lay_out_band(const Task& task, const CeilingsSpec& asked, Ceilings* ceilings) {
  ceilings->across = 2 * aperture_radius(task.aperture);
  ceilings->f_min = asked.f_min.value_or(kDefaultLowest / ceilings->across);
  ceilings->f_max = asked.f_max.value_or(kDefaultHighest / ceilings->across);
  const double octaves = std::log2(ceilings->f_max / ceilings->f_min);
  if (!(octaves >= 1))
    throw FieldError("solve.ceilings.f_max",
                     fmt::format("{:g} /m with f_min {:g} /m", ceilings->f_max, ceilings->f_min),
                     "f_max at least an octave above f_min");
  const int steps = int(std::lround(2 * (octaves - 1)));
  for (int k = 0; k <= steps; ++k) {
    OctaveCeiling octave;
    octave.frequency =
        ceilings->f_min * std::exp2(0.5 + (steps > 0 ? (octaves - 1) * k / double(steps) : 0.0));
    ceilings->octaves.push_back(octave);
  }
}

void collect(const Specification& found, Ceilings* ceilings) {
  ceilings->evaluations += found.evaluations;
  for (const Warning& warning : found.warnings)
    if (std::none_of(ceilings->warnings.begin(), ceilings->warnings.end(),
                     [&](const Warning& known) { return known.code == warning.code; }))
      ceilings->warnings.push_back(warning);
}

}  // namespace

Ceilings find_ceilings(const Task& task, const CeilingsSpec& asked, const std::vector<Budget>& budgets,
                       const RunContext& context) {
  const auto begun = std::chrono::steady_clock::now();
  Ceilings ceilings;
  for (const Budget& budget : budgets) ceilings.budgets.push_back(at_wavelength(budget, task.wavelength));
  ceilings.focal_length = task.mirror.focal_length;
  lay_out_band(task, asked, &ceilings);
  const Finder finder(task, budgets, ceilings);
  std::vector<OctaveCeiling> octaves(ceilings.octaves.size());
  std::vector<Specification> found(octaves.size());
  parallel_for(octaves.size(), context.threads,
               [&](std::size_t k) { octaves[k] = finder.octave(ceilings.octaves[k].frequency, &found[k]); });
  ceilings.octaves = octaves;
  for (const Specification& one : found) collect(one, &ceilings);
  ceilings.theory = found.front().theory;
  for (const BudgetState& state : found.front().perfect) ceilings.perfect.push_back(state.value);
  for (const Specification& one : found)
    if (one.status == SolveStatus::kNoSolution) ceilings.reason = one.reason;
  if (ceilings.reason.empty()) {
    ceilings.lines.resize(asked.exponents.size());
    std::vector<Specification> of_lines(asked.exponents.size());
    parallel_for(of_lines.size(), context.threads,
                 [&](std::size_t k) { ceilings.lines[k] = finder.line(asked.exponents[k], &of_lines[k]); });
    for (const Specification& one : of_lines) collect(one, &ceilings);
  }
  ceilings.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return ceilings;
}

}  // namespace aberfit
