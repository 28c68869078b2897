#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "operator_cases.h"

using namespace aberfit;
using namespace operator_cases;

namespace {

/// All waves with up to `cycles` across the disc of kRadius.
TermSet lattice_of(double cycles) {
  TermSet terms;
  terms.radius = kRadius;
  terms.fourier_pitch = 1 / (2 * kRadius);
  terms.fourier = fourier_lattice(RadialPsd(UniformPsd{1e-7, 0.3 / kRadius, cycles / (2 * kRadius)}),
                                  terms.fourier_pitch);
  return terms;
}

PupilSample sobol(std::int64_t count) {
  return make_pupil(CircleAperture{2 * kRadius}, {PupilLayout::kSobol, count, 3});
}

/// Peak memory of this process [bytes].
double resident() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

OperatorOptions by(FourierMethod method, int threads = 1) { return {threads, {}, method}; }

}  // namespace

// The reference is a sum over terms in long double; aliasing of the kernel is 3e-12.
TEST(FourierLattice, MatchesPlaneWavesInLongDouble) {
  const TermSet terms = lattice_of(20);
  const PupilSample pupil = sobol(100);
  const Eigen::VectorXd c = normals(terms.size(), "lattice-coefficients").matrix();
  SurfaceField field, truth;
  SurfaceOperator(terms, pupil, by(FourierMethod::kLattice)).apply(c, &field);
  truth.resize(pupil.size());
  for (Eigen::Index p = 0; p < pupil.size(); ++p) {
    long double h = 0, hx = 0, hy = 0;
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const long double turn = 2 * std::numbers::pi_v<long double>, a = c[2 * Eigen::Index(k)],
                        b = c[2 * Eigen::Index(k) + 1], fx = terms.fourier[k].fx, fy = terms.fourier[k].fy,
                        phase = turn * (fx * pupil.x[p] + fy * pupil.y[p]);
      h += a * std::cos(phase) + b * std::sin(phase);
      hx += turn * fx * (b * std::cos(phase) - a * std::sin(phase));
      hy += turn * fy * (b * std::cos(phase) - a * std::sin(phase));
    }
    truth.height[p] = double(h), truth.slope_x[p] = double(hx), truth.slope_y[p] = double(hy);
  }
  EXPECT_LT(relative_difference(field, truth), 1e-11);
}

TEST(FourierLattice, AgreesWithPhaseSumsOnRingsGridsAndScatteredPointsAndItsAdjointIsOne) {
  const TermSet terms = lattice_of(31);
  const Eigen::VectorXd c = normals(terms.size(), "lattice-coefficients").matrix();
  for (const PupilSample& pupil : {rings(40, 60), scrambled_grid(61, 47), sobol(2000)}) {
    const SurfaceOperator fast(terms, pupil, by(FourierMethod::kLattice)),
        plain(terms, pupil, by(FourierMethod::kPhaseSums));
    SurfaceField field, truth;
    fast.apply(c, &field);
    plain.apply(c, &truth);
    EXPECT_LT(relative_difference(field, truth), 1e-11);
    const SurfaceField weights = random_field(pupil.size(), "lattice-weights");
    const Eigen::VectorXd gradient = fast.apply_transpose(weights), expected = plain.apply_transpose(weights);
    EXPECT_LT((gradient - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff());
    EXPECT_NEAR(dot(field, weights), c.dot(gradient), 1e-11 * norm(field) * norm(weights));
  }
}

TEST(FourierLattice, HeightsOfManyWeightsAreThoseOfOneAfterTheOther) {
  TermSet terms = lattice_of(12);
  terms.zernike = zernike_modes(2, 4);
  terms.spherical = {4};
  const PupilSample pupil = scrambled_grid(50, 50);
  const SurfaceOperator fast(terms, pupil, {2, {}, {}}), plain(terms, pupil, by(FourierMethod::kPhaseSums));
  for (const std::size_t count : {1u, 8u, 13u}) {
    std::vector<Eigen::ArrayXd> weights;
    for (std::size_t k = 0; k < count; ++k)
      weights.push_back(normals(pupil.size(), ("w" + std::to_string(k)).c_str()));
    const Eigen::MatrixXd sums = fast.apply_transpose_heights(weights),
                          expected = plain.apply_transpose_heights(weights);
    ASSERT_EQ(sums.rows(), terms.size());
    EXPECT_LT((sums - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff());
  }
}

TEST(FourierLattice, TakesEveryPointOfWhichTheBandHasPartOnce) {
  const RadialPsd psd(UniformPsd{1e-7, 7, 20.3});
  const double pitch = 2.5;
  std::set<std::pair<long, long>> found;
  for (const FourierMode& mode : fourier_lattice(psd, pitch))
    EXPECT_TRUE(found.emplace(std::lround(mode.fx / pitch), std::lround(mode.fy / pitch)).second);
  // Brute force: a fine mesh of frequencies, each rounded to its cell.
  std::set<std::pair<long, long>> expected;
  for (double fy = 0; fy < 21; fy += 0.02)
    for (double fx = -21; fx < 21; fx += 0.02) {
      const double f = std::hypot(fx, fy);
      long i = std::lround(fx / pitch), j = std::lround(fy / pitch);
      if (f < psd.f_min() || f > psd.f_max()) continue;
      if (j == 0 && i < 0) i = -i;
      expected.emplace(i, j);
    }
  EXPECT_EQ(found, expected);
}

// The cases are cut cells, steep models and one without an upper end, of which 1e-4 lies beyond.
TEST(FourierLattice, VariancesSumToThatOfTheBand) {
  const std::pair<PsdModel, double> cases[] = {{UniformPsd{1e-7, 5.1, 60}, 1e-6},
                                               {PowerLawPsd{1e-7, {}, 2.5, 5.1, 100}, 1e-6},
                                               {GaussianPsd{1e-7, 0.005}, 2e-4}};
  for (const auto& [model, allowed] : cases) {
    const RadialPsd psd = RadialPsd(model).band(4, kInfinity);
    TermSet terms{kRadius, {}, fourier_lattice(psd, 2.5), {}, 2.5};
    const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
    double sum = 0;
    for (const CoefficientPrior::Block& block : prior.blocks()) sum += 0.5 * block.factor.squaredNorm();
    EXPECT_NEAR(sum / radial_moment(psd, 0), 1, allowed);
  }
}

// Compares the mean periodogram of realisations with S; the only error is the chi^2 of the coefficients.
TEST(FourierLattice, DrawsHaveThePsd) {
  const PowerLawPsd model{1e-7, {}, 2.0, 6, 60};
  const RadialPsd psd(model);
  TermSet terms{kRadius, {}, fourier_lattice(psd, 2.5), {}, 2.5};
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  constexpr int kBins = 5, kDraws = 20;
  double power[kBins] = {}, expected[kBins] = {}, count[kBins] = {};
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::VectorXd c = prior.colour(draw_white(prior.size(), std::uint64_t(draw)));
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const double f = std::hypot(terms.fourier[k].fx, terms.fourier[k].fy);
      const int bin = int((f - 10) / 9);
      if (f < 10 || bin >= kBins) continue;
      const double a = c[2 * Eigen::Index(k)], b = c[2 * Eigen::Index(k) + 1];
      power[bin] += 0.5 * (a * a + b * b) / (2 * 2.5 * 2.5);
      expected[bin] += psd(f);
      count[bin] += 2;
    }
  }
  for (int bin = 0; bin < kBins; ++bin)  // S is curved within a cell: 2 % at 10 /m
    EXPECT_NEAR(power[bin] / expected[bin], 1, 0.02 + 4 * std::sqrt(2 / count[bin])) << bin;
}

TEST(FourierLattice, RefusesModesThatAreOffIt) {
  TermSet terms = lattice_of(5);
  terms.fourier.push_back({1.3, 0});
  EXPECT_THROW(SurfaceOperator(terms, sobol(16), OperatorOptions{}), std::invalid_argument);
  EXPECT_THROW(fourier_lattice(RadialPsd(UniformPsd{1e-7, 5, 1e5}), 2.5), ComputationError);
}

// Nothing of terms^2 or points x terms numbers is stored, for 40,000 coefficients and 26,000 points.
TEST(FourierLattice, MemoryGrowsAsPointsAndTermsOnly) {
  const TermSet terms = lattice_of(113);
  ASSERT_GT(terms.size(), 40000);
  const double before = resident();
  const CoefficientPrior prior = make_prior(
      terms, RadialPsd(UniformPsd{1e-7, 0.3 / kRadius, 113 / (2 * kRadius)}), CovarianceKind::kFull);
  const PupilSample pupil = make_pupil(CircleAperture{2 * kRadius}, {PupilLayout::kGrid, 26000, 1});
  const SurfaceOperator surface(terms, pupil, OperatorOptions{});
  SurfaceField field;
  surface.apply(prior.colour(draw_white(prior.size(), 1)), &field);
  surface.apply_transpose_heights(std::vector<Eigen::ArrayXd>(8, field.height));
  EXPECT_LT(resident() - before, 100e6);
}
