// Compares the FWHM of line spreads with a slow method: the sum over rays in long double, with bisection.
#include "../../src/focus/line_spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "aberfit/core/random.h"

using aberfit::RandomStream;
using aberfit::internal::line_spread_fwhm;

namespace {

using Real = long double;

struct Line {
  std::string name;
  Eigen::ArrayXd position, weight;
  double bandwidth;
};

Line line(const std::string& name, Eigen::Index n, double bandwidth) {
  const RandomStream stream(std::uint64_t(n), name);
  Line result{name, Eigen::ArrayXd(n), Eigen::ArrayXd(n), bandwidth};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double u = stream.uniform(std::uint64_t(i)), normal = stream.normal(std::uint64_t(i) + (1 << 20));
    double& x = result.position[i];
    result.weight[i] = 0.1 + stream.uniform(std::uint64_t(i) + (1 << 22));
    if (name == "gaussian") x = normal;
    if (name == "far from the origin") x = 1e4 + normal;
    if (name == "two lumps") x = 0.3 * normal + (u < 0.45 ? -2.0 : 2.0);  // the lower peak is above half
    if (name == "three lumps") x = 0.2 * normal + (u < 0.4 ? -2.0 : u < 0.8 ? 0.0 : 1.5);
    if (name == "heavy tail") x = std::tan(std::numbers::pi * (u - 0.5));
    if (name == "one far away") x = i == n / 3 ? 1e3 : normal;
    if (name == "comb") x = std::floor(10 * u);  // peaks of equal height
    if (name == "some dark") x = normal, result.weight[i] = i % 3 ? result.weight[i] : 0.0;
  }
  result.position *= 1e-5;
  result.bandwidth *= 1e-5;
  return result;
}

Real profile(const Line& of, Real x) {
  Real sum = 0;
  for (Eigen::Index i = 0; i < of.position.size(); ++i) {
    const Real u = (x - Real(of.position[i])) / Real(of.bandwidth);
    if (std::abs(u) < 12) sum += Real(of.weight[i]) * std::exp(double(-u * u / 2));
  }
  return sum;
}

// Scans the interval from `low` to `high` at a twentieth of the bandwidth.
Real slow_fwhm(const Line& of, Real low, Real high) {
  const Real pitch = Real(of.bandwidth) / 20;
  std::vector<Real> at, value;
  for (Real x = low; x < high; x += pitch) at.push_back(x), value.push_back(profile(of, x));
  Real top = 0;
  for (std::size_t k = 1; k + 1 < at.size(); ++k) {
    if (value[k] < value[k - 1] || value[k] < value[k + 1]) continue;
    Real a = at[k - 1], b = at[k + 1];
    for (int i = 0; i < 40; ++i) {
      const Real p = a + (b - a) / 3, q = b - (b - a) / 3;
      (profile(of, p) < profile(of, q) ? a : b) = profile(of, p) < profile(of, q) ? p : q;
    }
    top = std::max(top, profile(of, (a + b) / 2));
  }
  const auto crossing = [&](Real out, Real in) {
    for (int i = 0; i < 70; ++i) {
      const Real middle = (out + in) / 2;
      (profile(of, middle) < top / 2 ? out : in) = middle;
    }
    return in;
  };
  std::size_t first = 0, last = at.size() - 1;
  while (value[first] < top / 2) ++first;
  while (value[last] < top / 2) --last;
  return crossing(at[last + 1], at[last]) - crossing(at[first - 1], at[first]);
}

TEST(LineSpread, IsTheSlowSumOverRays) {
  for (const std::string name : {"gaussian", "far from the origin", "two lumps", "three lumps", "heavy tail",
                                 "one far away", "comb", "some dark"})
    for (const double bandwidth : {0.05, 0.4, 2.0}) {
      const Line of = line(name, 250, bandwidth);
      const double middle = name == "far from the origin" ? 0.1 : name == "comb" ? 4.5e-5 : 0.0;
      const double half = (name == "heavy tail" ? 15e-5 : 6e-5) + 9 * of.bandwidth;
      const auto fwhm = line_spread_fwhm(of.position, of.weight, of.bandwidth, 1.0, nullptr);
      ASSERT_TRUE(fwhm) << name;
      // Far from the origin, rounding of the positions dominates.
      const double rounding = name == "far from the origin" ? 1e-11 : 1e-13;
      EXPECT_NEAR(*fwhm / double(slow_fwhm(of, middle - half, middle + half)), 1.0, rounding)
          << name << ", bandwidth " << bandwidth;
    }
}

TEST(LineSpread, TakesTheHigherOfTwoNearlyEqualPeaks) {
  // The second peak is higher by 1e-5 and lies differently between the points of a scan. The exact peak must
  // win, not the scanned value. A third peak counts if it exceeds half of that by 1e-3.
  for (const double shift : {0.0, 0.013, 0.031, 0.047})
    for (const double excess : {-1e-3, 1e-3}) {
      Line of{"", Eigen::ArrayXd(3), Eigen::ArrayXd(3), 1.0};
      of.position << 0.0, 20.0 + shift, 40.0 + 2 * shift;
      of.weight << 1.0, 1.0 + 1e-5, 0.5 * (1.0 + 1e-5) * (1 + excess);
      const double fwhm = line_spread_fwhm(of.position, of.weight, of.bandwidth, 1.0, nullptr).value();
      EXPECT_NEAR(fwhm / double(slow_fwhm(of, -10, 60)), 1.0, 1e-13) << shift << " " << excess;
    }
}

TEST(LineSpread, GradientIsThatOfTheWidth) {
  for (const std::string name : {"gaussian", "two lumps", "heavy tail", "some dark"}) {
    Line of = line(name, 300, 0.2);
    std::vector<double> gradient;
    ASSERT_TRUE(line_spread_fwhm(of.position, of.weight, of.bandwidth, 0.5, &gradient));
    const RandomStream stream(5, "direction");
    const auto moved = [&](double step) {
      Line there = of;
      for (Eigen::Index i = 0; i < of.position.size(); ++i)
        there.position[i] += 1e-5 * step * stream.normal(std::uint64_t(i));
      return line_spread_fwhm(there.position, there.weight, there.bandwidth, 1.0, nullptr).value();
    };
    double along = 0;
    for (Eigen::Index i = 0; i < of.position.size(); ++i)
      along += 2 * gradient[std::size_t(i)] * 1e-5 * stream.normal(std::uint64_t(i));
    const double h = 1e-3;
    const double difference = (8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h);
    EXPECT_NEAR(along / difference, 1.0, 1e-6) << name;
  }
}

TEST(LineSpread, IsNothingWhereRaysStandAlone) {
  const Line of = line("gaussian", 1000, 1.0);
  EXPECT_FALSE(line_spread_fwhm(of.position, of.weight, 0.0, 1.0, nullptr));
  EXPECT_FALSE(line_spread_fwhm(of.position, of.weight, 1e-5 / 8192, 1.0, nullptr));
  EXPECT_TRUE(line_spread_fwhm(of.position, of.weight, 1e-5 / 2000, 1.0, nullptr));
  EXPECT_FALSE(line_spread_fwhm(of.position, Eigen::ArrayXd::Zero(1000), 1e-6, 1.0, nullptr));
}

}  // namespace
