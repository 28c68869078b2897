// Normals by central differences against analytic ones. The truth is the derivative of the same cosines in
// long double. The scene has f = 2.8 m, D = 0.4 m, uniform PSD from 2.5 to 1000 cycles/m.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/random.h"
#include "aberfit/trace/central_difference.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kHighest = 1000;         // f_max [cycles/m]
constexpr double kSlopeRms = 6.3242e-6;   // per axis
constexpr double kRounding = 1.2e-19;     // [m rad], tests/stability/README.md
constexpr double kTruncation = 0.0932;    // of u^2, tests/stability/README.md
constexpr double kAnalyticError = 1e-11;  // phases of 2 pi f R = 1300 rad carry 3e-13; seen 8e-13

struct Scene {
  Mirror mirror{.focal_length = 2.8};
  PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kSobol, 1024, 1});
  TermSet terms;
  Eigen::VectorXd coefficients;
  Eigen::ArrayXd slope_x = Eigen::ArrayXd::Zero(1024);  // truth

  // If the PSD is uniform, equal parts of the band's area have equal height variance.
  Scene() {
    constexpr int kModes = 400;
    const RandomStream stream(1, "finite-difference-edge");
    terms.radius = 0.2;
    coefficients.resize(2 * kModes);
    for (int k = 0; k < kModes; ++k) {
      const double f = std::sqrt(2.5 * 2.5 + (kHighest * kHighest - 2.5 * 2.5) * (k + 0.5) / kModes);
      const double angle = 2 * std::numbers::pi * stream.uniform(std::uint64_t(k));
      terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
      coefficients.segment<2>(2 * k) << stream.normal_pair(1000 + std::uint64_t(k))[0],
          stream.normal_pair(1000 + std::uint64_t(k))[1];
    }
    set_truth();
    const double scale = kSlopeRms / std::sqrt(slope_x.square().mean());
    coefficients *= scale;
    set_truth();
  }

  void set_truth() {
    constexpr long double kTwoPiL = 2 * std::numbers::pi_v<long double>;
    for (Eigen::Index i = 0; i < pupil.size(); ++i) {
      long double sum = 0;
      for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
        const auto [fx, fy] = terms.fourier[k];
        const long double phase = kTwoPiL * ((long double)fx * pupil.x[i] + (long double)fy * pupil.y[i]);
        sum += kTwoPiL * fx *
               (coefficients[2 * Eigen::Index(k) + 1] * cosl(phase) -
                coefficients[2 * Eigen::Index(k)] * sinl(phase));
      }
      slope_x[i] = double(sum);
    }
  }

  double error(const SurfaceField& field) const {
    return std::sqrt((field.slope_x - slope_x).square().mean() / slope_x.square().mean());
  }
};

TEST(StabilityEdge, StepOfFiniteDifferenceNormals) {
  const Scene scene;
  SurfaceField analytic;
  SurfaceOperator(scene.terms, scene.pupil, {}).apply(scene.coefficients, &analytic);
  Edge edge("finite_difference_normals", "step d of the central difference [m]",
            "RMS slope error / RMS slope [1]");
  double best = 0, least = 1;
  for (const double step : geometric_steps(1e-9, 1e-2, 36)) {
    const double error = scene.error(
        central_difference_field(scene.mirror, scene.pupil, scene.terms, scene.coefficients, step, 1));
    if (error < least) least = error, best = step;
    edge.add({step, scene.error(analytic), kAnalyticError, false, error});
  }
  const auto truncation = [](double d) {
    const double u = 2 * std::numbers::pi * kHighest * d;
    return kTruncation * u * u;
  };
  const auto rounding = [](double d) { return kRounding / d / kSlopeRms; };
  // Round-off has two parts: of the sag, and of the moved points if d is no multiple of their last bit (up to
  // 1.7 times the constant). Truncation differs by 1.08, because 400 modes are no continuum.
  edge.follows({"round-off 1.2e-19/d rad", rounding, 1e-9, 3e-8, 2});
  edge.follows({"truncation 0.0932 (2 pi fmax d)^2", truncation, 1e-6, 6e-5, 1.15});
  edge.expect();
  // The best step is (2.6e-15/f_max^2)^(1/3); steps of the sweep are a factor of 1.6 apart.
  const double by_law = std::cbrt(2.6e-15 / (kHighest * kHighest));
  EXPECT_LT(std::abs(std::log(best / by_law)), std::log(2.0)) << best << " against " << by_law;
}

}  // namespace
}  // namespace aberfit::test
