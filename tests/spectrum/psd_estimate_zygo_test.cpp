#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "measured/synthetic_files.h"
#include "psd_slope.h"
#include "shared_data.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

// In this band the rings of the table hold at least 50 ordinates, and the map is above its noise.
constexpr double kBandFrom = 500, kBandTo = 3000;  // [cycles/m]

HeightMap zygo_map() {
  MeasuredSource source;
  source.path = (*test::shared_data("prysm-zygo") / "valid_zygo_dat_file.dat").string();
  return read_zygo(source);
}

// A synthetic map with rim, bites and dropouts like the measured one, and a quarter of its points.
HeightMap made_map() { return test::made_interferogram(212, 206).map; }

// What follows recomputes the estimate from the docstrings only. This function subtracts the dense
// least-squares fit of 1, x, y, x^2, xy, y^2.
Grid without_quadric(const Grid& z) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> valid;
  for (Eigen::Index r = 0; r < z.rows(); ++r)
    for (Eigen::Index c = 0; c < z.cols(); ++c)
      if (!std::isnan(z(r, c))) valid.emplace_back(r, c);
  Eigen::MatrixXd a(Eigen::Index(valid.size()), 6);
  Eigen::VectorXd b(a.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto [r, c] = valid[std::size_t(i)];
    const double x = double(c) / double(z.cols()) - 0.5, y = double(r) / double(z.rows()) - 0.5;
    a.row(i) << 1, x, y, x * x, x * y, y * y;
    b[i] = z(r, c);
  }
  const Eigen::VectorXd rest = b - a * LeastSquares(a).solve(b);
  Grid result = z;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    result(valid[std::size_t(i)].first, valid[std::size_t(i)].second) = rest[i];
  return result;
}

double mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return sum / double(values.size());
}

// Marks invalid points connected to the outside of the grid by invalid points along rows and columns.
Eigen::ArrayXXi outside_of(const Grid& z) {
  Eigen::ArrayXXi outside = Eigen::ArrayXXi::Zero(z.rows() + 2, z.cols() + 2);
  outside.row(0) = outside.row(z.rows() + 1) = 1;
  outside.col(0) = outside.col(z.cols() + 1) = 1;
  for (bool grew = true; grew;) {
    grew = false;
    for (const bool backwards : {false, true})
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        const Eigen::Index at = backwards ? z.size() - 1 - i : i, r = at / z.cols(), c = at % z.cols();
        if (outside(r + 1, c + 1) || !std::isnan(z(r, c))) continue;
        if (outside(r, c + 1) || outside(r + 2, c + 1) || outside(r + 1, c) || outside(r + 1, c + 2))
          outside(r + 1, c + 1) = 1, grew = true;
      }
  }
  return outside.block(1, 1, z.rows(), z.cols());
}

struct Rectangle {
  Eigen::Index row = 0, column = 0, rows = 0, columns = 0;
};

// Tries every pair of first and last row with the longest run of columns that are inside in all rows between.
Rectangle largest_rectangle(const Eigen::ArrayXXi& outside, int* equals) {
  Rectangle best;
  for (Eigen::Index top = 0; top < outside.rows(); ++top) {
    Eigen::ArrayXi blocked = Eigen::ArrayXi::Zero(outside.cols());
    for (Eigen::Index bottom = top; bottom < outside.rows(); ++bottom) {
      blocked += outside.row(bottom).transpose();
      Eigen::Index run = 0;
      for (Eigen::Index c = 0; c < outside.cols(); ++c) {
        run = blocked[c] ? 0 : run + 1;
        const Eigen::Index area = run * (bottom - top + 1), record = best.rows * best.columns;
        if (area == record) ++*equals;
        if (area > record) best = {top, c + 1 - run, bottom - top + 1, run}, *equals = 1;
      }
    }
  }
  return best;
}

Eigen::Index cut_side(Eigen::Index n) {
  for (;; --n) {
    Eigen::Index rest = n;
    for (const int prime : {2, 3, 5, 7})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return n;
  }
}

// Sets each hole point to the mean of its four neighbours, by relaxation.
void bridge(Grid* z) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> holes;
  for (Eigen::Index r = 0; r < z->rows(); ++r)
    for (Eigen::Index c = 0; c < z->cols(); ++c)
      if (std::isnan((*z)(r, c))) holes.emplace_back(r, c), (*z)(r, c) = 0;
  for (int sweep = 0; sweep < 2000; ++sweep)
    for (const auto& [r, c] : holes) {
      double sum = 0, count = 0;
      if (r > 0) sum += (*z)(r - 1, c), ++count;
      if (r + 1 < z->rows()) sum += (*z)(r + 1, c), ++count;
      if (c > 0) sum += (*z)(r, c - 1), ++count;
      if (c + 1 < z->cols()) sum += (*z)(r, c + 1), ++count;
      (*z)(r, c) = sum / count;
    }
}

// Two-sided PSD [m^4] with the Hann window; Fourier sums are products with dense matrices. Ordinate (l, k) is
// at row l + rows/2, column k + cols/2.
Grid periodogram(const Grid& z, double pitch) {
  const auto hann = [](Eigen::Index n) {
    Eigen::ArrayXd w(n);
    for (Eigen::Index i = 0; i < n; ++i) w[i] = std::pow(std::sin(pi * (double(i) + 0.5) / double(n)), 2);
    return w;
  };
  const auto dft = [](Eigen::Index n) {
    Eigen::MatrixXcd f(n, n);
    for (Eigen::Index k = 0; k < n; ++k)
      for (Eigen::Index i = 0; i < n; ++i)
        f(k, i) = std::polar(1.0, -2 * pi * double(((k - n / 2) * i) % n) / double(n));
    return f;
  };
  const Eigen::ArrayXd wy = hann(z.rows()), wx = hann(z.cols());
  const Eigen::MatrixXd windowed = wy.matrix().asDiagonal() * z.matrix() * wx.matrix().asDiagonal();
  const Eigen::MatrixXcd along = dft(z.rows()) * windowed.cast<std::complex<double>>();
  const Eigen::MatrixXcd transform = along * dft(z.cols()).transpose();
  return transform.array().abs2() * (pitch * pitch / (wy.square().sum() * wx.square().sum()));
}

// psi(x) by recurrence and its asymptotic series.
double digamma(double x) {
  double psi = 0;
  for (; x < 20; ++x) psi -= 1 / x;
  return psi + std::log(x) - 1 / (2 * x) - 1 / (12 * x * x) + 1 / (120 * std::pow(x, 4));
}

struct Line {
  double s[5] = {};
  void add(double weight, double x, double y) {
    const double v[5] = {1, x, x * x, y, x * y};
    for (int i = 0; i < 5; ++i) s[i] += weight * v[i];
  }
  double slope() const { return (s[0] * s[4] - s[1] * s[3]) / (s[0] * s[2] - s[1] * s[1]); }
};

// Logarithmic bins of the ordinates, their dof from the double sum over all pairs of a bin, and the line.
double plain_exponent(const Grid& psd, double pitch, double from, double to) {
  const double step_y = 1 / (double(psd.rows()) * pitch), step_x = 1 / (double(psd.cols()) * pitch);
  const double resolution = std::min(step_x, step_y);
  struct Ordinate {
    int k, l;
    double f, power;
  };
  std::vector<std::vector<Ordinate>> bins(60);
  for (Eigen::Index j = 0; j < psd.rows(); ++j)
    for (Eigen::Index i = 0; i < psd.cols(); ++i) {
      const int l = int(j - psd.rows() / 2), k = int(i - psd.cols() / 2);
      const double f = std::hypot(k * step_x, l * step_y);
      if (f <= 0 || f >= 0.5 / pitch * (1 - 1e-9)) continue;
      bins[std::size_t(std::floor(12 * std::log10(f / resolution) + 0.5))].push_back({k, l, f, psd(j, i)});
    }
  // |sum w^2 exp(2 pi i d t)|^2 over (sum w^2)^2 of the Hann window, d = 0, 1, 2.
  constexpr double kCorrelation[] = {1, 4. / 9, 1. / 36};
  Line line;
  for (const std::vector<Ordinate>& bin : bins) {
    if (bin.empty()) continue;
    double f = 0, mean = 0, pairs = 0;
    Eigen::ArrayXXi here = Eigen::ArrayXXi::Zero(psd.rows() + 4, psd.cols() + 4);
    for (const Ordinate& o : bin) here(o.l + psd.rows() / 2 + 2, o.k + psd.cols() / 2 + 2) = 1;
    for (const Ordinate& o : bin) {
      f += o.f, mean += o.power;
      for (int dl = -2; dl <= 2; ++dl)
        for (int dk = -2; dk <= 2; ++dk)
          pairs += here(o.l + dl + psd.rows() / 2 + 2, o.k + dk + psd.cols() / 2 + 2) *
                   kCorrelation[std::abs(dl)] * kCorrelation[std::abs(dk)];
    }
    const double n = double(bin.size());
    f /= n, mean /= n;
    if (f < from || f > to) continue;
    const double dof = n * n / pairs;  // half of the n ordinates are conjugates of the others
    line.add(dof, std::log(f), std::log(mean) - digamma(dof / 2) + std::log(dof / 2));
  }
  return -line.slope();
}

PsdEstimate estimate_without_lines(const HeightMap& map) {
  PsdEstimatorOptions options;  // Hann, degree 2
  options.find_lines = false;   // so that a bin is the mean of all its ordinates
  return estimate_psd(map, options, 2);
}

using PsdEstimateZygoOnRealData = test::ZygoOnRealData;

void expect_rms_of_a_plain_recomputation(const HeightMap& map, const PsdEstimate& estimate) {
  const Grid z = without_quadric(map.height);
  std::vector<double> height, across, down;
  for (Eigen::Index r = 0; r < z.rows(); ++r)
    for (Eigen::Index c = 0; c < z.cols(); ++c) {
      if (std::isnan(z(r, c))) continue;
      height.push_back(z(r, c));
      if (c > 0 && c + 1 < z.cols() && !std::isnan(z(r, c - 1)) && !std::isnan(z(r, c + 1)))
        across.push_back((z(r, c + 1) - z(r, c - 1)) / (2 * map.pitch_x));
      if (r > 0 && r + 1 < z.rows() && !std::isnan(z(r - 1, c)) && !std::isnan(z(r + 1, c)))
        down.push_back((z(r + 1, c) - z(r - 1, c)) / (2 * map.pitch_y));
    }
  EXPECT_NEAR(estimate.rms_height / std::sqrt(mean_square(height)), 1, 1e-6);
  EXPECT_NEAR(estimate.rms_slope / std::sqrt((mean_square(across) + mean_square(down)) / 2), 1, 1e-6);
  EXPECT_NEAR(estimate.rms_slope_x / std::sqrt(mean_square(across)), 1, 1e-6);
  EXPECT_NEAR(estimate.rms_slope_y / std::sqrt(mean_square(down)), 1, 1e-6);
  ::testing::Test::RecordProperty("rms_height", std::to_string(estimate.rms_height * 1e9));
  ::testing::Test::RecordProperty(
      "height_error", std::to_string(1e12 * (estimate.rms_height / std::sqrt(mean_square(height)) - 1)));
  ::testing::Test::RecordProperty("rms_slope", std::to_string(estimate.rms_slope * 1e6));
}

void expect_psd_slope_of_a_plain_recomputation(const HeightMap& map, const PsdEstimate& estimate) {
  int equals = 0;
  const Rectangle largest = largest_rectangle(outside_of(map.height), &equals);
  ASSERT_EQ(equals, 1);  // no other rectangle has the same area
  const Eigen::Index rows = cut_side(largest.rows), columns = cut_side(largest.columns);
  Grid z = without_quadric(map.height.block(largest.row + (largest.rows - rows) / 2,
                                            largest.column + (largest.columns - columns) / 2, rows, columns));
  bridge(&z);
  const Grid psd = periodogram(z, map.pitch_x);
  EXPECT_NEAR(estimate.resolution * double(std::max(rows, columns)) * map.pitch_x, 1, 1e-12);
  for (const auto& [from, to] : {std::pair{kBandFrom, kBandTo}, std::pair{300., 1500.}}) {
    const double plain = plain_exponent(psd, map.pitch_x, from, to),
                 ours = test::psd_slope(estimate, from, to).exponent;
    EXPECT_NEAR(ours, plain, 0.01) << from << " to " << to;
    ::testing::Test::RecordProperty("exponent_" + std::to_string(int(from)), std::to_string(ours));
    ::testing::Test::RecordProperty("exponent_difference_" + std::to_string(int(from)),
                                    std::to_string(1e9 * (ours - plain)));
  }
}

}  // namespace

// Both comparisons share one estimate, which takes most of the time.
void expect_a_plain_recomputation(const HeightMap& map) {
  const PsdEstimate estimate = estimate_without_lines(map);
  expect_rms_of_a_plain_recomputation(map, estimate);
  expect_psd_slope_of_a_plain_recomputation(map, estimate);
}

TEST(PsdEstimateOfAPart, RmsValuesAndSlopeOfThePsdAreThoseOfAPlainRecomputation) {
  expect_a_plain_recomputation(made_map());
}

TEST_F(PsdEstimateZygoOnRealData, RmsValuesAndSlopeOfThePsdAreThoseOfAPlainRecomputation) {
  EXPECT_EQ(valid_count(zygo_map()), 136359);  // from the README of the map
  expect_a_plain_recomputation(zygo_map());
}

// Estimator of the README of tests/data/psd-tables: a centred square, zeros in holes, rings one step wide.
TEST_F(PsdEstimateZygoOnRealData, SlopeOfThePsdIsThatOfACentredSquare) {
  const HeightMap map = zygo_map();
  const Eigen::ArrayXXi outside = outside_of(map.height);
  Eigen::Index side = 2;
  const Eigen::Index row = map.rows() / 2, column = map.columns() / 2;
  while (side + 2 <= map.columns() &&
         outside.block(row - side / 2 - 1, column - side / 2 - 1, side + 2, side + 2).sum() == 0)
    side += 2;
  ASSERT_GT(side, 250);
  Grid z = without_quadric(map.height.block(row - side / 2, column - side / 2, side, side));
  z = z.isNaN().select(Grid::Zero(side, side), z);
  const Grid psd = periodogram(z, map.pitch_x);
  std::vector<double> sum(std::size_t(side), 0), count = sum;
  for (Eigen::Index r = 0; r < side; ++r)
    for (Eigen::Index c = 0; c < side; ++c) {
      const auto ring = std::size_t(std::lround(std::hypot(r - side / 2, c - side / 2)));
      sum[ring] += psd(r, c), ++count[ring];
    }
  const double step = 1 / (double(side) * map.pitch_x);
  Line square;
  for (std::size_t ring = 2; ring < std::size_t(side / 2); ++ring)
    if (double(ring) * step >= kBandFrom && double(ring) * step <= kBandTo)
      square.add(count[ring], std::log(double(ring) * step), std::log(sum[ring] / count[ring]));
  Line table;
  std::ifstream file(std::string(ABERFIT_TEST_DATA) + "/psd-tables/prysm_zygo_radial_psd.csv");
  for (std::string text; std::getline(file, text);) {
    double f, level, samples;  // [1/mm], [nm^2 mm^2]
    if (std::sscanf(text.c_str(), "%lf,%lf,%lf", &f, &level, &samples) == 3 && 1e3 * f >= kBandFrom &&
        1e3 * f <= kBandTo)
      table.add(samples, std::log(1e3 * f), std::log(1e-24 * level));
  }
  // The default estimator, including the search for lines.
  const double ours = test::psd_slope(estimate_psd(map, {}, 2), kBandFrom, kBandTo).exponent;
  EXPECT_NEAR(ours, -square.slope(), 0.1);
  EXPECT_NEAR(ours, -table.slope(), 0.1);
  RecordProperty("square_side", int(side));
  RecordProperty("exponents", std::to_string(ours) + " " + std::to_string(-square.slope()) + " " +
                                  std::to_string(-table.slope()));
}
