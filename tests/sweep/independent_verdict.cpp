#include "independent_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "independent_waves.h"
#include "independent_width.h"

namespace aberfit {
namespace {

// Errors of the second opinion, as fractions of the energy. kErrorOfWaves comes from grid points at the edge
// of the pupil. The other two are factors of the scattered fraction times (a/f)^2. They cover one transfer
// function for overlaps at the middle and at the rim of the aperture. Largest error against the integral over
// all pairs of points: 0.026 in the focus (f/1.4 to f/3, g 1.5 to 2.5), 0.039 at half of a ring's peak (g
// 4.2, f/2.1).
constexpr double kErrorOfWaves = 5e-4, kErrorInFocus = 0.026, kErrorOutOfFocus = 0.04;
// Seconds for a sine and cosine or a step of a recurrence, and for a sample of a transform with its circles.
constexpr double kSecondsOfTerm = 2e-8, kSecondsOfSample = 3e-7;
constexpr double kPlanesOfRing = 22;
constexpr int kShifts = 8;
constexpr int kMostRays = 16384, kFewestRays = 2048;  // of each shift
constexpr int kHeightsOfRay = 9;                      // one, and eight for its slopes

using Planes = std::map<double, std::vector<std::pair<double, Target>>>;  // by dz: fractions

Planes planes_of(const TargetSets& sets, int most) {
  Planes planes;
  for (const auto* targets : {&sets.fitted, &sets.held_out})
    for (const Target& target : *targets)
      if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic))
        planes[ee->dz].push_back({ee->fraction, target});
  // Of the planes out of focus the nearest ones are left out first.
  while (int(planes.size()) > most) {
    auto nearest = planes.end();
    for (auto plane = planes.begin(); plane != planes.end(); ++plane)
      if (plane->first != 0 && (nearest == planes.end() || std::abs(plane->first) < std::abs(nearest->first)))
        nearest = plane;
    planes.erase(nearest);
  }
  return planes;
}

// scale: energy that is one margin, as a fraction of the study's margin.
void judge(const Study& study, const Target& target, double off, double scale, SecondOpinion* opinion) {
  if (!std::isfinite(off)) off = HUGE_VAL;
  const double margins = std::max(0.0, off) / (study.equivalence.margin * scale);
  if (margins <= opinion->worst) return;  // not where it is NaN
  opinion->worst = margins;
  opinion->statistic = statistic_name(target.statistic);
}

void judge_light(const Study& study, const Target& target, double off, SecondOpinion* opinion) {
  // If the slope of the encircled energy is unknown, we take that of a flat curve.
  judge(study, target, off, target.curve_slope ? aim_of(target).relative_to() : kFlattestCurve, opinion);
}

std::vector<double> radii_of(const std::vector<std::pair<double, Target>>& wanted) {
  std::vector<double> radii;
  for (const auto& [fraction, target] : wanted) radii.push_back(target.value);
  return radii;
}

double largest_radius(const std::vector<std::pair<double, Target>>& wanted) {
  double largest = 0;
  for (const auto& [fraction, target] : wanted) largest = std::max(largest, target.value);
  return largest;
}

// Shifted lattice points over the bounding box of the aperture, by the plastic number (Roberts 2018).
std::vector<std::array<double, 2>> points_in(const Aperture& aperture, int count, int shift) {
  const ApertureBox box = bounding_box(aperture);
  const double share = aperture_area(aperture) / ((box.x1 - box.x0) * (box.y1 - box.y0));
  std::vector<std::array<double, 2>> points;
  const auto part = [](double x) { return x - std::floor(x); };
  for (int i = 0; i < count / share; ++i) {
    const double u = part(0.7548776662466927 * i + 0.6180339887 * shift),
                 v = part(0.5698402909980532 * i + 0.4142135624 * shift);
    const double x = box.x0 + u * (box.x1 - box.x0), y = box.y0 + v * (box.y1 - box.y0);
    if (aperture_contains(aperture, x, y, 0)) points.push_back({x, y});
  }
  return points;
}

// Place and direction of a reflected ray.
struct TracedRay {
  std::array<double, 3> from, along;
  double radius_at(double z) const {
    const double length = (z - from[2]) / along[2];
    return std::hypot(from[0] + length * along[0], from[1] + length * along[1]);
  }
};

TracedRay reflected(double focal_length, const IndependentSurface& surface, double x, double y) {
  auto [p, q] = surface.slopes(x, y);
  p += x / (2 * focal_length);
  q += y / (2 * focal_length);
  const double norm = 1 / std::sqrt(p * p + q * q + 1);
  const std::array<double, 3> normal{-p * norm, -q * norm, norm}, d{0, 0, -1};
  const double into = 2 * d[2] * normal[2];
  return {{x, y, (x * x + y * y) / (4 * focal_length) + surface.height(x, y)},
          {d[0] - into * normal[0], d[1] - into * normal[1], d[2] - into * normal[2]}};
}

// Roughness above the cut scatters energy beyond the field of view of `cells` grid points, which folds back.
// Returns its fraction within `radius`, to first order in the roughness. On a mirror with 573 cycles across,
// 3.4 % of the energy was outside 256 grid points and added 0.7 % to the energy within ee95.
double folded_light(const RadialPsd& psd, double cut, const Study& study, double cells, double radius) {
  constexpr double kStep = 1.01;
  const double diameter = 2 * aperture_radius(study.aperture), wavelength = study.wavelength;
  const double field = cells * wavelength * study.mirror.focal_length / diameter;
  double variance = 0;
  const double end = std::min(psd.f_max(), 1 / wavelength);
  for (double f = std::max(cut, 0.5 * cells / diameter); f < end; f *= kStep) {
    const double to = std::min(kStep * f, end), middle = std::sqrt(f * to);
    variance += 2 * std::numbers::pi * middle * psd(middle) * (to - f);
  }
  const double beyond = std::min(1.0, std::pow(4 * std::numbers::pi / wavelength, 2) * variance);
  return beyond * std::min(1.0, std::numbers::pi * radius * radius / (field * field));
}

double error_of_waves(const Study& study, const Groundwork& ground, std::optional<double> cut,
                      bool in_focus) {
  if (!cut) return kErrorOfWaves;
  const double g = 4 * std::numbers::pi / study.wavelength *
                   psd_moments(ground.psd->band(*cut, 1 / study.wavelength)).rms_height();
  return kErrorOfWaves - (in_focus ? kErrorInFocus : kErrorOutOfFocus) * std::expm1(-g * g) *
                             std::pow(aperture_radius(study.aperture) / study.mirror.focal_length, 2);
}

// lambda f/D, by which each grid point across the aperture widens the field of view.
double airy_unit(const Study& study) {
  return study.wavelength * study.mirror.focal_length / (2 * aperture_radius(study.aperture));
}

// Grid points across that give this field of view and fold little energy into `radius`.
double enough_cells(const Study& study, const Groundwork& ground, double field, double radius,
                    std::optional<double> cut, const OpinionLimits& limits) {
  double needed = std::max(double(limits.smallest_grid), std::ceil(field / airy_unit(study) / 128) * 128);
  if (cut)
    while (needed <= limits.largest_grid &&
           folded_light(*ground.psd, *cut, study, needed, radius) > kErrorOfWaves)
      needed += 128;
  return needed;
}

double seconds_of(double cells_across, const IndependentSurface& surface, double planes) {
  const double cells = cells_across * cells_across;
  return kSecondsOfTerm * cells * surface.cost() + kSecondsOfSample * 16 * cells * planes;
}

std::unique_ptr<IndependentWaves> waves_of(const Study& study, const Groundwork& ground,
                                           const IndependentSurface& surface, std::optional<double> cut,
                                           int cells, double wavelength) {
  auto waves = std::make_unique<IndependentWaves>(study.mirror.focal_length, study.aperture, wavelength,
                                                  surface, cells);
  if (cut) {
    const RadialPsd& psd = *ground.psd;
    waves->scatter([&psd](double f) { return psd(f); }, std::max(*cut, psd.f_min()), psd.f_max());
  }
  return waves;
}

// Encircled energy of the surface itself in focus.
struct CurveInFocus {
  std::vector<double> radius, share;

  CurveInFocus(IndependentWaves* waves, double narrowest, double field) {
    constexpr int kRadii = 256;  // steps of 2.5 %: linear interpolation is good to 1e-4 of the energy
    for (int k = 0; k < kRadii; ++k)
      radius.push_back(narrowest * std::pow(field / narrowest, double(k) / (kRadii - 1)));
    share = waves->shares(0, radius);
  }
  // Returns nothing if `fraction` is not between the first and the last value.
  std::optional<double> radius_of(double fraction) const {
    for (std::size_t k = 1; k < radius.size(); ++k)
      if (share[k] >= fraction && share[k - 1] < fraction)
        return radius[k - 1] +
               (radius[k] - radius[k - 1]) * (fraction - share[k - 1]) / (share[k] - share[k - 1]);
    return std::nullopt;
  }
};

struct RingsOfSurface {
  const Study& study;
  const Groundwork& ground;
  const TargetSets& sets;
  const IndependentSurface& surface;
  std::optional<double> cut;
  const OpinionLimits& limits;

  struct Ring {
    Target target;
    double radius;
  };
  std::vector<Ring> of(IndependentWaves* in_focus, double field) const {
    std::vector<Ring> rings;
    const CurveInFocus own(in_focus, 0.3 * airy_unit(study), field);
    for (const auto* targets : {&sets.fitted, &sets.held_out})
      for (const Target& target : *targets)
        if (const auto* ring = std::get_if<RingFwhm>(&target.statistic)) {
          const std::optional<double> radius =
              ring->ring_radius ? ring->ring_radius : own.radius_of(ring->ring_fraction);
          if (radius) rings.push_back({target, *radius});
        }
    std::sort(rings.begin(), rings.end(), [](const Ring& a, const Ring& b) { return a.radius < b.radius; });
    return rings;
  }

  // in_focus: has a field of view of radius `field`. Rings that would cost too much are skipped.
  void judge_by(IndependentWaves* in_focus, double field, SecondOpinion* opinion) const {
    if (limits.most_rings == 0) return;
    double seconds = limits.seconds;
    const double error = error_of_waves(study, ground, cut, false);
    for (const Ring& ring : of(in_focus, field)) {
      const double cells = enough_cells(study, ground, 6 * ring.radius, ring.radius, cut, limits);
      seconds -= seconds_of(cells, surface, kPlanesOfRing);
      if (!(cells <= limits.largest_grid && seconds > 0) || opinion->rings == limits.most_rings) return;
      ++opinion->rings;
      const auto waves = waves_of(study, ground, surface, cut, int(cells), study.wavelength);
      const auto width = independent_width(
          [&](double dz) { return waves->shares(dz, {ring.radius}).front(); }, ring.target.value);
      const double off =
          width ? std::abs(width->fwhm - ring.target.value) - error * width->per_light : HUGE_VAL;
      judge(study, ring.target, off, ring.target.relative_to(), opinion);
    }
  }
};

}  // namespace

SecondOpinions::SecondOpinions(const Study& study)
    : study_(study), ground_(lay_groundwork(study_)), sets_(make_targets(study_, ground_, 1)) {}

SecondOpinion SecondOpinions::of_waves(const TermSet& terms, const Eigen::VectorXd& coefficients,
                                       std::optional<double> cut, const OpinionLimits& limits) const {
  SecondOpinion opinion;
  Planes planes = planes_of(sets_, limits.most_planes);
  if (limits.narrow_field) {
    // A circle larger than the largest grid holds energy that has folded back several times.
    const double room = limits.largest_grid * airy_unit(study_) / limits.field;
    std::erase_if(planes, [&](const auto& plane) { return largest_radius(plane.second) > room; });
  }
  double largest = 0;
  for (const auto& [dz, wanted] : planes) largest = std::max(largest, largest_radius(wanted));
  if (planes.empty()) {
    opinion.obstacle = "no encircled energy is asked for, or none that the largest grid has room for";
    return opinion;
  }
  double needed = enough_cells(study_, ground_, limits.field * largest, largest, cut, limits);
  if (limits.narrow_field) needed = std::min(needed, double(limits.largest_grid));
  const IndependentSurface surface(study_.mirror, terms, coefficients);
  if (needed > limits.largest_grid || seconds_of(needed, surface, double(planes.size())) > limits.seconds) {
    opinion.obstacle = fmt::format("{:.0f} cells across are too many", needed);
    return opinion;
  }
  // Encircled energies of the wavelengths of a band add.
  std::vector<std::vector<double>> shares;
  std::unique_ptr<IndependentWaves> waves;
  for (const LightLine& line : study_.wavelength.lines()) {
    waves = waves_of(study_, ground_, surface, cut, int(needed), line.wavelength);
    std::size_t at = 0;
    for (const auto& [dz, wanted] : planes) {
      if (at == shares.size()) shares.emplace_back(wanted.size(), 0.0);
      const std::vector<double> of_line = waves->shares(dz, radii_of(wanted));
      for (std::size_t k = 0; k < of_line.size(); ++k) shares[at][k] += line.share * of_line[k];
      ++at;
    }
  }
  std::size_t at = 0;
  for (const auto& [dz, wanted] : planes) {
    const double error = error_of_waves(study_, ground_, cut, dz == 0);
    for (std::size_t k = 0; k < wanted.size(); ++k)
      judge_light(study_, wanted[k].second, std::abs(shares[at][k] - wanted[k].first) - error, &opinion);
    ++at;
  }
  if (study_.wavelength.is_band()) return opinion;
  const RingsOfSurface rings{study_, ground_, sets_, surface, cut, limits};
  rings.judge_by(waves.get(), 0.5 * needed * airy_unit(study_), &opinion);
  return opinion;
}

SecondOpinion SecondOpinions::of_targets(const OpinionLimits& limits) const {
  if (sets_.theory != "ghs") {
    SecondOpinion none;
    none.obstacle = "targets of another theory";
    return none;
  }
  constexpr double kMostObliquity = 0.03;
  if (std::pow(aperture_radius(study_.aperture) / (2 * study_.mirror.focal_length), 2) > kMostObliquity) {
    SecondOpinion none;
    none.obstacle = "the aperture reaches too far from the axis";
    return none;
  }
  TermSet no_terms;
  no_terms.radius = ground_.radius;
  return of_waves(no_terms, {}, ground_.psd->f_min(), limits);
}

SecondOpinion SecondOpinions::of_rays(const TermSet& terms, const Eigen::VectorXd& coefficients,
                                      const OpinionLimits& limits) const {
  SecondOpinion opinion;
  const Planes planes = planes_of(sets_, limits.most_planes);
  const IndependentSurface surface(study_.mirror, terms, coefficients);
  const double rays = std::min(double(kMostRays),
                               limits.seconds / (kShifts * kHeightsOfRay * kSecondsOfTerm * surface.cost()));
  if (planes.empty() || rays < kFewestRays) {
    opinion.obstacle = planes.empty() ? "no encircled energy is asked for" : "too many terms for rays";
    return opinion;
  }
  std::array<std::vector<TracedRay>, kShifts> bundles;
  for (int shift = 0; shift < kShifts; ++shift)
    for (const auto& [x, y] : points_in(study_.aperture, int(rays), shift))
      bundles[std::size_t(shift)].push_back(reflected(study_.mirror.focal_length, surface, x, y));
  for (const auto& [dz, wanted] : planes)
    for (const auto& [fraction, target] : wanted) {
      double sum = 0, squares = 0;
      for (const std::vector<TracedRay>& bundle : bundles) {
        const auto inside =
            std::count_if(bundle.begin(), bundle.end(), [&, z = dz, r = target.value](const TracedRay& ray) {
              return ray.along[2] > 0 && ray.radius_at(study_.mirror.focal_length + z) <= r;
            });
        const double share = double(inside) / double(bundle.size());
        sum += share;
        squares += share * share;
      }
      const double mean = sum / kShifts, variance = std::max(0.0, squares / kShifts - mean * mean);
      judge_light(study_, target, std::abs(mean - fraction) - 3 * std::sqrt(variance / (kShifts - 1)),
                  &opinion);
    }
  return opinion;
}

}  // namespace aberfit
