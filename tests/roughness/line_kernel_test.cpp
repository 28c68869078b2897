// Compares the transforms of lines with direct sums, for every instruction set.
#include "aberfit/roughness/line_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"

namespace aberfit {
namespace {

using Complex = std::complex<double>;
// Relative to the largest sum times the root of log2 n: 14 units in the last place; largest in double 5.
template <typename Real>
constexpr double kRounding = 14 * std::numeric_limits<Real>::epsilon();

template <typename Real>
class LineKernelOf : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(LineKernelOf, Precisions);

std::vector<double> normals(std::size_t count, const char* name) {
  const RandomStream stream(3, name);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = stream.normal(i);
  return values;
}

Complex phasor(double turns) { return std::polar(1.0, 2 * std::numbers::pi * (turns - std::floor(turns))); }

std::vector<InstructionSet> supported_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512})
    if (is_supported(set)) sets.push_back(set);
  return sets;
}

// Lines longer than their transform, for both parts of two: elements n apart are added.
TYPED_TEST(LineKernelOf, FoldsWhatIsLongerThanATransform) {
  using Real = TypeParam;
  for (const InstructionSet set : supported_sets())
    for (const int n : {5, 16, 42}) {
      const LinePlan<Real> plan(n);
      for (const int count : {n + 1, (3 * n + 1) / 2, 2 * n})
        for (const int part : {0, 1}) {
          const std::vector<double> in = normals(16 * std::size_t(count), "line");
          const std::vector<Real> phases = line_phases<Real>(n, part, 2);
          std::vector<Real> work(16 * (4 * std::size_t(n) + 24)), out(16 * std::size_t(n));
          line_kernels<Real>(set).columns_out(plan.steps(), phases.data(), part == 0 ? 1 : -1, in.data(), 16,
                                              count, out.data(), 16, work.data());
          for (int x = 0; x < n; ++x)
            for (int line = 0; line < kLines; ++line) {
              Complex sum = 0;
              for (int k = 0; k < count; ++k)
                sum += Complex(in[std::size_t(16 * k + line)], in[std::size_t(16 * k + line + 8)]) *
                       phasor(-double((2 * x + part) * k % (2 * n)) / (2 * n));
              const Complex got(out[std::size_t(16 * x + line)], out[std::size_t(16 * x + line + 8)]);
              EXPECT_LE(std::abs(got - sum),
                        450 * std::numeric_limits<Real>::epsilon() * std::sqrt(double(count)))
                  << n << ' ' << count << ' ' << part;
            }
        }
    }
}

TYPED_TEST(LineKernelOf, TransformsOfEveryRadixAreTheirSums) {
  using Real = TypeParam;
  for (const InstructionSet set : supported_sets()) {
    for (const int n : {1, 2, 3, 4, 5, 7, 8, 16, 32, 64, 35, 42, 120, 126, 128, 210, 256}) {
      const LinePlan<Real> plan(n);
      const std::vector<double> in = normals(16 * std::size_t(n), "line");
      const int count = (2 * n + 2) / 3;  // the rest is zero
      for (const int part : {0, 1, 2}) {
        const std::vector<Real> phases = line_phases<Real>(n, part, 3);
        std::vector<Real> work(16 * (3 * std::size_t(n) + 24)), out(16 * std::size_t(n));
        line_kernels<Real>(set).columns_out(plan.steps(), phases.data(), 1, in.data(), 16, count, out.data(),
                                            16, work.data());
        double error = 0, largest = 0;
        for (int x = 0; x < n; ++x)
          for (int line = 0; line < kLines; ++line) {
            Complex sum = 0;
            for (int k = 0; k < count; ++k)
              sum += Complex(in[std::size_t(16 * k + line)], in[std::size_t(16 * k + line + 8)]) *
                     phasor(-double((3 * x + part) * k % (3 * n)) / (3 * n));
            const Complex got(out[std::size_t(16 * x + line)], out[std::size_t(16 * x + line + 8)]);
            error = std::max(error, std::abs(got - sum));
            largest = std::max(largest, std::abs(sum));
          }
        EXPECT_LE(error, kRounding<Real> * std::sqrt(1 + std::log2(n)) * largest) << n << " part " << part;
      }
    }
  }
}

// The cases have odd and even lengths, missing rows and shortened rows.
TEST(LineKernel, RealRowsAreTheSumsOfTheirHermitianHalves) {
  for (const InstructionSet set : supported_sets())
    for (const int n : {1, 2, 9, 15, 30, 64}) {
      const LinePlan<double> plan(n);
      const int half = n / 2, blocks = half / kLines + 1, count = n - n / 4;
      const auto stride = std::size_t(16 * blocks);
      std::vector<double> in = normals(16 * stride, "hermitian"), out(std::size_t(16 * count), -1.0),
                          work(16 * (3 * std::size_t(n) + 24));
      const auto part = [&](int row, int k, int imaginary) -> double& {
        return in[std::size_t(row) * stride + std::size_t(k / 8 * 16 + k % 8 + 8 * imaginary)];
      };
      const double* from[2][kLines];
      double* to[2][kLines];
      for (int row = 0; row < 16; ++row) {
        part(row, 0, 1) = 0;
        if (n % 2 == 0) part(row, half, 1) = 0;
        const bool there = row < 13;
        from[row / 8][row % 8] = there ? in.data() + std::size_t(row) * stride : nullptr;
        to[row / 8][row % 8] = there ? out.data() + row * count : nullptr;
      }
      line_kernels<double>(set).real_rows(plan.steps(), from[0], from[1], to[0], to[1], count, work.data());
      for (int row = 0; row < 13; ++row)
        for (int x = 0; x < count; ++x) {
          Complex sum = 0;
          for (int k = 0; k < n; ++k) {
            const Complex c = k <= half ? Complex(part(row, k, 0), part(row, k, 1))
                                        : Complex(part(row, n - k, 0), -part(row, n - k, 1));
            sum += c * phasor(-double(k) * x / n);
          }
          EXPECT_NEAR(out[std::size_t(row * count + x)], sum.real(), 1e-13 * std::sqrt(double(n))) << n;
        }
      EXPECT_EQ(out[std::size_t(13 * count)], -1.0);
    }
}

}  // namespace
}  // namespace aberfit
