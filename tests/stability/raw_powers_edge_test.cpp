// Spherical powers: raw rho^4 .. rho^12 in metres against the program's basis, which has unit height at the
// rim; and powers fitted together with the m = 0 Zernikes, which are sums of them.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "aberfit/fit/map_fit.h"
#include "edge.h"

namespace aberfit::test {
namespace {

const std::vector<int> kPowers = {4, 6, 8, 10, 12};
constexpr double kAtRim = 1e-7;  // height of each power at the rim [m]

HeightMap map_of(double radius, const std::function<double(double)>& height) {
  constexpr int kPoints = 41;
  HeightMap map;
  map.height = Grid::Constant(kPoints, kPoints, std::nan(""));
  map.pitch_x = map.pitch_y = 2 * radius / (kPoints - 1);
  map.x0 = map.y0 = -radius;
  for (int i = 0; i < kPoints; ++i)
    for (int k = 0; k < kPoints; ++k)
      if (const double rho = std::hypot(map.x(k), map.y(i)) / radius; rho <= 1 + 1e-9)
        map.height(i, k) = height(rho);
  return map;
}

double all_powers(double rho) {
  double sum = 0;
  for (const int power : kPowers) sum += kAtRim * std::pow(rho, power);
  return sum;
}

// Solves for the columns 1, x^4 .. x^12 in metres, with the usual rank decision at 1e-15 of the largest
// pivot. Returns the largest relative error of a power's height at the rim.
double raw_error(const HeightMap& map, double radius) {
  std::vector<double> rho, height;
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k)
      if (std::isfinite(map.height(i, k)))
        rho.push_back(std::hypot(map.x(k), map.y(i))), height.push_back(map.height(i, k));
  Eigen::MatrixXd design(Eigen::Index(rho.size()), 6);
  for (Eigen::Index i = 0; i < design.rows(); ++i) {
    design(i, 0) = 1;
    for (int p = 0; p < 5; ++p) design(i, p + 1) = std::pow(rho[std::size_t(i)], kPowers[std::size_t(p)]);
  }
  const Eigen::VectorXd c =
      design.colPivHouseholderQr().solve(Eigen::Map<const Eigen::VectorXd>(height.data(), design.rows()));
  double worst = 0;
  for (int p = 0; p < 5; ++p)
    worst = std::max(worst, std::abs(c[p + 1] * std::pow(radius, kPowers[std::size_t(p)]) / kAtRim - 1));
  return worst;
}

TEST(StabilityEdge, RawPowersInMetres) {
  Edge edge("raw_powers", "radius of the mirror [m]", "largest relative error of a power [1]");
  TermSet terms;
  terms.spherical = kPowers;
  double least_condition = 1e300, most_condition = 0;
  for (const double radius : geometric_steps(10, 1e-4, 21)) {
    terms.radius = radius;
    const HeightMap map = map_of(radius, all_powers);
    const MapFitResult fit = fit_map(map, terms);
    const double error = (fit.coefficients.array() / kAtRim - 1).abs().maxCoeff();
    // map_design.h allows 1e-15 of the coefficients times the condition number; here with a factor of ten.
    edge.add({radius, error, 1e-14 * fit.condition_number, fit.status != MapFitResult::Status::kConverged,
              raw_error(map, radius)});
    least_condition = std::min(least_condition, fit.condition_number);
    most_condition = std::max(most_condition, fit.condition_number);
  }
  edge.expect();
  // The condition of the program's basis does not depend on the unit.
  EXPECT_LT(most_condition / least_condition, 1 + 1e-6);
}

TEST(StabilityEdge, PowersBesideTheZernikesTheyAreSumsOf) {
  // rho^4 .. rho^12 together with Z_n^0, n = 2 .. n_max. From n_max = 4 on, one power after the other is a
  // sum of Zernikes. The error is that of the coefficients; it is promised if the points distinguish all
  // terms.
  Edge edge("powers_and_zernikes", "highest order of the m = 0 Zernikes [1]",
            "largest coefficient error / height [1]");
  edge.linear_parameter();
  for (int n_max = 2; n_max <= 16; n_max += 2) {
    TermSet terms;
    terms.radius = 0.2;
    terms.spherical = kPowers;
    for (int n = 2; n <= n_max; n += 2) terms.zernike.push_back({n, 0});
    const MapFitResult fit = fit_map(map_of(terms.radius, all_powers), terms);
    const Eigen::VectorXd powers = fit.coefficients.tail(5);
    const int overlapping = std::clamp((n_max - 2) / 2, 0, 5);
    EXPECT_EQ(fit.rank, terms.size() - overlapping) << "n_max " << n_max;
    const bool warned = std::any_of(fit.warnings.begin(), fit.warnings.end(),
                                    [](const Warning& w) { return w.code == "m0-overlap"; });
    EXPECT_EQ(warned, overlapping > 0) << "n_max " << n_max;
    // However the height is divided between them, the surface is the measured one.
    EXPECT_LT(fit.rms_residual, 1e-12 * fit.rms_map) << "n_max " << n_max;
    edge.add({double(n_max), (powers.array() / kAtRim - 1).abs().maxCoeff(), 1e-13 * fit.condition_number,
              fit.status == MapFitResult::Status::kRankDeficient && warned});
  }
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
