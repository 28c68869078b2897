#include "verify_branches.h"

#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/focus/counted_ring_width.h"
#include "aberfit/theory/ray_perturbation.h"

namespace aberfit::internal {
namespace {

double weighted_rms(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weight) {
  return std::sqrt((weight * values.square()).sum() / weight.sum());
}

}  // namespace

void add_paper_quantities(const std::string& branch, const Task& task, const Groundwork& ground,
                          const PupilSample& pupil, const RayBundle& nominal, const Branch& b,
                          Quantities* quantities) {
  Quantities& q = *quantities;
  // Angular deflections of the ray on both axes; the phase gradient that gives them is 4 pi/lambda times
  // larger (PHYSICS 9).
  const Eigen::ArrayXd dx = b.rays.tx - nominal.tx, dy = b.rays.ty - nominal.ty;
  const double deflection_x = weighted_rms(dx, pupil.weight), deflection_y = weighted_rms(dy, pupil.weight);
  q[branch + ".deflection_rms_x_rad"] = deflection_x;
  q[branch + ".deflection_rms_y_rad"] = deflection_y;
  q[branch + ".mean_to_rms_deflection"] = std::hypot((pupil.weight * dx).sum(), (pupil.weight * dy).sum()) /
                                          std::hypot(deflection_x, deflection_y);
  const Deflections d = deflections_of(b.rays, nominal);
  q[branch + ".deflection_mean_x"] = d.mean_x;
  q[branch + ".deflection_mean_y"] = d.mean_y;
  q[branch + ".deflection_mean_z"] = d.mean_z;
  q[branch + ".deflection_std_z"] = std::sqrt(d.rms_z * d.rms_z - d.mean_z * d.mean_z);
  q[branch + ".mean_to_mean_deflection"] = std::hypot(d.mean_x, d.mean_y, d.mean_z) / d.mean;
  const double scale = 4 * kPi / task.wavelength;
  q[branch + ".phase_gradient_covariance_rad2_per_m2"] =
      scale * scale * ((d.weight * d.x * d.y).sum() - d.mean_x * d.mean_y);
  q[branch + ".phase_gradient_axis_ratio"] = deflection_x / deflection_y;
  q[branch + ".phase_gradient_rms_x_rad_per_m"] = scale * deflection_x;
  q[branch + ".phase_gradient_rms_y_rad_per_m"] = scale * deflection_y;
  q[branch + ".phase_gradient_rms_rad_per_m"] = scale * std::hypot(deflection_x, deflection_y);
  const FocusInput focus{b.rays, nominal, b.field.height, task.trace.centre};
  const double ring = evaluate_exact(focus, {EncircledEnergyRadius{}}, 1)[0];
  // The paper samples N(z) every 0.1 mm, as far as 20 mm.
  q[branch + ".ring_fwhm_counted_m"] = counted_ring_width(b.rays, ring, 1e-4, 2e-2);
  q[branch + ".ring_fwhm_over_ee90_f_over_r"] =
      evaluate_exact(focus, {RingFwhm{}}, 1)[0] / (ring * task.mirror.focal_length / ground.radius);
}

std::vector<FourierMode> add_published_phase(const Task& task, const PhaseSynthesis& published,
                                             const PupilSample& pupil, const RayBundle& nominal, int threads,
                                             Quantities* quantities) {
  // Each mode stands for a ring of the frequency plane, its width taken with log10 where the measure of
  // log-uniform modes is ln.
  const double decades = std::log10(published.f_max / published.f_min);
  const RandomStream stream(task.trace.pupil.seed, "published-phase");
  TermSet terms;
  terms.radius = aperture_radius(task.aperture);
  Eigen::VectorXd phase(2 * published.modes);
  for (int k = 0; k < published.modes; ++k) {
    const auto [u, v] = stream.uniform_pair(2 * std::uint64_t(k));
    const double f = published.f_min * std::pow(published.f_max / published.f_min, u), angle = 2 * kPi * v;
    terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
    const double amplitude = std::sqrt(published.psd_level * 2 * kPi * f * f * decades / published.modes);
    const double shift = 2 * kPi * stream.uniform(2 * std::uint64_t(k) + 1);
    phase[2 * k] = amplitude * std::cos(shift);
    phase[2 * k + 1] = -amplitude * std::sin(shift);
  }
  SurfaceField field;  // heights are phases [rad] here
  SurfaceOperator(terms, pupil, {threads, {}, {}}).apply(phase, &field);
  Quantities& q = *quantities;
  const double x = weighted_rms(field.slope_x, pupil.weight), y = weighted_rms(field.slope_y, pupil.weight);
  q["published_phase.gradient_rms_x_rad_per_m"] = x;
  q["published_phase.gradient_rms_y_rad_per_m"] = y;
  q["published_phase.gradient_rms_rad_per_m"] = std::hypot(x, y);
  // E |grad Phi|^2 = sum P0 dA (2 pi f)^2 / 2 with E f^4 = (f_max^4 - f_min^4) / (4 ln(f_max/f_min)).
  const double mean_f4 = (std::pow(published.f_max, 4) - std::pow(published.f_min, 4)) /
                         (4 * std::log(published.f_max / published.f_min));
  q["published_phase.gradient_expected_rad_per_m"] =
      std::sqrt(published.psd_level * 2 * kPi * decades * 4 * kPi * kPi * mean_f4 / 2);
  q["published_phase.surface_rms_height_m"] =
      task.wavelength / (4 * kPi) * weighted_rms(field.height, pupil.weight);
  // The rays of those gradients: D = -(lambda/4 pi) grad Phi added to the ray.
  const double scale = task.wavelength / (4 * kPi);
  Eigen::Array2Xd slope(2, pupil.size());
  slope.row(0) = scale * field.slope_x.transpose();
  slope.row(1) = scale * field.slope_y.transpose();
  const RayBundle rays = trace_perturbed(task.mirror, pupil, slope, Convention::kPaper);
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{}, RingFwhm{}, ScatterMean{},
                                             ScatterRms{}};
  const Eigen::VectorXd values =
      evaluate_exact({rays, nominal, Eigen::ArrayXd(), task.trace.centre}, statistics, threads);
  for (std::size_t k = 0; k < statistics.size(); ++k)
    q["published_phase." + statistic_name(statistics[k])] = values[Eigen::Index(k)];
  q["published_phase.psd_level"] = published.psd_level;
  q["published_phase.f_min_per_m"] = published.f_min;
  q["published_phase.f_max_per_m"] = published.f_max;
  return terms.fourier;
}

void add_independent_terms(const Task& task, const IndependentTerms& spec, int threads,
                           Quantities* quantities) {
  TermSet terms;
  terms.radius = aperture_radius(task.aperture);
  terms.zernike = zernike_modes(2, spec.n_max);
  const PupilSample pupil = make_pupil(task.aperture, {PupilLayout::kSobol, 16384, task.trace.pupil.seed});
  const RayBundle nominal = trace_nominal(task.mirror, pupil);
  const SurfaceOperator surface(terms, pupil, {});
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{}, RingFwhm{}, ScatterRms{},
                                             ScatterMean{}};
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), spec.draws);
  parallel_for(std::size_t(spec.draws), threads, [&](std::size_t d) {
    const std::uint64_t seed = RandomStream(task.fit.seed, "independent-terms").bits(d);
    SurfaceField field;
    surface.apply(spec.rms / std::sqrt(double(terms.size())) * draw_white(terms.size(), seed), &field);
    const RayBundle rays = trace(task.mirror, pupil, field);
    values.col(Eigen::Index(d)) =
        evaluate_exact({rays, nominal, field.height, task.trace.centre}, statistics, 1);
  });
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto row = values.row(Eigen::Index(k)).array();
    const double mean = row.mean();
    (*quantities)["independent_terms." + statistic_name(statistics[k])] = mean;
    (*quantities)["independent_terms." + statistic_name(statistics[k]) + ".std"] =
        std::sqrt((row - mean).square().sum() / std::max(1, spec.draws - 1));
  }
}

}  // namespace aberfit::internal
