#include "aberfit/fit/map_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "../../src/fit/independent_points.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/terms/surface_operator.h"
#include "measured/synthetic_files.h"
#include "sanitized.h"
#include "shared_data.h"
#include "short_form.h"

using namespace aberfit;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Heights of the terms written anew: zernike(), cosines and powers point by point.
Eigen::VectorXd term_heights(const TermSet& terms, double x, double y) {
  Eigen::VectorXd values(terms.size());
  Eigen::Index j = 0;
  for (const ZernikeMode& mode : terms.zernike)
    values[j++] = zernike(mode, x / terms.radius, y / terms.radius).value;
  for (const FourierMode& mode : terms.fourier) {
    const double phase = 2 * std::numbers::pi * (mode.fx * x + mode.fy * y);
    values[j++] = std::cos(phase);
    values[j++] = std::sin(phase);
  }
  for (const int power : terms.spherical) values[j++] = std::pow(std::hypot(x, y) / terms.radius, power);
  return values;
}

using Inside = std::function<bool(double, double)>;

HeightMap empty_map(int rows, int columns, double pitch_x, double pitch_y) {
  HeightMap map;
  map.height = Grid::Constant(rows, columns, kNan);
  map.pitch_x = pitch_x;
  map.pitch_y = pitch_y;
  map.x0 = -0.5 * pitch_x * (columns - 1);
  map.y0 = -0.5 * pitch_y * (rows - 1);
  return map;
}

HeightMap map_of(const TermSet& terms, const Eigen::VectorXd& coefficients, const Inside& inside) {
  HeightMap map = empty_map(90, 110, 2.0 / 100, 2.0 / 84);
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k)
      if (inside(map.x(k), map.y(i)))
        map.height(i, k) = term_heights(terms, map.x(k), map.y(i)).dot(coefficients);
  return map;
}

Eigen::VectorXd random_coefficients(Eigen::Index size, std::uint64_t seed) {
  const RandomStream stream(seed, "map-fit-test");
  Eigen::VectorXd values(size);
  for (Eigen::Index j = 0; j < size; ++j) values[j] = 1e-7 * stream.normal(std::uint64_t(j));
  return values;
}

bool in_circle(double x, double y) { return std::hypot(x, y) <= 1; }
bool in_annulus(double x, double y) { return in_circle(x, y) && std::hypot(x, y) >= 0.4; }
// A slanted quadrilateral off the axis, with two holes.
bool in_polygon(double x, double y) {
  const bool inside = x > -0.2 + 0.1 * y && x < 0.85 - 0.2 * y && y > -0.5 - 0.1 * x && y < 0.7 - 0.5 * x;
  return inside && std::hypot(x - 0.2, y - 0.1) > 0.1 && std::hypot(x - 0.5, y + 0.3) > 0.08;
}

void expect_recovery(const TermSet& terms, const Inside& inside, const char* name) {
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 1);
  const MapFitResult fit = fit_map(map_of(terms, truth, inside), terms);
  EXPECT_EQ(fit.status, MapFitResult::Status::kConverged) << fit.message;
  EXPECT_EQ(fit.rank, terms.size());
  EXPECT_GT(fit.held_out_points, fit.points / 12);
  const double worst = (fit.coefficients - truth).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
  std::printf("%s: %lld points, condition %.3g, error %.2g of the largest coefficient\n", name,
              static_cast<long long>(fit.points), fit.condition_number, worst);
  EXPECT_LE(worst, 1e-12 * fit.condition_number);
  EXPECT_LE(fit.rms_held_out, 1e-12 * fit.condition_number * fit.rms_map);
}

TermSet mixed_terms() {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(0, 7);
  terms.fourier = {{4.1, 0.7}, {-2.3, 5.2}};
  terms.spherical = {10};  // beyond the Zernikes, so that the rank is full
  return terms;
}

HeightMap made_map() { return test::made_interferogram(212, 206).map; }

// The real interferogram, by the offsets of the README beside it.
HeightMap zygo_map(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto u32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes.at(at + k));
    return value;
  };
  constexpr std::size_t kHeader = 834, kIntensity = 640 * 480 * 2;
  constexpr int kWidth = 425, kHeight = 432;
  const double unit = 6.32799981e-7 * 0.5 / 32768, pitch = 1.1792420264e-4;
  HeightMap map = empty_map(kHeight, kWidth, pitch, pitch);
  for (int i = 0; i < kHeight; ++i)
    for (int k = 0; k < kWidth; ++k) {
      const std::uint32_t raw = u32(kHeader + kIntensity + 4 * std::size_t(i * kWidth + k));
      const auto value = static_cast<std::int32_t>(raw);
      if (value < 2147483640) map.height(kHeight - 1 - i, k) = unit * value;  // the first row is the top
    }
  return map;
}

// Moves the origin to the centroid of the valid points; returns the distance of the farthest one.
double centre(HeightMap* map) {
  double x = 0, y = 0, count = 0, radius = 0;
  const auto each = [map](const auto& visit) {
    for (Eigen::Index i = 0; i < map->rows(); ++i)
      for (Eigen::Index k = 0; k < map->columns(); ++k)
        if (std::isfinite(map->height(i, k))) visit(map->x(k), map->y(i));
  };
  each([&](double px, double py) { x += px, y += py, ++count; });
  map->x0 -= x / count;
  map->y0 -= y / count;
  each([&](double px, double py) { radius = std::max(radius, std::hypot(px, py)); });
  return radius;
}

TermSet noll_terms(int last, double radius) {
  TermSet terms;
  terms.radius = radius;
  for (int j = 4; j <= last; ++j) terms.zernike.push_back(zernike_from_noll(j));
  return terms;
}

// The same problem as one dense matrix, piston and tilts in front.
struct DenseFit {
  Eigen::MatrixXd design;
  Eigen::VectorXd heights, solution;

  DenseFit(const HeightMap& map, TermSet terms) {
    terms.zernike.insert(terms.zernike.begin(), {{0, 0}, {1, -1}, {1, 1}});
    design.resize(map.height.isFinite().count(), terms.size());
    heights.resize(design.rows());
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < map.rows(); ++i)
      for (Eigen::Index k = 0; k < map.columns(); ++k)
        if (std::isfinite(map.height(i, k))) {
          design.row(row) = term_heights(terms, map.x(k), map.y(i)).transpose();
          heights[row++] = map.height(i, k);
        }
    solution = LeastSquares(design).solve(heights);
  }

  Eigen::VectorXd coefficients() const { return solution.tail(solution.size() - 3); }

  /// Standard deviation of the coefficients when each point is lost with probability `share`. Point i adds
  /// influence_i residual_i, and its loss is a Bernoulli variable; to first order.
  Eigen::VectorXd std_of_loss(double share) const {
    const Eigen::MatrixXd inverse =
        solve_symmetric(design.transpose() * design,
                        Eigen::MatrixXd(Eigen::MatrixXd::Identity(design.cols(), design.cols())));
    const Eigen::VectorXd residual = heights - design * solution;
    const Eigen::MatrixXd moved = (residual.asDiagonal() * design) * inverse;
    return (share / (1 - share) * moved.colwise().squaredNorm().transpose())
        .cwiseSqrt()
        .tail(solution.size() - 3);
  }
};

}  // namespace

TEST(MapFit, RecoversAKnownSurfaceOnAnyMask) {
  expect_recovery(mixed_terms(), in_circle, "circle");
  expect_recovery(mixed_terms(), in_annulus, "annulus");
  expect_recovery(mixed_terms(), in_polygon, "polygon");
}

TEST(MapFit, FitsPistonAndTiltAlongAndDropsThem) {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, 5);
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 2);
  HeightMap map = map_of(terms, truth, in_polygon);
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k)
      map.height(i, k) += 3e-6 + 2e-6 * map.x(k) - 5e-6 * map.y(i);
  const MapFitResult fit = fit_map(map, terms);
  EXPECT_EQ(fit.rank, terms.size());
  // The added plane is 50 times the terms.
  EXPECT_LE((fit.coefficients - truth).cwiseAbs().maxCoeff(), 1e-12 * 5e-6 * fit.condition_number);
  const double rounding = 1e-12 * 5e-6 * fit.condition_number;
  EXPECT_NEAR(fit.mount.height, 3e-6, rounding);
  EXPECT_NEAR(fit.mount.slope_x, 2e-6, rounding);
  EXPECT_NEAR(fit.mount.slope_y, -5e-6, rounding);
}

TEST(MapFit, FitsPlaneWavesWithoutARadius) {
  TermSet terms;
  terms.fourier = {{1.5, 0.2}, {0.3, 2.5}, {-2, 2}};
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 3);
  const MapFitResult fit = fit_map(map_of(terms, truth, [](double, double) { return true; }), terms);
  EXPECT_EQ(fit.points + fit.held_out_points, 90 * 110);
  EXPECT_LE((fit.coefficients - truth).cwiseAbs().maxCoeff(), 1e-19 * fit.condition_number);
}

TEST(MapFit, SaysWhenSphericalPowersRepeatTheZernikes) {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, 6);
  terms.spherical = {4, 6};
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 4);
  const MapFitResult fit = fit_map(map_of(terms, truth, in_annulus), terms);
  EXPECT_EQ(fit.status, MapFitResult::Status::kRankDeficient);
  EXPECT_EQ(fit.rank, terms.size() - 2);
  EXPECT_TRUE(std::any_of(fit.warnings.begin(), fit.warnings.end(),
                          [](const Warning& warning) { return warning.code == "m0-overlap"; }));
  EXPECT_LE(fit.rms_held_out, 1e-11 * fit.rms_map);  // for any split between dependent terms
  // The solution of least norm is orthogonal to a power minus its Zernikes. By hand: rho^4 = 1/3 + Z20 / (2
  // sqrt 3) + Z40 / (6 sqrt 5), with Z20 = sqrt3 (2 rho^2 - 1) and so on.
  Eigen::VectorXd null = Eigen::VectorXd::Zero(terms.size());
  for (std::size_t j = 0; j < terms.zernike.size(); ++j) {
    if (terms.zernike[j] == ZernikeMode{2, 0}) null[Eigen::Index(j)] = -1 / (2 * std::sqrt(3.0));
    if (terms.zernike[j] == ZernikeMode{4, 0}) null[Eigen::Index(j)] = -1 / (6 * std::sqrt(5.0));
  }
  null[terms.spherical_begin()] = 1;
  EXPECT_LE(std::abs(fit.coefficients.dot(null)), 1e-10 * truth.norm());
  EXPECT_LT(fit.coefficients.norm(), truth.norm());
}

// Without one astigmatism the residual is shared by dozens of neighbouring points; white noise is not.
TEST(MapFit, SaysWhenResidualsHoldNoMoreIndependentPointsThanItsTerms) {
  TermSet terms;
  terms.radius = 1;
  for (const ZernikeMode& mode : zernike_modes(2, 5))
    if (mode != ZernikeMode{2, 2}) terms.zernike.push_back(mode);
  const auto few = [](const MapFitResult& fit) {
    return std::find_if(fit.warnings.begin(), fit.warnings.end(),
                        [](const Warning& warning) { return warning.code == "few-independent-points"; });
  };
  HeightMap smooth = empty_map(40, 40, 0.05, 0.05), rough = smooth;
  const RandomStream stream(1, "map-fit-few-independent-points");
  for (Eigen::Index i = 0; i < smooth.rows(); ++i)
    for (Eigen::Index k = 0; k < smooth.columns(); ++k) {
      const double x = smooth.x(k), y = smooth.y(i);
      if (!in_circle(x, y)) continue;
      smooth.height(i, k) = 1e-7 * zernike({2, 2}, x, y).value;
      rough.height(i, k) = 1e-7 * stream.normal(std::uint64_t(i * smooth.columns() + k));
    }
  const MapFitResult shared = fit_map(smooth, terms), own = fit_map(rough, terms);
  ASSERT_NE(few(shared), shared.warnings.end()) << shared.independent_points;
  EXPECT_NE(few(shared)->message.find("independent points"), std::string::npos) << few(shared)->message;
  EXPECT_LT(shared.independent_points, double(terms.size()) + 4);  // piston and tilts are fitted as well
  EXPECT_EQ(few(own), own.warnings.end());
  EXPECT_GT(own.independent_points, 10 * double(terms.size()));
}

TEST(MapFit, IsTheSameToTheLastBitOnAnyNumberOfThreads) {
  HeightMap map = made_map();
  const TermSet terms = noll_terms(36, centre(&map));
  MapFitOptions one, three;
  three.threads = 3;
  const MapFitResult a = fit_map(map, terms, one), b = fit_map(map, terms, three);
  EXPECT_TRUE(a.coefficients == b.coefficients);
  EXPECT_TRUE(a.covariance == b.covariance);
  EXPECT_EQ(a.rms_held_out, b.rms_held_out);
  EXPECT_EQ(a.independent_points, b.independent_points);
}

TEST(MapFit, NeverSeesThePointsKeptBack) {
  HeightMap map = made_map();
  const TermSet terms = noll_terms(11, centre(&map));
  MapFitOptions options;
  options.held_out = 0.3;
  const MapFitResult first = fit_map(map, terms, options);
  // The same seed holds out the same points, and their values change only their own residual.
  const RandomStream stream(options.seed, "map-fit-held-out");
  Eigen::Index changed = 0;
  for (Eigen::Index at = 0; at < map.height.size(); ++at)
    if (std::isfinite(map.height.data()[at]) && stream.uniform(std::uint64_t(at)) < options.held_out) {
      map.height.data()[at] += 1e-6;
      ++changed;
    }
  const MapFitResult second = fit_map(map, terms, options);
  EXPECT_EQ(first.held_out_points, changed);
  EXPECT_TRUE(first.coefficients == second.coefficients);
  EXPECT_EQ(first.rms_residual, second.rms_residual);
  EXPECT_GT(second.rms_held_out, 0.9e-6);
  EXPECT_NEAR(first.rms_held_out / first.rms_residual, 1, 0.02);
}

namespace {

// The whole map with equal weights, so that one dense matrix is the same problem.
MapFitOptions all_points() {
  MapFitOptions options;
  options.held_out = 0;
  options.weighting = MapWeighting::kPoints;
  return options;
}

void expect_one_dense_matrix(HeightMap map) {
  const double radius = centre(&map);
  for (const int last : {11, 36}) {
    const TermSet terms = noll_terms(last, radius);
    const MapFitResult fit = fit_map(map, terms, all_points());
    const Eigen::VectorXd dense = DenseFit(map, terms).coefficients();
    EXPECT_EQ(fit.points, map.height.isFinite().count());
    EXPECT_LE((fit.coefficients - dense).cwiseAbs().maxCoeff(),
              1e-12 * fit.condition_number * dense.cwiseAbs().maxCoeff());
    std::printf("up to Noll %d: rms %.3f nm, residual %.3f nm, condition %.3g, independent points %.0f\n",
                last, 1e9 * fit.rms_map, 1e9 * fit.rms_residual, fit.condition_number,
                fit.independent_points);
    for (int j = 4; j <= 11; ++j)
      std::printf("  Noll %2d: %8.3f +- %.3f nm\n", j, 1e9 * fit.coefficients[j - 4],
                  1e9 * fit.coefficient_std[j - 4]);
  }
}

}  // namespace

TEST(MapFit, AgreesWithOneDenseMatrixOnAnInterferogram) { expect_one_dense_matrix(made_map()); }

using MapFitOnRealData = test::ZygoOnRealData;

TEST_F(MapFitOnRealData, AgreesWithOneDenseMatrix) {
  HeightMap map = zygo_map(file("valid_zygo_dat_file.dat"));
  const MapFitResult fit = fit_map(map, noll_terms(11, centre(&map)), all_points());
  EXPECT_EQ(fit.points, 136359);  // README of the map
  EXPECT_NEAR(fit.rms_map, 44.591e-9, 0.0005e-9);
  expect_one_dense_matrix(map);
}

TEST_WITH_SHORT_FORM(MapFit, MovesByTheSamplingErrorOfTheLostPointsOnly) {
  // 30 % of the points are lost at random, 20 times. Noll 4..11 change as much as in any least-squares fit
  // that loses these residuals, which are largest at the turned-down rim.
  constexpr int kSeeds = 20;
  constexpr double kLost = 0.3;
  constexpr double kLooks = 4.5;  // standard deviations: probability 1e-3 for one of 160 values
  HeightMap all = made_map();
  const double radius = centre(&all);
  const MapFitOptions options = all_points();
  for (const int last : aberfit::test::all_or_few(whole, std::vector{11, 36}, {0})) {
    const TermSet terms = noll_terms(last, radius);
    const Eigen::VectorXd reference = fit_map(all, terms, options).coefficients.head(8);
    const Eigen::VectorXd expected = DenseFit(all, terms).std_of_loss(kLost).head(8);
    Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(8);
    double worst = 0, score = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const RandomStream stream(seed, "map-fit-holes");
      HeightMap holes = all;
      for (Eigen::Index at = 0; at < holes.height.size(); ++at)
        if (stream.uniform(std::uint64_t(at)) < kLost) holes.height.data()[at] = kNan;
      const Eigen::ArrayXd change = fit_map(holes, terms, options).coefficients.head(8) - reference;
      squares += change.square() / kSeeds;
      worst = std::max(worst, change.abs().maxCoeff());
      score += (change / expected.array()).square().mean() / kSeeds;
      EXPECT_LT((change.abs() / expected.array()).maxCoeff(), kLooks) << seed;
    }
    std::printf(
        "up to Noll %d: Noll 4..11 move by %.4f nm RMS over %d seeds, the worst coefficient by %.4f nm RMS; "
        "largest single move %.4f nm; expected std at most %.4f nm\n",
        last, 1e9 * std::sqrt(squares.mean()), kSeeds, 1e9 * std::sqrt(squares.maxCoeff()), 1e9 * worst,
        1e9 * expected.maxCoeff());
    EXPECT_NEAR(std::sqrt(score), 1, 0.25);  // 4 standard errors of 160 values are 0.22
  }
}

void expect_hardly_a_move(const std::string& path, int seeds) {
  // 30 % of the points are lost at random, repeatedly. The interferogram's rim is turned down by 300 nm along
  // a ragged edge. Tested are 95 % of its circle (terms to Noll 36) and 90 % (any). Each of Noll 4..11
  // changes by less than 0.1 nm there, because the neighbours of a lost point replace it. Seen: 0.07 nm and
  // 0.04 nm; with equal weights 0.21 nm and 0.12 nm.
  HeightMap whole = zygo_map(path);
  const Circle circle = enclosing_circle(whole);
  move_origin(&whole, circle.x, circle.y);
  struct Case {
    double share;
    int last;
  };
  for (const Case& c : {Case{0.95, 36}, Case{0.9, 11}, Case{0.9, 36}}) {
    MapFitOptions options;
    options.held_out = 0;
    const TermSet terms = noll_terms(c.last, c.share * circle.radius);
    const Eigen::VectorXd reference = fit_map(whole, terms, options).coefficients.head(8);
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= std::uint64_t(seeds); ++seed) {
      const RandomStream stream(seed, "map-fit-holes");
      HeightMap holes = whole;
      for (Eigen::Index at = 0; at < holes.height.size(); ++at)
        if (stream.uniform(std::uint64_t(at)) < 0.3) holes.height.data()[at] = kNan;
      const Eigen::VectorXd change = fit_map(holes, terms, options).coefficients.head(8) - reference;
      worst = std::max(worst, change.cwiseAbs().maxCoeff());
    }
    EXPECT_LT(worst, 0.1e-9) << c.share << " to Noll " << c.last;
    std::printf("%.2f of the circle, up to Noll %d: worst change of Noll 4..11 %.4f nm\n", c.share, c.last,
                1e9 * worst);
  }
}
TEST_F(MapFitOnRealData, HardlyMovesWhenPointsOfTheClearApertureDropOut) {
  expect_hardly_a_move(file("valid_zygo_dat_file.dat"), 3);
}
using FullStatisticsOnRealData = MapFitOnRealData;
TEST_F(FullStatisticsOnRealData, HardlyMovesWhenPointsOfTheClearApertureDropOut) {
  expect_hardly_a_move(file("valid_zygo_dat_file.dat"), 20);
}

TEST(MapFit, GivesHolesToTheirNeighbours) {
  // 9 x 9 points without the middle one. Each of its eight neighbours carries 1 + 1/8, so a height of 1 nm
  // beside the hole weighs (1 + 1/8)/81 in the mean, against 1/80 for equal weights.
  HeightMap map;
  map.height = Grid::Zero(9, 9);
  map.pitch_x = map.pitch_y = 0.1;
  centre_on_grid(&map);
  map.height(4, 4) = kNan;
  map.height(4, 5) = 1e-9;  // beside the hole: weight 1 + 1/8
  TermSet terms;
  terms.radius = 1;
  terms.zernike = {{0, 0}};
  MapFitOptions options;
  options.held_out = 0;
  // Tilts are fitted as well; by symmetry they do not change the mean of the weighted heights about the axis.
  const double piston = fit_map(map, terms, options).coefficients[0];
  EXPECT_NEAR(piston, 1e-9 * (1 + 1.0 / 8) / 81, 1e-13);
  options.weighting = MapWeighting::kPoints;
  EXPECT_NEAR(fit_map(map, terms, options).coefficients[0], 1e-9 / 80, 1e-13);
}

// The sum of products over all lags is the square of the sum: n equal residuals have n neighbours in any
// block.
TEST(CorrelatedNeighbours, OfABlockOfEqualResidualsAreItsPoints) {
  struct Block {
    int rows, columns;
    double pitch_x, pitch_y;
  };
  for (const Block& b : {Block{1, 1, 1, 1}, Block{3, 3, 1, 1}, Block{1, 5, 1, 1}, Block{4, 2, 2e-3, 1.5e-3},
                         Block{2, 5, 1, 4}}) {
    Grid residual = Grid::Zero(30, 34);
    residual.block(11, 9, b.rows, b.columns) = 3e-9;
    EXPECT_NEAR(internal::correlated_neighbours(residual, b.pitch_x, b.pitch_y, 1), b.rows * b.columns, 1e-12)
        << b.rows << " x " << b.columns;
  }
}

TEST(MapFit, StandardDeviationsCoverCorrelatedNoise) {
  // White noise smoothed by a Gaussian of w pixels has the autocorrelation exp(-d^2 / (4 w^2)).
  constexpr int kSide = 144, kReach = 8, kMaps = 60;
  constexpr double kWidth = 2, kNoise = 5e-9;
  TermSet terms;
  terms.radius = 1;
  for (int j = 4; j <= 15; ++j) terms.zernike.push_back(zernike_from_noll(j));
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 5);
  Eigen::ArrayXd kernel(2 * kReach + 1);
  for (int k = -kReach; k <= kReach; ++k) kernel[k + kReach] = std::exp(-0.5 * k * k / (kWidth * kWidth));
  kernel /= std::sqrt(kernel.square().sum());
  double sum = 0, neighbours = 0;
  for (int trial = 0; trial < kMaps; ++trial) {
    const RandomStream stream(std::uint64_t(trial), "map-fit-coverage");
    constexpr int kWide = kSide + 2 * kReach;
    Grid white(kWide, kWide), smooth = Grid::Zero(kWide, kSide);
    for (Eigen::Index at = 0; at < white.size(); ++at) white.data()[at] = stream.normal(std::uint64_t(at));
    for (int k = 0; k <= 2 * kReach; ++k) smooth += kernel[k] * white.middleCols(k, kSide);
    HeightMap map = empty_map(kSide, kSide, 2.0 / kSide, 2.0 / kSide);
    map.height.setZero();
    for (int k = 0; k <= 2 * kReach; ++k) map.height += kNoise * kernel[k] * smooth.middleRows(k, kSide);
    for (Eigen::Index i = 0; i < kSide; ++i)
      for (Eigen::Index k = 0; k < kSide; ++k)
        map.height(i, k) +=
            in_annulus(map.x(k), map.y(i)) ? term_heights(terms, map.x(k), map.y(i)).dot(truth) : kNan;
    const MapFitResult fit = fit_map(map, terms);
    sum += ((fit.coefficients - truth).array() / fit.coefficient_std.array()).square().mean() / kMaps;
    neighbours += double(fit.points) / fit.independent_points / kMaps;
  }
  // 90 % of the points are fitted, so 90 % of the neighbours of a point count.
  const double expected = 1 + 0.9 * (4 * std::numbers::pi * kWidth * kWidth - 1);
  std::printf("z-scores: std %.3f; correlated neighbours %.2f, from the known autocorrelation %.2f\n",
              std::sqrt(sum), neighbours, expected);
  EXPECT_GT(std::sqrt(sum), 0.85);
  EXPECT_LT(std::sqrt(sum), 1.2);
}

namespace {

// Heights [m] added to the fitted terms at every point of the grid.
using Addition = std::function<Grid(std::uint64_t seed, const HeightMap& map)>;

Grid white_noise(std::uint64_t seed, const HeightMap& map) {
  const RandomStream stream(seed, "map-fit-std-noise");
  Grid noise(map.rows(), map.columns());
  for (Eigen::Index at = 0; at < noise.size(); ++at)
    noise.data()[at] = 5e-9 * stream.normal(std::uint64_t(at));
  return noise;
}

Addition roughness(const PsdModel& model) {
  return [psd = RadialPsd(model)](std::uint64_t seed, const HeightMap& map) {
    return random_surface(psd, map.rows(), map.columns(), map.pitch_x, {.seed = seed}).height;
  };
}

// A few aberrations of the next orders, with white noise.
Grid figure_and_noise(std::uint64_t seed, const HeightMap& map) {
  Grid heights = white_noise(seed, map);
  const RandomStream stream(seed, "map-fit-std-figure");
  const ZernikeMode modes[] = {{5, 1}, {6, 0}, {6, 2}, {7, -3}};
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k)
      if (in_circle(map.x(k), map.y(i)))
        for (std::uint64_t j = 0; j < 4; ++j)
          heights(i, k) += 20e-9 * stream.normal(j) * zernike(modes[j], map.x(k), map.y(i)).value;
  return heights;
}

struct Coverage {
  double inside = 0;  // fraction of the 95 % intervals that contain the truth
  double z = 0;       // root mean square of error over standard deviation
};

Coverage coverage(int n_max, const Addition& add, const Inside& inside, int maps) {
  constexpr int kSide = 96;
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, n_max);
  const HeightMap grid = empty_map(kSide, kSide, 2.0 / kSide, 2.0 / kSide);
  Coverage result;
  for (int seed = 1; seed <= maps; ++seed) {
    HeightMap map = grid;
    const Grid heights = add(std::uint64_t(seed), grid);
    for (Eigen::Index i = 0; i < kSide; ++i)
      for (Eigen::Index k = 0; k < kSide; ++k)
        if (inside(map.x(k), map.y(i))) map.height(i, k) = heights(i, k);
    // The added heights contain none of the terms, so their coefficients are errors.
    const MapFitResult fit = fit_map(map, terms);
    const Eigen::ArrayXd z = fit.coefficients.array() / fit.coefficient_std.array();
    result.inside += double((z.abs() < 1.96).count()) / double(z.size() * maps);
    result.z += z.square().mean() / maps;
  }
  result.z = std::sqrt(result.z);
  return result;
}

}  // namespace

// About 95 % of the 95 % intervals contain the truth. The cases are white noise, roughness constant up to
// beyond the terms (k-correlation with its knee there), roughness beyond the terms alone, and single residual
// aberrations. They include masks on which Zernikes are not orthogonal.
TEST(MapFit, StandardDeviationsAreTheErrorsThatCoefficientsHave) {
  struct Scene {
    const char* name;
    int n_max;
    Addition add;
    Inside inside;
    double least, most;  // of `Coverage::inside`
  };
  constexpr int kMaps = 16;
  // 12 terms in 16 maps give the fraction to 1.6 %; the common scale of a map adds 2 %.
  const Scene scenes[] = {
      {"noise on a disc", 4, white_noise, in_circle, 0.90, 0.99},
      {"noise on an annulus", 8, white_noise, in_annulus, 0.90, 0.99},
      {"noise on a polygon", 4, white_noise, in_polygon, 0.90, 0.99},
      {"roughness, level", 8, roughness(KCorrelationPsd{5e-9, 0.1, 3}), in_circle, 0.88, 0.99},
      {"roughness beyond the terms", 8, roughness(UniformPsd{5e-9, 6, 20}), in_circle, 0.90, 1},
      {"roughness beyond, annulus", 8, roughness(PowerLawPsd{5e-9, {}, 2.5, 6, 20}), in_annulus, 0.90, 1},
      {"figure on a disc", 4, figure_and_noise, in_circle, 0.93, 1},
      {"figure on an annulus", 4, figure_and_noise, in_annulus, 0.93, 1},
  };
  for (const Scene& scene : scenes) {
    const Coverage seen = coverage(scene.n_max, scene.add, scene.inside, kMaps);
    std::printf("%-28s %.3f inside, z %.3f\n", scene.name, seen.inside, seen.z);
    EXPECT_GE(seen.inside, scene.least) << scene.name;
    EXPECT_LE(seen.inside, scene.most) << scene.name;
    EXPECT_GT(seen.z, 0.7) << scene.name;
    EXPECT_LT(seen.z, 1.25) << scene.name;
  }
}

TEST_WITH_SHORT_FORM(MapFit, SolvesManyTermsThroughTheOperator) {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, 54);  // 1,537 terms and piston and tilt
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 6);
  const int points = whole ? 180 : 110;
  HeightMap map = empty_map(points, points, 2.0 / points, 2.0 / points);
  SurfaceField field;
  Eigen::ArrayXd x(map.height.size()), y(map.height.size());
  for (Eigen::Index at = 0; at < map.height.size(); ++at)
    x[at] = map.x(at % map.columns()), y[at] = map.y(at / map.columns());
  SurfaceOperator(terms, x, y, 1).apply(truth, &field);
  for (Eigen::Index at = 0; at < map.height.size(); ++at)
    if (in_circle(x[at], y[at])) map.height.data()[at] = field.height[at];
  const MapFitResult fit = fit_map(map, terms);
  EXPECT_EQ(fit.status, MapFitResult::Status::kConverged) << fit.message;
  ASSERT_FALSE(fit.warnings.empty());
  EXPECT_EQ(fit.warnings[0].code, "iterative-solution");
  EXPECT_EQ(fit.covariance.size(), 0);
  std::printf("%lld terms: condition %.3g, error %.2g\n", static_cast<long long>(terms.size()),
              fit.condition_number,
              (fit.coefficients - truth).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff());
  // The gradient falls to 1e-13 of its first value; the error is that times the condition number squared.
  EXPECT_LE((fit.coefficients - truth).norm(),
            1e-13 * fit.condition_number * fit.condition_number * truth.norm() + 1e-12 * truth.norm());
}

TEST(MapFit, SaysWhatItCannotFit) {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, 4);
  const Eigen::VectorXd truth = random_coefficients(terms.size(), 7);
  const HeightMap nothing = map_of(terms, truth, [](double, double) { return false; });
  EXPECT_EQ(fit_map(nothing, terms).status, MapFitResult::Status::kFailed);
  EXPECT_EQ(fit_map(map_of(terms, truth, in_circle), TermSet{1, {}, {}, {}}).status,
            MapFitResult::Status::kFailed);
  // A dozen points for fifteen unknowns.
  const MapFitResult few =
      fit_map(map_of(terms, truth, [](double x, double y) { return std::hypot(x, y) < 0.045; }), terms);
  EXPECT_EQ(few.status, MapFitResult::Status::kRankDeficient);
  EXPECT_LT(few.rank, few.points);
  EXPECT_TRUE(few.coefficients.allFinite() && few.coefficient_std.allFinite());
  HeightMap no_pitch = map_of(terms, truth, in_circle);
  no_pitch.pitch_x = 0;
  EXPECT_THROW(fit_map(no_pitch, terms), std::invalid_argument);
  MapFitOptions all_held_out;
  all_held_out.held_out = 1;
  EXPECT_THROW(fit_map(map_of(terms, truth, in_circle), terms, all_held_out), std::invalid_argument);
}

TEST_WITH_SHORT_FORM(MapFit, TakesLittleTime) {
  HeightMap map = test::made_interferogram(432, 425).map;
  const double radius = centre(&map);
  for (const auto& [last, limit] :
       aberfit::test::all_or_few(whole, std::vector{std::pair{39, 1.0}, std::pair{234, 5.0}}, {0})) {
    const TermSet terms = noll_terms(last, radius);
    const std::clock_t begin = std::clock();  // processor time is independent of other programs
    const MapFitResult fit = fit_map(map, terms);
    const double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    std::printf("%lld terms, %lld points: %.2f s\n", static_cast<long long>(terms.size()),
                static_cast<long long>(fit.points), seconds);
    EXPECT_EQ(fit.status, MapFitResult::Status::kConverged);
    if (!test::kSanitized) {
      EXPECT_LT(seconds, 4 * limit);  // allows for a busy or slower machine
    }
  }
}
