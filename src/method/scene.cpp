#include "aberfit/method/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/terms/zernike.h"

namespace aberfit {
namespace {

constexpr double kCapturedHeight =
    0.99;  // default order: this share of the height variance that is no piston or tilt
constexpr int kLargestDefaultOrder = 100;
constexpr double kGaussianEe90 = 2.14596602628934724;  // sqrt(2 ln 10), in sigma_f
constexpr double kNoticedShare = 1e-3;                 // a band cut that leaves out less is not worth a word

// Spot scale of a study that gives its targets as values: the first value that has one.
double scale_of_values(const Study& study) {
  for (const StatisticRequest& request : study.target.statistics) {
    const double value = request.value.value_or(0);
    if (request.name.starts_with("ee") && value > 0 && request.planes.front() == 0) {
      const double fraction = std::stod(request.name.substr(2)) / 100;
      return value / std::sqrt(-2 * std::log(1 - fraction));
    }
    if (request.name == "rms_radius" && value > 0) return value / std::numbers::sqrt2;
    if (request.name == "scatter_rms" && value > 0)
      return value * study.mirror.focal_length / std::numbers::sqrt2;
    if (request.name == "scatter_mean" && value > 0)
      return value * study.mirror.focal_length / 1.2533141373155;
    if (request.name == "spot_fwhm" && value > 0) return value / 2.3548200450309493;
    if (const auto* ring = std::get_if<double>(&request.ring); ring && request.name.starts_with("ring"))
      return *ring / 2.146;
  }
  throw InputError(study.path, "/target/statistics", "no value that gives the focal spot a size",
                   "a roughness block, or a value for an ee, rms_radius, scatter or spot statistic");
}

// What reading the tables of the specification left out of them, and what measuring it ran into.
void warn_of_data(const RoughnessModel& node, Warnings* warnings) {
  if (const auto* sum = std::get_if<RoughnessSum>(&node.model))
    for (const RoughnessModel& part : sum->parts) warn_of_data(part, warnings);
  if (const auto* measured = std::get_if<MeasuredPsd>(&node.model)) {
    for (const Warnings* told : {&measured->estimate.warnings, &measured->result.warnings})
      warnings->insert(warnings->end(), told->begin(), told->end());
  }
  const auto* file = std::get_if<PsdTableFile>(&node.model);
  if (!file) return;
  const PsdTableResult& table = file->table;
  if (table.variance_left_out > kNoticedShare || table.slope_variance_left_out > kNoticedShare)
    warnings->push_back(
        {"band-cut",
         fmt::format("the band {:.4g} to {:.4g} /m kept of \"{}\" leaves out {:.1f} % of the table's height "
                     "variance and {:.1f} % of its slope variance; rays follow slopes",
                     table.psd.frequency.front(), table.psd.frequency.back(), file->file,
                     100 * table.variance_left_out, 100 * table.slope_variance_left_out)});
  if (table.not_positive > 0)
    warnings->push_back(
        {"psd-points-left-out",
         fmt::format("{} point{} of \"{}\" left out: the profile PSD rises there and has no isotropic "
                     "two-dimensional counterpart",
                     table.not_positive, table.not_positive == 1 ? "" : "s", file->file)});
}

// Share of the height variance over the aperture that is neither piston nor tilt: what terms from n = 2 on
// can carry.
double movable_share(const Scene& scene) { return 1.0 - captured_fraction(*scene.psd, scene.radius, 0, 1); }

// Theories that have a transfer function; the spot's scale then includes diffraction.
void set_mean_spot(const Study& study, Scene* scene) {
  const bool waves = scene->use.theory == Theory::kGhs;
  if (!waves && scene->use.theory != Theory::kConvolved) return;
  const ModelErrors& errors = scene->use.choice->errors;
  scene->mean_spot = std::make_shared<const GeneralisedHarveyShack>(
      *scene->psd, study.mirror, study.aperture, study.wavelength,
      GhsOptions{waves ? SurfaceModel::kWaves : SurfaceModel::kRays, 0});
  const double ee90 = waves ? errors.ghs.ee90 : errors.convolved.ee90;
  if (std::isfinite(ee90)) scene->focal_sigma = ee90 / kGaussianEe90;
  scene->core_sigma = scene->focal_sigma;
  const MeanSpot focus = scene->mean_spot->at_plane(0);
  for (const double fraction : {0.2, 0.5}) {
    const double sigma = focus.encircled_energy_radius(fraction) / std::sqrt(-2 * std::log(1 - fraction));
    if (sigma < scene->core_sigma) scene->core_sigma = sigma;
  }
}

}  // namespace

Scene make_scene(const Study& study) {
  Scene scene;
  scene.focal_length = study.mirror.focal_length;
  scene.radius = aperture_radius(study.aperture);
  if (!study.roughness) {
    scene.use = decide_model(study, nullptr);
    scene.core_sigma = scene.focal_sigma = scale_of_values(study);
    return scene;
  }
  scene.psd.emplace(psd_model(*study.roughness));
  scene.numbers = scene_numbers(*scene.psd, study.mirror, study.aperture, study.wavelength);
  if (!std::isfinite(scene.numbers.rms_slope_per_axis))
    throw InputError(study.path, "/roughness/psd", "a PSD whose slope variance is infinite",
                     "a band limit f_max: rays need a finite slope");
  scene.prior_height_factor = study.target.convention == Convention::kPaper ? 0.5 : 1.0;
  scene.prior_psd.emplace(scene.psd->scaled(scene.prior_height_factor));
  scene.theory.emplace(study.mirror, study.aperture, scene.numbers.rms_slope_per_axis,
                       study.target.convention, scene.numbers.rms_height);
  scene.core_sigma = scene.focal_sigma = scene.theory->focal_sigma();
  scene.use = decide_model(study, &*scene.psd);
  set_mean_spot(study, &scene);
  return scene;
}

TermSet make_terms(const Study& study, const Scene& scene, double* captured) {
  TermSet terms;
  terms.radius = scene.radius;
  *captured = 0;
  double covered_to = 0;  // frequency up to which the Zernikes stand for the PSD
  if (study.terms.zernike) {
    const ZernikeSpec& spec = *study.terms.zernike;
    int n_max = 0;
    if (spec.n_max) {
      n_max = *spec.n_max;
    } else if (scene.psd) {
      n_max = captured_order(*scene.psd, scene.radius, kCapturedHeight * movable_share(scene),
                             kLargestDefaultOrder);
    } else {
      throw InputError(study.path, "/terms/zernike/n_max", "nothing",
                       "an order: without roughness there is no default");
    }
    terms.zernike = zernike_modes(spec.n_min, n_max);
    covered_to = (n_max + 1) / (2 * kPi * scene.radius);
    if (scene.psd)
      *captured = captured_fraction(*scene.psd, scene.radius, spec.n_min, n_max) /
                  (spec.n_min >= 2 ? movable_share(scene) : 1.0);
  }
  if (study.terms.fourier) {
    if (!scene.psd)
      throw InputError(study.path, "/terms/fourier", "Fourier terms without roughness",
                       "a roughness block: its band places them");
    const double low = std::max(covered_to, scene.psd->f_min());
    if (!(low < scene.psd->f_max()))
      throw InputError(study.path, "/terms/fourier",
                       fmt::format("no band left above the Zernikes' {:.4g} /m", covered_to),
                       "a smaller n_max, or no Fourier terms");
    terms.fourier = fourier_modes(scene.psd->band(low, scene.psd->f_max()), study.terms.fourier->count,
                                  study.terms.fourier->sampling, study.fit.seed);
    *captured = 1;
  }
  terms.spherical = study.terms.spherical;
  return terms;
}

CoefficientPrior make_study_prior(const Study& study, const Scene& scene, const TermSet& terms) {
  std::vector<CoefficientPrior::Block> blocks;
  if (scene.prior_psd) {
    TermSet rough = terms;
    rough.spherical.clear();
    if (rough.size() > 0) blocks = make_prior(rough, *scene.prior_psd, study.terms.covariance).blocks();
  } else if (!terms.zernike.empty()) {
    // No PSD: every Zernike gets the stated RMS.
    CoefficientPrior::Block block;
    for (Eigen::Index j = 0; j < Eigen::Index(terms.zernike.size()); ++j) block.index.push_back(j);
    block.factor =
        study.fit.spherical_rms * Eigen::MatrixXd::Identity(block.index.size(), block.index.size());
    blocks.push_back(std::move(block));
  }
  if (!terms.spherical.empty()) blocks.push_back(spherical_prior_block(terms, study.fit.spherical_rms));
  return CoefficientPrior(terms.size(), std::move(blocks));
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

Warnings scene_warnings(const Study& study, const Scene& scene, const TermSet& terms, double captured) {
  Warnings warnings;
  if (study.roughness) warn_of_data(*study.roughness, &warnings);
  warnings.insert(warnings.end(), scene.use.warnings.begin(), scene.use.warnings.end());
  if (scene.use.too_simple(targets_are_given(study)))
    warnings.push_back({"rays-not-valid", scene.use.reason});
  if (scene.prior_height_factor != 1)
    warnings.push_back({"prior-scaled",
                        "convention `paper` deflects half as much as the law of reflection: the equivalent "
                        "physical surface has half "
                        "the specified height, and the prior is scaled with it"});
  if (study.terms.covariance == CovarianceKind::kDiagonal)
    warnings.push_back({"diagonal-covariance",
                        "independent coefficients pile slope up at the rim: such a surface is not stationary "
                        "and differs from a "
                        "Harvey-Shack target by tens of percent; use covariance `full`"});
  if (scene.psd && captured < kCapturedHeight - 5e-3)
    warnings.push_back(
        {"truncated-terms", fmt::format("the terms can carry {:.1f} % of the height variance of the "
                                        "specification; raise n_max",
                                        100 * captured)});
  if (const int overlap = radial_overlap(terms); overlap > 0)
    warnings.push_back(
        {"m0-overlap",
         fmt::format("{} combination{} of the m = 0 Zernikes and the spherical powers bend{} no ray "
                     "differently: only their sum is determined, the prior splits it",
                     overlap, overlap == 1 ? "" : "s", overlap == 1 ? "s" : "")});
  return warnings;
}

}  // namespace aberfit
