#include "aberfit/method/groundwork.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/image_shift.h"
#include "aberfit/method/plan.h"
#include "aberfit/scene/segments.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/theory/height_on_aperture.h"
#include "aberfit/waves/diffraction_psf.h"
#include "statistic_request.h"

namespace aberfit {
using namespace internal;

namespace {

// Spot scale of a study with given targets: from the first value that determines one.
double scale_of_values(const Task& task) {
  const auto unknown = [](double) { return kNaN; };  // a ring of a fraction
  for (const StatisticRequest& request : task.target.statistics)
    for (const Wanted& one : wanted_by(request, unknown, 0))
      if (const auto sigma = spot_sigma(one.statistic, one.value.value_or(0), task.mirror.focal_length))
        return *sigma;
  throw FieldError("target.statistics", "no given value that determines the spot size",
                   "a roughness block, or a value for an ee, rms_radius, scatter or spot statistic");
}

std::shared_ptr<const GeneralisedHarveyShack> spot_of(const Task& task, const RadialPsd& psd) {
  return std::make_shared<const GeneralisedHarveyShack>(psd, task.mirror, task.aperture, task.wavelength);
}

// Sets the spot of theories that have a transfer function; its scale then includes diffraction.
void set_mean_spot(const Task& task, Groundwork* ground) {
  if (ground->use.theory != Theory::kGhs) return;
  ground->mean_spot = ground->specified_spot = spot_of(task, *ground->psd);
  const double ee90 = ground->use.choice->errors.ghs.ee90;
  if (std::isfinite(ee90)) ground->focal_sigma = ee90 / kGaussianEe90;
  ground->core_sigma = ground->focal_sigma;
  const MeanSpot focus = ground->mean_spot->at_plane(0);
  for (const double fraction : {0.2, 0.5}) {
    const double sigma = gaussian_sigma(focus.encircled_energy_radius(fraction), fraction);
    if (sigma < ground->core_sigma) ground->core_sigma = sigma;
  }
}

// Checks that the default planes lie in front of the mirror, up to five plane units from the focus, or two
// without a core. For a deep spot plane_unit is limited to a tenth of the focal length. If diffraction alone
// is that deep, or slopes are beyond first order, there is no usable focus.
void check_depth(const Task& task, Groundwork* ground) {
  if (!task.target.statistics.empty()) return;
  const double units = ground->default_planes();
  const double f = ground->focal_length, depth = f * ground->core_sigma / ground->radius;
  const double slope = ground->numbers.rms_slope_per_axis;
  const std::string found = fmt::format("with a spot of {} they would be up to {} from the focus",
                                        format_quantity(ground->core_sigma, Dimension::kLength),
                                        format_quantity(units * depth, Dimension::kLength));
  const bool behind = units * depth > f;
  if (behind && law::kSecondOrder * slope * slope > task.equivalence.margin)
    throw FieldError("roughness.psd", "planes out of focus that are too far away: " + found,
                     fmt::format("an RMS slope far below {:.3g} per axis (less height or a lower f_max), or "
                                 "named statistics only in the focus",
                                 slope));
  const double fresnel = ground->radius * ground->radius / (task.wavelength * f);
  const bool rough = 2 * f * slope > ground->numbers.airy_ee90 / kGaussianEe90;
  if (behind && !(rough && fresnel > 1))
    throw FieldError(
        "mirror.focal_length", "planes out of focus that are too far away: " + found,
        fmt::format("a Fresnel number R^2/(lambda f) well above 1, here {:.2g} (a larger aperture, a shorter "
                    "focal length or wavelength), or named statistics only in the focus",
                    fresnel));
  if (ground->is_deep())
    ground->use.warnings.push_back(
        {"deep-focus",
         fmt::format("the default planes are {} depths of focus out of focus: {}. They are limited to {}, "
                     "and rings are left out",
                     units, found, format_quantity(units * ground->default_unit(), Dimension::kLength))});
}

// The closest tolerance of a target that comes from theory.
double closest_tolerance(const Task& task) {
  double closest = task.target.statistics.empty() ? StatisticRequest{}.tolerance : 1;
  for (const StatisticRequest& request : task.target.statistics)
    if (!request.value) closest = std::min(closest, request.tolerance);
  return closest;
}

// Closed forms are of first order in the slope; radii from exact rays differ by 4.6 slope^2 (PHYSICS 5;
// tests/stability/fast_mirror_edge_test.cpp). No surface by rays has the radii, height and scatter angles of
// the closed form at once. Where the tolerance is below that error, automatic targets come from rays with the
// specified slopes: in scenes for which rays are accurate, and in those without a wave theory.
void mind_steep_slopes(const Task& task, const PhysicsRequest& asked, Groundwork* ground) {
  PhysicsChoice& use = ground->use;
  const double slope = ground->numbers.rms_slope_per_axis, error = law::kSecondOrder * slope * slope,
               margin = task.equivalence.margin;
  if (use.model != FocusModel::kRays || use.theory == Theory::kRays ||
      task.target.convention == Convention::kPaper)
    return;
  const bool may_be_of_rays = use.theory == Theory::kGeometric || use.choice->model == FocusModel::kRays;
  if (!asked.theory && !targets_are_given(task) && may_be_of_rays && error > closest_tolerance(task)) {
    if (use.theory == Theory::kGhs) ground->specified_spot = spot_of(task, *ground->psd);
    use.theory = Theory::kRays;
    use.reason += fmt::format(
        " Targets come from rays with random slopes, because at an RMS slope of {:.2g} the first-order "
        "closed forms have radii {} too small.",
        slope, format_percent(error));
  } else if (use.theory == Theory::kGeometric && error > law::kShareOfMargin * margin) {
    use.warnings.push_back(
        {"steep-slopes",
         fmt::format(
             "geometric Harvey-Shack is of first order in the slope. At an RMS slope of {:.2g} its radii are "
             "{} too small, which is not small against a margin of {}; take \"theory\": \"rays\"",
             slope, format_percent(error), format_percent(margin))});
  }
}

}  // namespace

bool Groundwork::has_core() const {
  return use.model != FocusModel::kWaves || !mean_spot ||
         !(mean_spot->surface_transfer(half_side) < law::kUnseenLight);
}

// Without a core, a spot is as wide as its scatter, and every plane shows it. The cone has half of the mean
// square radius at two units from the focus, and 6/7 at five. Farther planes must be named: by waves they
// need finer grids, and a roughness of few modes cannot meet so many statistics (tests/stability).
double Groundwork::default_planes() const { return has_core() ? 5 : 2; }

Groundwork lay_groundwork(const Task& task) { return lay_groundwork(task, requested_physics(task)); }

Groundwork lay_groundwork(const Task& task, const PhysicsRequest& asked) {
  Groundwork ground;
  ground.focal_length = task.mirror.focal_length;
  ground.radius = aperture_radius(task.aperture);
  ground.is_band = task.wavelength.is_band();
  ground.segments_err = has_segment_errors(task.aperture);
  const ApertureBox box = bounding_box(task.aperture);
  ground.half_side = 0.5 * std::min(box.x1 - box.x0, box.y1 - box.y0);
  const auto mind_shift = [&] {
    if (auto shift = image_shift_warning(task)) ground.use.warnings.push_back(std::move(*shift));
  };
  if (!task.psd) {
    ground.use = choose_physics(task, asked, nullptr);
    mind_shift();
    ground.core_sigma = ground.focal_sigma = scale_of_values(task);
    return ground;
  }
  ground.psd.emplace(*task.psd);
  ground.term_psd = ground.psd;
  ground.numbers = scene_numbers(*ground.psd, task.mirror, task.aperture, task.wavelength);
  if (!std::isfinite(ground.numbers.rms_slope_per_axis))
    throw FieldError("roughness.psd", "a PSD whose slope variance is infinite",
                     "a band limit f_max, because rays need a finite slope");
  ground.prior_height_factor = task.target.convention == Convention::kPaper ? 0.5 : 1.0;
  ground.prior_psd.emplace(ground.psd->scaled(ground.prior_height_factor));
  ground.theory.emplace(task.mirror, task.aperture, ground.numbers.rms_slope_per_axis, task.target.convention,
                        rms_height_on(task.aperture, *ground.psd));
  ground.core_sigma = ground.focal_sigma = ground.theory->focal_sigma();
  ground.use = choose_physics(task, asked, &*ground.psd);
  mind_shift();
  mind_steep_slopes(task, asked, &ground);
  set_mean_spot(task, &ground);
  if (ground.specified_spot) ground.numbers.tis = ground.specified_spot->tis();
  if (!ground.has_core())
    ground.farthest_by_cells =
        farthest_plane(task.aperture, ground.focal_length, task.wavelength, law::kMostCells);
  check_depth(task, &ground);
  return ground;
}

int radial_overlap(const TermSet& terms) {
  if (terms.spherical.empty()) return 0;
  std::vector<int> orders;
  for (const ZernikeMode& mode : terms.zernike)
    if (mode.m == 0 && mode.n > 0) orders.push_back(mode.n);
  const int highest = std::max(orders.empty() ? 0 : orders.back(), terms.spherical.back());
  const Quadrature rule = gauss_legendre(highest + 2, 0.0, 1.0);
  Eigen::MatrixXd slopes(rule.nodes.size(), Eigen::Index(orders.size() + terms.spherical.size()));
  for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
    const double rho = rule.nodes[i], weight = std::sqrt(rule.weights[i] * rho);
    Eigen::Index column = 0;
    for (const int n : orders) slopes(i, column++) = weight * zernike({n, 0}, rho, 0.0).dx;
    for (const int power : terms.spherical) slopes(i, column++) = weight * power * std::pow(rho, power - 1);
  }
  slopes.colwise().normalize();
  const Eigen::VectorXd singular = jacobi_singular_values(slopes);
  return int((singular.array() < 1e-9 * singular[0]).count());
}

Warnings scene_warnings(const Task& task, const Groundwork& ground, const TermSet& terms, double captured) {
  Warnings warnings = task.data_warnings;
  warnings.insert(warnings.end(), ground.use.warnings.begin(), ground.use.warnings.end());
  if (ground.use.choice && ground.use.choice->model != FocusModel::kRays &&
      !ground.use.in_light(targets_are_given(task)))
    warnings.push_back({"rays-not-valid", ground.use.reason});
  if (ground.prior_height_factor != 1)
    warnings.push_back({"prior-scaled",
                        "convention `paper` deflects rays half as much as the law of reflection. The "
                        "equivalent physical surface has half the specified height, and so has the prior"});
  if (task.terms.covariance == CovarianceKind::kDiagonal)
    warnings.push_back(
        {"diagonal-covariance",
         "independent coefficients make slopes larger at the rim. Such a surface is not stationary and "
         "differs from a Harvey-Shack target by tens of percent; use covariance `full`"});
  if (ground.psd && !ground.all_scatters() && !task.terms.automatic() &&
      1 - captured > task.equivalence.margin)
    warnings.push_back(
        {"truncated-terms",
         fmt::format("the terms can carry {:.1f} % of the height variance of the specification{}{}",
                     100 * captured, ground.split ? " below the cut" : "",
                     task.terms.zernike
                         ? "; raise n_max"
                         : "; name Zernikes, or leave `terms` out and the program chooses them")});
  if (const int overlap = radial_overlap(terms); overlap > 0)
    warnings.push_back(
        {"m0-overlap", fmt::format("{} combination{} of the m = 0 Zernikes and the spherical powers change{} "
                                   "no ray. Only the sum is determined; the prior splits it",
                                   overlap, overlap == 1 ? "" : "s", overlap == 1 ? "s" : "")});
  return warnings;
}

}  // namespace aberfit
