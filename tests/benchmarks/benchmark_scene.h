#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit::benchmarks {

constexpr double kRadius = 0.2;  // [m]

/// The paper's mirror: a parabola of f/7 with a diameter of 0.4 m.
inline Mirror parabola() {
  Mirror mirror;
  mirror.focal_length = 2.8;
  return mirror;
}

inline PupilSample circle_pupil(PupilLayout layout, std::int64_t rays, std::uint64_t seed = 1) {
  return make_pupil(CircleAperture{2 * kRadius, 0}, {layout, rays, seed});
}

inline TermSet zernike_terms(int n_max) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(0, n_max);
  return terms;
}

/// Roughness that Zernikes to n_max can carry: 100 nm RMS, uniform from 2.5 /m to their cut-off frequency.
inline RadialPsd roughness_for(int n_max) {
  return RadialPsd(UniformPsd{100e-9, 2.5, std::max(4.0, (n_max + 1) / (2 * std::numbers::pi * kRadius))});
}

/// Independent normal coefficients with 100 nm RMS in all.
inline Eigen::VectorXd random_coefficients(Eigen::Index size, std::uint64_t seed = 1) {
  return 100e-9 / std::sqrt(double(size)) * draw_white(size, seed);
}

inline SurfaceField random_field(Eigen::Index size, std::uint64_t seed) {
  const RandomStream stream(seed, "benchmark weights");
  SurfaceField field;
  field.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    field.height[i] = stream.normal(3 * std::uint64_t(i));
    field.slope_x[i] = stream.normal(3 * std::uint64_t(i) + 1);
    field.slope_y[i] = stream.normal(3 * std::uint64_t(i) + 2);
  }
  return field;
}

/// Everything between coefficients and focal statistics.
struct Scene {
  Mirror mirror = parabola();
  PupilSample pupil;
  SurfaceOperator surface;
  CoefficientPrior prior;
  double focal_sigma = 0;  ///< of realisation 1 [m]

  Scene(TermSet terms, CoefficientPrior prior_of_terms, PupilSample points, int threads = 1)
      : pupil(std::move(points)),
        surface(std::move(terms), pupil, {threads, {}, {}}),
        prior(std::move(prior_of_terms)) {
    const RayBundle rays = trace(mirror, pupil, draw(1));
    focal_sigma = std::sqrt((pupil.weight * (rays.x.square() + rays.y.square())).sum() / 2);
  }
  Scene(int n_max, PupilSample points, int threads = 1)
      : Scene(zernike_terms(n_max),
              make_prior(zernike_terms(n_max), roughness_for(n_max), CovarianceKind::kFull),
              std::move(points), threads) {}

  /// Surface of a seeded realisation of the prior.
  SurfaceField draw(std::uint64_t seed) const {
    SurfaceField field;
    surface.apply(prior.colour(draw_white(prior.size(), seed)), &field);
    return field;
  }
  /// Exact statistics of the traced surface.
  Eigen::VectorXd exact(const SurfaceField& field, const std::vector<Statistic>& statistics) const {
    const RayBundle nominal = trace_nominal(mirror, pupil), rays = trace(mirror, pupil, field);
    return evaluate_exact({rays, nominal, field.height}, statistics, 1);
  }
  FitProblem problem(std::vector<Target> targets) const {
    return {{mirror, pupil, surface}, prior, std::move(targets), {}, focal_sigma};
  }
};

/// Ten EE radii at focus, ring FWHM, scatter RMS.
inline std::vector<Statistic> twelve_statistics() {
  std::vector<Statistic> statistics;
  for (const double fraction : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95})
    statistics.push_back(EncircledEnergyRadius{fraction, 0});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  return statistics;
}

/// The default statistics: seven EE radii in nine planes (offsets in units of f sigma_f / R), ring FWHM,
/// scatter RMS, RMS height.
inline std::vector<Statistic> default_statistics(double plane_unit) {
  std::vector<Statistic> statistics;
  for (const double units : {0.0, -1.0, 1.0, -2.0, 2.0, -3.5, 3.5, -5.0, 5.0})
    for (const double fraction : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
      statistics.push_back(EncircledEnergyRadius{fraction, units * plane_unit});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  statistics.push_back(RmsHeight{});
  return statistics;
}

/// Statistics as targets, each with its exact value for another realisation and the relative tolerance
/// `tolerance`.
inline std::vector<Target> targets_of(const Scene& scene, const std::vector<Statistic>& statistics,
                                      std::uint64_t seed, double tolerance) {
  const SurfaceField field = scene.draw(seed);
  const Eigen::VectorXd values = scene.exact(field, statistics);
  std::vector<Target> targets;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const double value = values[Eigen::Index(k)];
    targets.push_back({statistics[k], value, 0, tolerance * value});
  }
  return targets;
}

/// Largest difference between `analytic`, the derivatives of statistics along some direction, and
/// fourth-order central differences of at(t). Each statistic is in units of its value, relative to the
/// largest derivative. The step is small compared with the half-width of the kernel (0.02) and with the
/// distance between jumps of the ring FWHM, which moves from peak to peak of a ragged N(z) if rays are few.
template <typename ValuesAt>
double derivative_error(const ValuesAt& at, const Eigen::VectorXd& values, const Eigen::VectorXd& analytic) {
  const double step = 1e-5;
  const Eigen::VectorXd differenced =
      (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
  const Eigen::ArrayXd unit = values.array().abs();
  return ((analytic - differenced).array() / unit).abs().maxCoeff() /
         (differenced.array() / unit).abs().maxCoeff();
}
/// Allowed error of a derivative: rays on the edges of the kernel, where it has a kink, cost (step / width)^2
/// = 2.5e-7, round-off eps / step = 2e-11; largest seen 1.6e-7.
constexpr double kDerivativeAllowed = 1e-6;

}  // namespace aberfit::benchmarks
