#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/terms/modal_covariance.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

TermSet zernikes(int n_min, int n_max, double radius = 0.2) {
  return {radius, zernike_modes(n_min, n_max), {}, {}};
}

Eigen::MatrixXd covariance_of(const CoefficientPrior& prior) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(prior.size(), prior.size());
  for (const auto& block : prior.blocks()) {
    const Eigen::MatrixXd part = block.factor * block.factor.transpose();
    for (std::size_t i = 0; i < block.index.size(); ++i)
      for (std::size_t k = 0; k < block.index.size(); ++k)
        c(block.index[i], block.index[k]) = part(Eigen::Index(i), Eigen::Index(k));
  }
  return c;
}

double variance_sum(const CoefficientPrior& prior, Eigen::Index begin, Eigen::Index end) {
  return covariance_of(prior).diagonal().segment(begin, end - begin).sum();
}

}  // namespace

TEST(CoefficientPrior, CarriesTheCovarianceOfEveryPairOfTerms) {
  const RadialPsd psd(KCorrelationPsd{1e-7, 0.05, 3.2, 1, kInf});
  const TermSet terms = zernikes(2, 12);
  const Eigen::MatrixXd c = covariance_of(make_prior(terms, psd, CovarianceKind::kFull));
  const Eigen::MatrixXd d = covariance_of(make_prior(terms, psd, CovarianceKind::kDiagonal));
  for (std::size_t i = 0; i < terms.zernike.size(); ++i)
    for (std::size_t k = 0; k < terms.zernike.size(); ++k) {
      const ZernikeMode a = terms.zernike[i], b = terms.zernike[k];
      double truth = 0;
      if (a.m == b.m && a.n == b.n) truth = zernike_covariance(psd, 0.2, a.m, {a.n})(0, 0);
      if (a.m == b.m && a.n < b.n) truth = zernike_covariance(psd, 0.2, a.m, {a.n, b.n})(0, 1);
      if (a.m == b.m && a.n > b.n) truth = zernike_covariance(psd, 0.2, a.m, {b.n, a.n})(0, 1);
      const Eigen::Index p = Eigen::Index(i), q = Eigen::Index(k);
      const double scale = std::sqrt(c(p, p) * c(q, q));
      EXPECT_NEAR(c(p, q), truth, 1e-12 * scale);
      EXPECT_NEAR(d(p, q), p == q ? truth : 0, 1e-12 * scale);
    }
}

TEST(CoefficientPrior, DrawsHaveItsCovariance) {
  // 20000 seeds. An entry of the sample covariance has the variance (C_jj C_kk + C_jk^2)/N. All 18*19/2 = 171
  // entries must be within 4.9 standard errors, which fails by chance for one in 6000 sets of seeds (Gaussian
  // tail 1e-6 each).
  const RadialPsd psd(UniformPsd{1e-7, 2.5, 19.96});
  const TermSet terms = zernikes(2, 5);
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  const Eigen::MatrixXd truth = covariance_of(prior);
  const int draws = 20000;
  Eigen::MatrixXd sample = Eigen::MatrixXd::Zero(prior.size(), prior.size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(prior.size());
  for (int seed = 0; seed < draws; ++seed) {
    const Eigen::VectorXd c = prior.colour(draw_white(prior.size(), std::uint64_t(seed)));
    sample += c * c.transpose() / draws;
    mean += c / draws;
  }
  for (Eigen::Index i = 0; i < prior.size(); ++i) {
    EXPECT_LT(std::abs(mean[i]), 4.9 * std::sqrt(truth(i, i) / draws));
    for (Eigen::Index k = 0; k <= i; ++k) {
      const double error = std::sqrt((truth(i, i) * truth(k, k) + truth(i, k) * truth(i, k)) / draws);
      EXPECT_LT(std::abs(sample(i, k) - truth(i, k)), 4.9 * error) << i << " " << k;
    }
  }
}

TEST(CoefficientPrior, AgreesWithRandomPhaseSurfacesProjectedOnTheTerms) {
  // Second method: single plane waves of random direction, phase and frequency (uniform over the band's
  // area), projected on the modes by polar quadrature. The mean of products over waves times 2 sigma^2 cos^2
  // is the covariance. All 6 pairs of n = 2, 4, 6 at m = 2 must be within 4.9 standard errors.
  const double radius = 0.2, sigma = 1e-7, f_min = 2.5, f_max = 8.0;
  const int waves = 4000, rings = 40, angles = 64;
  const RandomStream stream(17, "AgreesWithRandomPhaseSurfacesProjectedOnTheTerms");
  const auto radial = [](int n, double s) {  // polynomial of R_n^2 in s = rho^2
    if (n == 2) return s;
    if (n == 4) return s * (4 * s - 3);
    return s * (15 * s * s - 20 * s + 6);
  };
  std::vector<Eigen::Vector3d> projections;
  for (int wave = 0; wave < waves; ++wave) {
    const auto [u, v] = stream.uniform_pair(std::uint64_t(2 * wave));
    const double phase = 2 * pi * stream.uniform(std::uint64_t(2 * wave + 1));
    const double f = std::sqrt(f_min * f_min + u * (f_max * f_max - f_min * f_min));
    const double fx = f * std::cos(2 * pi * v), fy = f * std::sin(2 * pi * v);
    Eigen::Vector3d a = Eigen::Vector3d::Zero();
    for (int i = 0; i < rings; ++i) {
      // Composite two-point Gauss rule in s = rho^2: error h^4/4320 of the fourth derivative, below 1e-5.
      for (const double g : {-0.5 / std::sqrt(3.0), 0.5 / std::sqrt(3.0)}) {
        const double s = (i + 0.5 + g) / rings, rho = std::sqrt(s);
        double harmonic = 0;
        for (int k = 0; k < angles; ++k) {
          const double angle = 2 * pi * k / angles;
          harmonic += std::cos(2 * angle) / angles *
                      std::cos(2 * pi * radius * rho * (fx * std::cos(angle) + fy * std::sin(angle)) + phase);
        }
        for (int n = 0; n < 3; ++n)
          a[n] += 0.5 / rings * std::sqrt(2.0 * (2 * n + 3)) * radial(2 + 2 * n, s) * harmonic;
      }
    }
    projections.push_back(std::sqrt(2.0) * sigma * a);
  }
  const Eigen::MatrixXd truth =
      zernike_covariance(RadialPsd(UniformPsd{sigma, f_min, f_max}), radius, 2, {2, 4, 6});
  for (int p = 0; p < 3; ++p)
    for (int q = 0; q <= p; ++q) {
      double mean = 0, square = 0;
      for (const auto& a : projections) {
        mean += a[p] * a[q] / waves;
        square += a[p] * a[q] * a[p] * a[q] / waves;
      }
      const double error = std::sqrt((square - mean * mean) / waves);
      EXPECT_LT(std::abs(mean - truth(p, q)), 4.9 * error) << p << q;
      EXPECT_LT(error, 0.1 * std::sqrt(truth(p, p) * truth(q, q)));  // shows that the test has enough waves
    }
}

TEST(CoefficientPrior, ColourTransposeIsItsAdjoint) {
  const RadialPsd psd(KCorrelationPsd{1e-7, 0.05, 2.6, 0.1, kInf});
  TermSet terms = zernikes(2, 20);
  terms.fourier = fourier_modes(psd.band(21 / (2 * pi * 0.2), kInf), 30, 3);
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  const Eigen::VectorXd x = draw_white(prior.size(), 5);
  const Eigen::VectorXd g = draw_white(prior.size(), 6);
  EXPECT_NEAR(g.dot(prior.colour(x)), prior.colour_transpose(g).dot(x),
              1e-13 * prior.colour(x).norm() * g.norm());
}

TEST(CoefficientPrior, RankDeficientBlocksStillColour) {
  // 2 pi R f_max = 5 but n goes to 40, so the high orders are combinations of few waves.
  const RadialPsd psd(UniformPsd{1e-7, 2.5, 4.0});
  const TermSet terms = zernikes(0, 40);
  const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  ASSERT_TRUE(prior.colour(draw_white(prior.size(), 1)).allFinite());
  const Eigen::MatrixXd truth = zernike_covariance(psd, 0.2, 0, {0, 2, 4, 6, 30, 40});
  const Eigen::MatrixXd built = covariance_of(prior);
  const std::vector<int> orders = {0, 2, 4, 6, 30, 40};
  for (std::size_t i = 0; i < orders.size(); ++i) {
    const Eigen::Index at = orders[i] * (orders[i] + 2) / 2;  // OSA index of m = 0
    EXPECT_NEAR(built(at, at) / truth(Eigen::Index(i), Eigen::Index(i)), 1, 1e-9) << orders[i];
  }
}

TEST(CoefficientPrior, SplitsThePsdBetweenZernikeAndFourierTerms) {
  const RadialPsd psd(UniformPsd{1e-7, 2.5, 39.92});
  TermSet terms = zernikes(0, 14);
  const double split = 15 / (2 * pi * 0.2);
  const RadialPsd low = psd.band(0, split), high = psd.band(split, kInf);
  for (const double pitch : {0.0, 2.5}) {
    terms.fourier_pitch = pitch;
    terms.fourier = pitch > 0 ? fourier_lattice(high, pitch) : fourier_modes(high, 200, 9);
    const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
    const double of_zernikes = variance_sum(prior, 0, terms.fourier_begin());
    const double of_waves = 0.5 * variance_sum(prior, terms.fourier_begin(), prior.size());
    EXPECT_NEAR(of_waves / psd_moments(high).height_variance, 1, pitch > 0 ? 1e-7 : 1e-12);
    EXPECT_NEAR(of_zernikes / psd_moments(low).height_variance, captured_fraction(low, 0.2, 0, 14), 1e-12);
  }
}

TEST(SphericalPriorBlock, GivesOrthonormalCombinationsOfTheWantedRms) {
  // <h^2> by quadrature over rho is rms^2 for every unit white vector; cross products vanish.
  TermSet terms{0.2, {}, {}, {4, 6, 8, 10, 12}};
  const auto block = spherical_prior_block(terms, 3e-8);
  const Quadrature disc =
      gauss_legendre(16, 0.0, 1.0);  // in rho^2, uniform over the disc; exact for these polynomials
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(5, 5);
  for (int i = 0; i < 16; ++i) {
    Eigen::VectorXd power(5);
    for (int k = 0; k < 5; ++k) power[k] = std::pow(disc.nodes[i], k + 2);
    const Eigen::VectorXd height = block.factor.transpose() * power;
    product += disc.weights[i] * height * height.transpose();
  }
  // The Gram matrix of these powers has the condition 1e7: bound 1e7 eps, largest error 2e-10.
  EXPECT_LT((product / 9e-16 - Eigen::MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff(), 2e-9);
  EXPECT_EQ(block.index, (std::vector<Eigen::Index>{0, 1, 2, 3, 4}));
}

TEST(DrawWhite, IsAPrefixOfLongerDrawsAndDiffersBetweenSeeds) {
  EXPECT_EQ(draw_white(7, 4), draw_white(20, 4).head(7));
  EXPECT_NE(draw_white(7, 4), draw_white(7, 5));
}

TEST(FourierModes, FillTheHalfPlaneOfTheBand) {
  const std::vector<PsdModel> models = {UniformPsd{1e-7, 2.5, 39.92}, UniformPsd{1e-7, 0, 40},
                                        KCorrelationPsd{1e-7, 0.02, 3, 0, kInf}, GaussianPsd{1e-7, 0.02}};
  for (const PsdModel& model : models) {
    const RadialPsd psd(model);
    const auto modes = fourier_modes(psd, 150, 1);
    ASSERT_EQ(modes.size(), 150u);
    for (const FourierMode& mode : modes) {
      const double f = std::hypot(mode.fx, mode.fy);
      EXPECT_TRUE(f >= psd.f_min() * (1 - 1e-12) && f <= psd.f_max() && f > 0);
      EXPECT_TRUE(mode.fy > 0 || (mode.fy == 0 && mode.fx > 0));
    }
    TermSet terms{0.2, {}, modes, {}};
    const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
    EXPECT_NEAR(0.5 * variance_sum(prior, 0, prior.size()) / 1e-14, 1, 1e-12);
  }
}

TEST(FourierModes, RingsMeetHalfwayInTheLogarithmOfTheirFrequency) {
  // Constant from 5 to 80 /m: the variance of a ring is its fraction of the area, with edges at sqrt(10 40) =
  // 20 /m and sqrt(40 62.5) = 50 /m. Two waves of one frequency divide their ring.
  const RadialPsd psd(UniformPsd{1e-7, 5, 80});
  const TermSet terms{0.2, {}, {{0, 40}, {62.5, 0}, {6, 8}, {24, 32}}, {}};
  const Eigen::VectorXd variance =
      covariance_of(make_prior(terms, psd, CovarianceKind::kFull)).diagonal() / 1e-14;
  const double whole = 80 * 80 - 5 * 5, middle = (50 * 50 - 20 * 20) / whole / 2;
  const double expected[] = {middle, (80 * 80 - 50 * 50) / whole, (20 * 20 - 5 * 5) / whole, middle};
  for (Eigen::Index k = 0; k < 4; ++k)
    for (const Eigen::Index part : {0, 1}) EXPECT_NEAR(variance[2 * k + part], expected[k], 1e-12) << k;
}

TEST(FourierModes, SurfaceVarianceOverADiscIsTheHeightVarianceOnAverage) {
  // Mean of h^2 over points and seeds; its variance is 2 sigma^4 each. Points 2 m apart are independent.
  const RadialPsd psd(UniformPsd{1e-7, 5, 40});
  const int seeds = 400, points = 10;
  double mean = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const TermSet terms{0.2, {}, fourier_modes(psd, 60, std::uint64_t(seed)), {}};
    const CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
    const Eigen::VectorXd c = prior.colour(draw_white(prior.size(), std::uint64_t(seed)));
    for (int p = 0; p < points; ++p) {
      const double x = 2.0 * p, y = -1.3 * p;
      double h = 0;
      for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
        const double angle = 2 * pi * (terms.fourier[k].fx * x + terms.fourier[k].fy * y);
        h += c[2 * Eigen::Index(k)] * std::cos(angle) + c[2 * Eigen::Index(k) + 1] * std::sin(angle);
      }
      mean += h * h / (seeds * points);
    }
  }
  EXPECT_NEAR(mean / 1e-14, 1, 4.9 * std::sqrt((2.0 / points + 1.0 / 10) / seeds));
}

TEST(FourierModes, DirectionsOfLogRingsAreIsotropic) {
  const auto modes = fourier_modes(RadialPsd(UniformPsd{1e-7, 5, 40}), 987, 2);
  double c = 0, s = 0;
  for (const FourierMode& mode : modes) {
    const double angle = 2 * std::atan2(mode.fy, mode.fx);
    c += std::cos(angle) / 987;
    s += std::sin(angle) / 987;
  }
  EXPECT_LT(std::hypot(c, s),
            5.0 / 987);  // the sum is bounded for golden-angle points, 1/sqrt(987) = 0.03 for random ones
}
