// Transforms of odd, prime and oblong sizes, and sums over very many rays. The truth is direct sums in long
// double.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/roughness/fourier_transform.h"
#include "edge.h"

namespace aberfit::test {
namespace {

using Complex = std::complex<double>;
using LongComplex = std::complex<long double>;

std::vector<Complex> random_field(int size) {
  const RandomStream stream(std::uint64_t(size), "transform-edge");
  std::vector<Complex> values(static_cast<std::size_t>(size));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [re, im] = stream.normal_pair(i);
    values[i] = {re, im};
  }
  return values;
}

// Roots exp(-2 pi i k/n), each from its own angle.
std::vector<LongComplex> roots(int n) {
  std::vector<LongComplex> result(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k)
    result[std::size_t(k)] = std::polar(1.0L, -2 * std::numbers::pi_v<long double> * k / n);
  return result;
}

// Transform of one line by the definition.
std::vector<LongComplex> direct(const std::vector<LongComplex>& line) {
  const std::size_t n = line.size();
  const std::vector<LongComplex> root = roots(int(n));
  std::vector<LongComplex> result(n);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t j = 0; j < n; ++j) result[r] += line[j] * root[r * j % n];
  return result;
}

// The naive form of the definition: each root from the one before by multiplication.
std::vector<Complex> by_recurrence(const std::vector<Complex>& line) {
  const std::size_t n = line.size();
  std::vector<Complex> result(n);
  for (std::size_t r = 0; r < n; ++r) {
    const Complex step = std::polar(1.0, -2 * std::numbers::pi * double(r) / double(n));
    Complex root = 1;
    for (std::size_t j = 0; j < n; ++j, root *= step) result[r] += line[j] * root;
  }
  return result;
}

template <class Found>
double relative_error(const std::vector<Found>& found, const std::vector<LongComplex>& truth) {
  long double error = 0, size = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    error += std::norm(LongComplex(found[i]) - truth[i]), size += std::norm(truth[i]);
  return double(std::sqrt(error / size));
}

// Schatzman 1996: the RMS error of a good fast transform is eps times a few roots of log n. Here it has room
// for Bluestein's three transforms of a prime.
double promised(int size) { return 1e-16 * (2 + 2 * std::log2(double(size))); }

TEST(StabilityEdge, TransformsOfOddAndPrimeLengths) {
  Edge edge("transform_lengths", "length n of the line (powers of 2, primes, odd products) [1]",
            "RMS error / RMS [1]");
  for (const int n :
       {1, 2, 3, 5, 7, 11, 13, 64, 97, 121, 127, 255, 256, 343, 509, 997, 1001, 1024, 1999, 2048, 2187}) {
    std::vector<Complex> line = random_field(n);
    const std::vector<LongComplex> truth = direct({line.begin(), line.end()});
    const double avoided = relative_error(by_recurrence(line), truth);
    fourier_transform(1, n, line.data());
    edge.add({double(n), relative_error(line, truth), promised(n), false, avoided});
  }
  // Errors of the roots grow by eps per step, at random: r^2 = sum of (eps k)^2/3 ...
  edge.follows({"roots by recurrence: 5e-17 n", [](double n) { return 5e-17 * n; }, 60, 2200, 4});
  edge.expect();
}

TEST(StabilityEdge, TransformsOfOblongFields) {
  // 2310 values in ever longer rows; the truth is both transforms by the definition.
  constexpr int kSize = 2310;
  for (const int rows : {1, 2, 11, 42, 77, 210, 1155, 2310}) {
    const int columns = kSize / rows;
    std::vector<Complex> field = random_field(kSize);
    std::vector<LongComplex> truth(field.begin(), field.end());
    for (int j = 0; j < rows; ++j) {
      const auto first = truth.begin() + j * columns;
      const std::vector<LongComplex> line = direct({first, first + columns});
      std::copy(line.begin(), line.end(), first);
    }
    for (int k = 0; k < columns; ++k) {
      std::vector<LongComplex> line;
      for (int j = 0; j < rows; ++j) line.push_back(truth[std::size_t(j * columns + k)]);
      line = direct(line);
      for (int j = 0; j < rows; ++j) truth[std::size_t(j * columns + k)] = line[std::size_t(j)];
    }
    fourier_transform(rows, columns, field.data());
    EXPECT_LT(relative_error(field, truth), promised(kSize)) << rows << " x " << columns;
  }
}

// RMS radius of N rays whose weights and places spread over four decades.
TEST(StabilityEdge, SumsOverManyRays) {
  Edge edge("sums_over_rays", "rays N [1]", "relative error of the RMS radius [1]");
  constexpr Eigen::Index kMost = 10'000'000;
  RayBundle all;
  for (Eigen::ArrayXd* part : {&all.x, &all.y, &all.tx, &all.ty, &all.weight}) part->setZero(kMost);
  for (Eigen::Index i = 0; i < kMost; ++i) {  // golden ratio: any even spread will do
    const double t = double(i) * 0.6180339887498949, u = t - std::floor(t);
    all.x[i] = 1e-6 * std::pow(10.0, 2 * u), all.weight[i] = 1e-7 * (1 + u);
  }
  for (const Eigen::Index count : {1000, 10000, 100000, 1000000, 10000000}) {
    const RayBundle* rays = &all;
    RayBundle head;
    if (count < kMost) {
      for (auto part : {&RayBundle::x, &RayBundle::y, &RayBundle::tx, &RayBundle::ty, &RayBundle::weight})
        head.*part = (all.*part).head(count);
      rays = &head;
    }
    long double squares = 0, weights = 0;
    float short_squares = 0, short_weights = 0;
    for (Eigen::Index i = 0; i < count; ++i) {
      const long double w = all.weight[i], x = all.x[i];
      squares += w * x * x, weights += w;
      short_squares += float(w * x * x), short_weights += float(w);
    }
    const long double truth = std::sqrt(squares / weights);
    const double found = evaluate_exact({*rays, *rays, {}}, {RmsRadius{}}, 1)[0];
    edge.add({double(count), double(std::abs(found / truth - 1)), 1e-13, false,
              double(std::abs(std::sqrt(short_squares / short_weights) / truth - 1))});
  }
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
