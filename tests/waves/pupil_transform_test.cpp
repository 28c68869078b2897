// Compares the transforms of pupils with direct sums.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "../../src/waves/diffraction_transform.h"
#include "aberfit/core/random.h"

namespace aberfit::internal {
namespace {

using Complex = std::complex<double>;

std::vector<double> normals(std::size_t count, const char* name) {
  const RandomStream stream(3, name);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = stream.normal(i);
  return values;
}

// Pupils of odd and even sizes, of one and several blocks of columns, square and not.
struct Fields {
  int rows, columns;
  double padding;
};

// Random field on the cells of a pupil.
class Field {
 public:
  explicit Field(const Fields& of)
      : of_(of), random_(normals(2 * std::size_t(of.rows * of.columns), "pupil")) {}
  Complex operator()(int row, int column) const {
    const auto at = 2 * std::size_t(row * of_.columns + column);
    return {random_[at], random_[at + 1]};
  }
  void put(const PupilTransform& transform, PupilTransform::Buffers* b) const {
    for (int row = 0; row < of_.rows; ++row)
      for (int column = 0; column < of_.columns; ++column) {
        const std::size_t at = transform.pupil().at(std::size_t(row), std::size_t(column));
        b->pupil.data()[at] = (*this)(row, column).real();
        b->pupil.data()[at + kLines] = (*this)(row, column).imag();
      }
  }

 private:
  Fields of_;
  std::vector<double> random_;
};

// Writes g at the existing lags, row after row of the pupil.
void put_kernel(const std::vector<double>& g, const PupilTransform& transform, PupilTransform::Buffers* b) {
  std::fill_n(b->quarter.data(), transform.quarter_size(), 0.0);
  for (int my = 0; my < transform.lag_rows(); ++my)
    for (int mx = 0; mx < transform.lag_columns(); ++mx)
      b->quarter.data()[std::size_t(my) * transform.quarter_stride() + std::size_t(mx)] =
          g[std::size_t(my * transform.columns() + mx)];
}

// relative to the largest sum
struct Rounding {
  Precision precision;
  double forth, back;
};
constexpr Rounding kRoundings[] = {{Precision::kDouble, 1e-14, 1e-13}, {Precision::kSingle, 2e-7, 4e-6}};

// A random field in focus, with its correlation.
struct Focused {
  Focused(const Fields& c, Precision precision)
      : transform(c.rows, c.columns, c.padding, precision),
        buffers(transform),
        light(c),
        focal(transform.focal_size(), precision) {
    light.put(transform, &buffers);
    transform.to_focus(&focal, &buffers);
    transform.correlation(focal, &buffers);
  }
  // The result of `correlation` at a lag.
  double even(int my, int mx) const {
    return buffers.quarter.data()[std::size_t(my) * transform.quarter_stride() + std::size_t(mx)];
  }
  // Transforms back to the pupil with a kernel.
  void go_back(const std::vector<double>& g) {
    put_kernel(g, transform, &buffers);
    transform.kernel(&buffers.kernel, &buffers);
    transform.back_to_pupil(focal, buffers.kernel, &buffers);
  }
  Complex back(int row, int column) const {
    const std::size_t at = transform.pupil().at(std::size_t(row), std::size_t(column));
    return {buffers.back.data()[at], buffers.back.data()[at + kLines]};
  }

  PupilTransform transform;
  PupilTransform::Buffers buffers;
  Field light;
  AlignedArray focal;
};

void expect_sums_there_and_back(const Fields& c, const Rounding& rounding) {
  Focused focused(c, rounding.precision);
  const PupilTransform& transform = focused.transform;
  const Field& e = focused.light;
  const int m_x = transform.m_columns(), m_y = transform.m_rows();
  ASSERT_GE(m_x, 2 * c.columns - 1);
  ASSERT_GE(m_y, 2 * c.rows - 1);
  const double power = double(m_x) * m_y;
  // C_m by its definition. Circles need only its even part.
  const auto correlation = [&](int my, int mx) {
    Complex sum = 0;
    for (int row = std::max(0, -my); row + std::max(my, 0) < c.rows; ++row)
      for (int column = std::max(0, -mx); column + std::max(mx, 0) < c.columns; ++column)
        sum += e(row + my, column + mx) * std::conj(e(row, column));
    return sum;
  };
  const double scale = power * std::abs(correlation(0, 0));
  for (int my = 0; my < c.rows; ++my)
    for (int mx = 0; mx < c.columns; ++mx)
      EXPECT_NEAR(focused.even(my, mx), 0.5 * power * (correlation(my, mx) + correlation(my, -mx)).real(),
                  rounding.forth * scale);
  Eigen::ArrayXcd along_x, along_y;
  transform.axis_correlations(focused.focal, &along_x, &along_y);
  for (int m = 0; m < c.columns; ++m)
    EXPECT_LE(std::abs(along_x[m] - power * correlation(0, m)), rounding.forth * scale);
  for (int m = 0; m < c.rows; ++m)
    EXPECT_LE(std::abs(along_y[m] - power * correlation(m, 0)), rounding.forth * scale);

  // Back transform with a kernel g: V_k = M sum_m g(m) E_(k+m).
  const std::vector<double> g = normals(std::size_t(c.rows * c.columns), "kernel");
  focused.go_back(g);
  for (int row = 0; row < c.rows; ++row)
    for (int column = 0; column < c.columns; ++column) {
      Complex sum = 0;
      for (int j = 0; j < c.rows; ++j)
        for (int i = 0; i < c.columns; ++i)
          sum += g[std::size_t(std::abs(j - row) * c.columns + std::abs(i - column))] * e(j, i);
      EXPECT_LE(std::abs(focused.back(row, column) - power * sum), rounding.back * scale);
    }
}

TEST(PupilTransform, IsItsSumThereAndBack) {
  for (const Rounding& rounding : kRoundings)
    for (const Fields& c : {Fields{5, 7, 2}, Fields{16, 16, 2}, Fields{9, 21, 2.7}, Fields{33, 12, 2}})
      expect_sums_there_and_back(c, rounding);
}

// With fewer samples, a lag merges with those that are m_x or m_y away, in correlations and in kernels.
void expect_folded_lags(const Fields& c, const Rounding& rounding) {
  Focused focused(c, rounding.precision);
  const PupilTransform& transform = focused.transform;
  const Field& e = focused.light;
  const int m_x = transform.m_columns(), m_y = transform.m_rows();
  ASSERT_LT(m_x, 2 * c.columns - 1);
  const auto folded = [&](int my, int mx) {
    Complex sum = 0;
    for (int row = 0; row < c.rows; ++row)
      for (int column = 0; column < c.columns; ++column)
        for (int other = (row + my + 2 * m_y) % m_y; other < c.rows; other += m_y)
          for (int beside = (column + mx + 2 * m_x) % m_x; beside < c.columns; beside += m_x)
            sum += e(other, beside) * std::conj(e(row, column));
    return sum;
  };
  const double power = double(m_x) * m_y, scale = power * std::abs(folded(0, 0));
  for (int my = 0; my < transform.lag_rows(); ++my)
    for (int mx = 0; mx < transform.lag_columns(); ++mx)
      EXPECT_NEAR(focused.even(my, mx), 0.5 * power * (folded(my, mx) + folded(my, -mx)).real(),
                  rounding.forth * scale);

  const std::vector<double> g = normals(std::size_t(c.rows * c.columns), "kernel");
  focused.go_back(g);
  for (int row = 0; row < c.rows; ++row)
    for (int column = 0; column < c.columns; ++column) {
      Complex sum = 0;
      for (int my = 1 - transform.lag_rows(); my < transform.lag_rows(); ++my)
        for (int mx = 1 - transform.lag_columns(); mx < transform.lag_columns(); ++mx)
          for (int j = (row + my + 2 * m_y) % m_y; j < c.rows; j += m_y)
            for (int i = (column + mx + 2 * m_x) % m_x; i < c.columns; i += m_x)
              sum += g[std::size_t(std::abs(my) * c.columns + std::abs(mx))] * e(j, i);
      EXPECT_LE(std::abs(focused.back(row, column) - power * sum), rounding.back * scale);
    }
}

TEST(PupilTransform, OfFewSamplesFoldsLags) {
  for (const Rounding& rounding : kRoundings)
    for (const Fields& c : {Fields{16, 16, 1}, Fields{9, 21, 1}, Fields{33, 12, 1.3}, Fields{40, 28, 1}})
      expect_folded_lags(c, rounding);
}

}  // namespace
}  // namespace aberfit::internal
