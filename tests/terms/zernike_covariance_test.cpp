#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "aberfit/core/errors.h"
#include "aberfit/terms/modal_covariance.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kCovariance = 1e-9;  // relative to sqrt(C_jj C_kk), from the header

// Rows of comma-separated numbers after one header line.
std::vector<std::vector<double>> rows_of(const std::string& name) {
  std::ifstream file(std::string(ABERFIT_TEST_DATA) + "/noll/" + name);
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream text(line);
    std::string field;
    rows.emplace_back();
    while (std::getline(text, field, ',')) rows.back().push_back(std::stod(field));
  }
  return rows;
}

// Kolmogorov turbulence for D/r0 = 1; coefficients in radians.
RadialPsd kolmogorov() { return RadialPsd(PowerLawPsd{{}, 0.02289558710855518, 11.0 / 3, 0, kInf}); }
constexpr double kKolmogorovRadius = 0.5;

}  // namespace

TEST(ZernikeCovariance, ReproducesEveryKolmogorovEntryOfNoll) {
  const auto rows = rows_of("kolmogorov_covariance.csv");
  ASSERT_EQ(rows.size(), 66u);
  double worst = 0;
  for (const auto& row : rows) {
    const int n = int(row[2]), m = int(row[3]), np = int(row[4]);
    const std::vector<int> orders = n == np ? std::vector<int>{n} : std::vector<int>{n, np};
    const Eigen::MatrixXd c = zernike_covariance(kolmogorov(), kKolmogorovRadius, m, orders);
    const Eigen::Index last = c.rows() - 1;
    const double error = std::abs(c(0, last) - row[5]) / std::sqrt(c(0, 0) * c(last, last));
    EXPECT_LT(error, kCovariance) << "j = " << row[0] << ", j' = " << row[1];
    worst = std::max(worst, error);
  }
  RecordProperty("worst_error", std::to_string(worst * 1e15) + "e-15");
}

TEST(ZernikeCovariance, VariancesReproduceTheKolmogorovResiduals) {
  // Delta_J - Delta_J+1 is the variance of mode J + 1; each Delta has 16 digits.
  const auto rows = rows_of("kolmogorov_residual.csv");
  ASSERT_GE(rows.size(), 36u);
  std::vector<double> variance_of_order;
  for (int n = 0; n <= 9; ++n)
    variance_of_order.push_back(n == 0 ? 0
                                       : zernike_covariance(kolmogorov(), kKolmogorovRadius, n, {n})(0, 0));
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const int j = int(rows[i + 1][0]);
    int n = 0;
    while ((n + 1) * (n + 2) / 2 < j) ++n;
    EXPECT_NEAR(rows[i][1] - rows[i + 1][1], variance_of_order[std::size_t(n)], 1e-12) << "mode " << j;
  }
}

TEST(ZernikeCovariance, DivergesForPistonOfAPowerLawDownToZero) {
  EXPECT_THROW(zernike_covariance(kolmogorov(), 0.5, 0, {0, 2}), ComputationError);
  EXPECT_THROW(zernike_covariance(RadialPsd(PowerLawPsd{{}, 1, -1.5, 1, kInf}), 0.5, 0, {2}),
               ComputationError);
  EXPECT_NO_THROW(zernike_covariance(RadialPsd(PowerLawPsd{{}, 1, 11.0 / 3, 1e-9, kInf}), 0.5, 0, {0, 2}));
}

TEST(ZernikeCovariance, OfWhiteNoiseIsTheIdentity) {
  // For S = const on all frequencies <a_j a_j'> = S/(pi R^2) delta. This uses every range of the integral.
  const double level = 3e-17, radius = 0.2;
  const RadialPsd white(PowerLawPsd{{}, level, 0, 0, kInf});
  for (const int m : {0, 1, 7}) {
    std::vector<int> orders;
    for (int n = m; n <= 80; n += 2) orders.push_back(n);
    const Eigen::MatrixXd c = zernike_covariance(white, radius, m, orders) * (pi * radius * radius / level);
    EXPECT_LT((c - Eigen::MatrixXd::Identity(c.rows(), c.cols())).cwiseAbs().maxCoeff(), kCovariance) << m;
  }
}

TEST(ZernikeCovariance, OfAUniformBandAgreesWithQuadratureOfCovarianceOverTwoDiscs) {
  // Second method, in space instead of frequency: <a_j a_k> = (1/pi^2) int int Z_j(u) Z_k(v) C(R |u - v|) d2u
  // d2v by polar quadrature on both discs, with modes of m = 0 from their polynomials. Equal angles and
  // Gauss-Legendre in rho^2 converge to rounding for this smooth ACF.
  const double radius = 0.2;
  const RadialPsd psd(UniformPsd{1e-7, 2.5, 19.96});
  const int rings = 24, angles = 96;
  // Gauss-Legendre nodes by Newton's method, independent of the library.
  std::vector<double> t(rings), w(rings);
  for (int i = 0; i < rings; ++i) {
    double x = std::cos(pi * (i + 0.75) / (rings + 0.5)), derivative = 0;
    for (int step = 0; step < 50; ++step) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= rings; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = rings * (x * p1 - p0) / (x * x - 1);
      x -= p1 / derivative;
    }
    t[i] = 0.5 * (1 + x);  // rho^2
    w[i] = 1 / ((1 - x * x) * derivative * derivative);
  }
  const auto z = [](int n, double s) {  // R_n^0 in s = rho^2, orthonormal
    const double p = 2 * s - 1;
    if (n == 2) return std::sqrt(3.0) * p;
    if (n == 4) return std::sqrt(5.0) * (6 * s * s - 6 * s + 1);
    return std::sqrt(7.0) * (20 * s * s * s - 30 * s * s + 12 * s - 1);
  };
  Eigen::Matrix3d truth = Eigen::Matrix3d::Zero();
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k <= i; ++k) {
      double ring_mean = 0;
      for (int a = 0; a < angles; ++a) {
        const double d2 = t[i] + t[k] - 2 * std::sqrt(t[i] * t[k]) * std::cos(2 * pi * a / angles);
        ring_mean += autocorrelation(psd, radius * std::sqrt(std::max(d2, 0.0))) / angles;
      }
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const double both =
              i == k ? z(2 + 2 * a, t[i]) * z(2 + 2 * b, t[k])
                     : z(2 + 2 * a, t[i]) * z(2 + 2 * b, t[k]) + z(2 + 2 * a, t[k]) * z(2 + 2 * b, t[i]);
          truth(a, b) += w[i] * w[k] * ring_mean * both;
        }
    }
  const Eigen::MatrixXd c = zernike_covariance(psd, radius, 0, {2, 4, 6});
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      EXPECT_NEAR(c(a, b), truth(a, b), kCovariance * std::sqrt(c(a, a) * c(b, b))) << a << b;
}

TEST(ZernikeCovariance, IsLinearInThePsdAcrossAnyCutOfTheBand) {
  // Cuts at, below and beyond the start of the asymptotic tail move every panel, but must not change the sum.
  const double radius = 0.2;
  const RadialPsd whole(KCorrelationPsd{1e-7, 0.03, 3.1, 0, kInf});
  const std::vector<int> orders = {3, 5, 11, 29, 41};
  const Eigen::MatrixXd c = zernike_covariance(whole, radius, -3, orders);
  const Eigen::VectorXd scale = c.diagonal().cwiseSqrt().cwiseInverse();
  for (const double cut : {0.01, 1.0, 7.7, 30.0, 233.0, 240.0, 1e4, 1e7}) {
    const Eigen::MatrixXd parts = zernike_covariance(whole.band(0, cut), radius, 3, orders) +
                                  zernike_covariance(whole.band(cut, kInf), radius, 3, orders);
    EXPECT_LT((scale.asDiagonal() * (parts - c) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-12) << cut;
  }
}

TEST(ZernikeCovariance, VariancesOfACompleteSetSumToTheHeightVariance) {
  const RadialPsd psd(UniformPsd{1e-7, 2.5, 19.96});
  double before = 0;
  for (const int n_max : {5, 10, 15, 20, 25, 30}) {
    const double captured = captured_fraction(psd, 0.2, 0, n_max);
    EXPECT_GT(captured, before);
    EXPECT_LT(captured, 1 + 1e-12);
    before = captured;
  }
  EXPECT_NEAR(captured_fraction(psd, 0.2, 0, 160), 1,
              1e-12);  // J_160 is negligible, far beyond 2 pi R f_max = 25
}

TEST(CapturedFraction, IsTheSumOfTheCovarianceDiagonals) {
  const RadialPsd psd(KCorrelationPsd{1e-7, 0.1, 2.6, 0.5, 1e6});
  double sum = 0;
  for (int n = 2; n <= 17; ++n) sum += (n + 1) * zernike_covariance(psd, 0.2, n, {n})(0, 0);
  EXPECT_NEAR(captured_fraction(psd, 0.2, 2, 17), sum / 1e-14, 1e-12);
  EXPECT_EQ(captured_fraction(psd, 0.2, 2, 1), 0);
  EXPECT_THROW(captured_fraction(kolmogorov(), 0.5, 2, 8), ComputationError);
}
