#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "../../src/fit/focus_residuals.h"
#include "fit_scene.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

/// Bins of radial orders: S_b = 1e-3 m^2 times the sum of c_j^2 w_b(n_j), with smooth overlapping weights w
/// in log n. It replaces the ring average of a Zernike surface, which couples neighbouring orders of the same
/// m. The energy at order n lies around f = n / (2 pi R).
class OrderSpectrum : public SurfaceSpectrum {
 public:
  OrderSpectrum(const TermSet& terms, Eigen::Index bins) {
    const double low = std::log(2.0), high = std::log(double(terms.zernike.back().n));
    for (Eigen::Index b = 0; b < bins; ++b) {
      const double centre = low + (high - low) * double(b) / double(bins - 1),
                   width = (high - low) / double(bins);
      Eigen::MatrixXd form = Eigen::MatrixXd::Zero(terms.size(), terms.size());
      for (std::size_t i = 0; i < terms.zernike.size(); ++i)
        for (std::size_t j = 0; j < terms.zernike.size(); ++j) {
          const ZernikeMode p = terms.zernike[i], q = terms.zernike[j];
          if (p.m != q.m || std::abs(p.n - q.n) > 2) continue;
          const double distance = (0.5 * std::log(double(p.n) * q.n) - centre) / width;
          form(Eigen::Index(i), Eigen::Index(j)) =
              (p.n == q.n ? 1e-3 : -2e-4) * std::exp(-0.5 * distance * distance);
        }
      forms_.push_back(form);
    }
  }
  Eigen::Index bins() const override { return Eigen::Index(forms_.size()); }
  void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                Eigen::MatrixXd* jacobian) const override {
    values->resize(bins());
    if (jacobian) jacobian->resize(bins(), coefficients.size());
    for (Eigen::Index b = 0; b < bins(); ++b) {
      const Eigen::VectorXd product = forms_[std::size_t(b)] * coefficients;
      (*values)[b] = coefficients.dot(product);
      if (jacobian) jacobian->row(b) = 2 * product.transpose();
    }
  }

 private:
  std::vector<Eigen::MatrixXd> forms_;
};

Eigen::VectorXd spectrum_of(const SurfaceSpectrum& spectrum, const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd values;
  spectrum.evaluate(coefficients, &values, nullptr);
  return values;
}

/// The PSD of another realisation with a slow tilt of `tilt` in its logarithm.
void ask_for(const SurfaceSpectrum& spectrum, const Eigen::VectorXd& like, double tilt, double tolerance,
             FitProblem* problem) {
  problem->spectrum = &spectrum;
  problem->spectrum_target = spectrum_of(spectrum, like);
  for (Eigen::Index b = 0; b < spectrum.bins(); ++b)
    problem->spectrum_target[b] *= std::exp(tilt * (double(b) / double(spectrum.bins() - 1) - 0.5));
  problem->spectrum_tolerance = Eigen::VectorXd::Constant(spectrum.bins(), tolerance);
}

double worst_log_ratio(const FitProblem& problem, const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXd values = spectrum_of(*problem.spectrum, coefficients);
  return (values.array() / problem.spectrum_target.array()).log().abs().maxCoeff();
}

}  // namespace

TEST(SpectrumResiduals, GradientsHoldAtADrawAndAThousandthOfIt) {
  const FitScene scene(8, {}, 512, PupilLayout::kPolar);
  const OrderSpectrum spectrum(scene.terms, 8);
  for (const double size : {1.0, 1e-3}) {
    const Eigen::VectorXd white = size * draw_white(scene.prior.size(), 2);
    FitProblem problem = scene.problem({});
    ask_for(spectrum, scene.prior.colour(draw_white(scene.prior.size(), 3)), 0.3, 0.05, &problem);
    const SpectrumResiduals residual(problem);
    ceres::NumericDiffOptions how;
    how.ridders_relative_initial_step_size = 1e-2 * size;
    const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
    ceres::GradientChecker checker(&residual, no_manifolds, how);
    std::vector<const double*> blocks;
    Eigen::Index at = 0;
    for (const int length : residual.parameter_block_sizes()) {
      blocks.push_back(white.data() + at);
      at += length;
    }
    ceres::GradientChecker::ProbeResults results;
    constexpr double kPrecision = 1e-8;  // Ridders on a smooth function of moderate size
    checker.Probe(blocks.data(), kPrecision, &results);
    ASSERT_TRUE(results.return_value);
    double largest = 0, error = 0;
    for (std::size_t b = 0; b < results.jacobians.size(); ++b) {
      largest = std::max(largest, results.jacobians[b].cwiseAbs().maxCoeff());
      error = std::max(error, (results.jacobians[b] - results.numeric_jacobians[b]).cwiseAbs().maxCoeff());
    }
    std::printf("at %g of a draw: relative error %.2g of the largest derivative %.3g\n", size,
                error / largest, largest);
    EXPECT_GT(largest, 0);
    EXPECT_LT(error, kPrecision * largest);
  }
}

TEST(SpectralTargets, AreMetTogetherWithFocalStatisticsAndHeight) {
  // The scene of fits/paper-verify; a band of few modes cannot meet 32 targets of another realisation.
  const FitScene scene(28, {}, 16384, PupilLayout::kPolar, 1.0, 2.5, 19.96);
  const OrderSpectrum spectrum(scene.terms, 8);
  const Eigen::VectorXd other = scene.prior.colour(draw_white(scene.prior.size(), 5));
  std::vector<Statistic> statistics;
  for (const double p : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
    for (const double plane : {-1.5, 0.0, 1.5})
      statistics.push_back(EncircledEnergyRadius{p, plane * 2.8 / 0.2 * scene.focal_sigma});
  statistics.push_back(RingFwhm{});
  statistics.push_back(ScatterRms{});
  statistics.push_back(RmsHeight{});
  SurfaceField field;
  scene.surface.apply(other, &field);
  const RayBundle nominal = trace_nominal(scene.mirror, scene.pupil),
                  rays = trace(scene.mirror, scene.pupil, field);
  const Eigen::VectorXd values = evaluate_exact({rays, nominal, field.height}, statistics, 1);
  std::vector<Target> targets;
  for (std::size_t k = 0; k < statistics.size(); ++k)
    targets.push_back({statistics[k], values[Eigen::Index(k)], 0, 2e-3 * values[Eigen::Index(k)]});
  FitProblem problem = scene.problem(targets);
  ask_for(spectrum, other, 0, 0.02, &problem);

  const Eigen::VectorXd start = draw_white(scene.prior.size(), 6);
  FitOptions options;
  options.stop_at = 1;
  double reported = std::numeric_limits<double>::infinity();
  options.progress = [&](const FitProgress& p) { return reported = p.worst_mismatch, true; };
  const FitResult result = calibrate(problem, start, options);
  std::printf("log PSD off by %.3f at the start, %.4f at the end; %d iterations: %s\n",
              worst_log_ratio(problem, scene.prior.colour(start)),
              worst_log_ratio(problem, result.coefficients), result.iterations, result.message.c_str());
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_TRUE(within_tolerance(problem, result, options.stop_at)) << result.message;
  EXPECT_LE(reported, options.stop_at);
  EXPECT_GT(worst_log_ratio(problem, scene.prior.colour(start)), 5 * 0.02);
  EXPECT_LE(worst_log_ratio(problem, result.coefficients), options.stop_at * 0.02 * (1 + 1e-9));
  ASSERT_EQ(result.spectrum.size(), 8);
  const Eigen::VectorXd again = spectrum_of(spectrum, result.coefficients);
  EXPECT_LE((result.spectrum - again).cwiseAbs().maxCoeff(), 1e-12 * again.maxCoeff());
  EXPECT_EQ(result.statistic_std.size(), Eigen::Index(targets.size()));
  EXPECT_EQ(result.singular_values.size(), Eigen::Index(targets.size()) + 8);

  // A result with only its PSD off is not within tolerance.
  FitResult off = result;
  off.spectrum[3] *= 1.05;
  EXPECT_FALSE(within_tolerance(problem, off, 1.0));
  EXPECT_TRUE(within_tolerance(problem, result, 1.0));
}

TEST(SpectralTargets, AloneMakeAFit) {
  const FitScene scene(12, {}, 512, PupilLayout::kPolar);
  const OrderSpectrum spectrum(scene.terms, 8);
  FitProblem problem = scene.problem({});
  ask_for(spectrum, scene.prior.colour(draw_white(scene.prior.size(), 5)), 0.8, 0.01, &problem);
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 6);
  const FitResult result = calibrate(problem, start, {});
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_TRUE(within_tolerance(problem, result, 0.5));
  EXPECT_EQ(result.smooth_statistics.size(), 0);
  EXPECT_LT(result.final_cost, result.initial_cost);
  EXPECT_GT(result.rank, 0);
  EXPECT_LE(result.rank, 8);
  // The data reduce the spread of some coefficients and increase none.
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(scene.prior.size());
  for (Eigen::Index k = 0; k < scene.prior.size(); ++k)
    variance += scene.prior.colour(Eigen::VectorXd::Unit(scene.prior.size(), k)).cwiseAbs2();
  EXPECT_LE((result.coefficient_std.array() / variance.array().sqrt()).maxCoeff(), 1 + 1e-12);
  EXPECT_LT((result.coefficient_std.array() / variance.array().sqrt()).minCoeff(), 0.99);
}

TEST(SpectralTargets, HaveNoValueWhereTheSurfaceIsFlat) {
  const FitScene scene(6, {}, 512, PupilLayout::kPolar);
  const OrderSpectrum spectrum(scene.terms, 4);
  FitProblem problem = scene.problem({});
  ask_for(spectrum, scene.prior.colour(draw_white(scene.prior.size(), 5)), 0, 0.01, &problem);
  const FitResult result = calibrate(problem, Eigen::VectorXd::Zero(scene.prior.size()), {});
  EXPECT_EQ(result.status, FitStatus::kDegenerate);
  EXPECT_NE(result.message.find("PSD bin"), std::string::npos) << result.message;
  const SpectrumResiduals residuals(problem);
  WhiteResiduals::Linearisation here;
  EXPECT_FALSE(residuals.linearise(Eigen::VectorXd::Zero(scene.prior.size()), true, &here));
  EXPECT_FALSE(residuals.linearise(
      Eigen::VectorXd::Constant(scene.prior.size(), std::numeric_limits<double>::quiet_NaN()), true, &here));
}

TEST(SpectralTargets, ThatDoNotFitTheBinsAreRefused) {
  const FitScene scene(6, {}, 512, PupilLayout::kPolar);
  const OrderSpectrum spectrum(scene.terms, 4);
  const Eigen::VectorXd start = draw_white(scene.prior.size(), 6);
  FitProblem problem = scene.problem({});
  ask_for(spectrum, scene.prior.colour(start), 0, 0.01, &problem);
  FitProblem zero = problem, short_of_one = problem, no_spectrum = problem;
  zero.spectrum_target[2] = 0;
  short_of_one.spectrum_tolerance.conservativeResize(3);
  no_spectrum.spectrum = nullptr;
  for (const FitProblem& wrong : {zero, short_of_one, no_spectrum})
    EXPECT_THROW(calibrate(wrong, start, {}), std::invalid_argument);
}

TEST(Calibrate, SaysWhenThereIsNothingToFit) {
  const FitScene scene(4, {}, 512, PupilLayout::kPolar);
  const FitResult result = calibrate(scene.problem({}), draw_white(scene.prior.size(), 1), {});
  EXPECT_EQ(result.status, FitStatus::kDegenerate);
  EXPECT_NE(result.message.find("nothing to fit"), std::string::npos);
}
