#include "../../src/roughness/power_waves.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "../../src/roughness/wave_sum.h"
#include "aberfit/core/quadrature.h"

using namespace aberfit;
using namespace aberfit::internal;
using std::numbers::pi;

TEST(WaveSum, AgreesWithTheLibraryOnEveryInstructionSet) {
  constexpr int kBlocks = 3;
  const int pairs[kBlocks] = {1, 3, 0};
  std::vector<double> data;
  double truth = 0, size = 0;
  const double r = 0.37, y = 0.83;
  for (int block = 0; block < kBlocks; ++block) {
    const std::size_t at = data.size();
    for (int i = 0; i < kWaveBlock; ++i) data.push_back((i % 2 ? -1 : 1) * 11.3 * (16 * block + i));
    for (int n = 0; n < 2 * pairs[block] * kWaveBlock; ++n) data.push_back(std::sin(1.7 * n + block));
    for (int i = 0; i < kWaveBlock; ++i) {
      double a = 0, b = 0;
      for (int n = 0; n < pairs[block]; ++n) {
        const std::size_t pair = at + std::size_t(kWaveBlock + 2 * n * kWaveBlock + i);
        a += data[pair] * std::pow(y, 2 * n);
        b += data[pair + kWaveBlock] * std::pow(y, 2 * n + 1);
      }
      const double phase = 2 * pi * r * data[at + std::size_t(i)];
      truth += b * (std::cos(phase) + std::sin(phase)) - a * (std::sin(phase) - std::cos(phase));
      size += std::abs(a) + std::abs(b);
    }
  }
  // The error per wave is 2e-15 + 1e-15 r f, with r f up to 200.
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    EXPECT_NEAR(wave_sum(r, y, data.data(), pairs, kBlocks, set), truth, 2e-13 * size);
  }
}

TEST(PowerWaves, OfStretchesThatMeetAreTheIntegralOfEach) {
  // S is steep, like a noisy table. The reference is Gauss-Legendre quadrature with the library's J0.
  const double edges[] = {40, 44, 50, 60}, exponents[] = {2.2, -9.0, 14.0};
  double psd[4] = {1.0};
  for (int s = 0; s < 3; ++s) psd[s + 1] = psd[s] * std::pow(edges[s + 1] / edges[s], -exponents[s]);
  std::vector<PowerStretch> stretches;
  double smallest = 0;
  for (int s = 0; s < 3; ++s) {
    stretches.emplace_back(edges[s], edges[s + 1], exponents[s]);
    smallest = std::max(smallest, stretches.back().smallest());
  }
  const double k = smallest / edges[0];
  PowerWaves waves(k);
  double mass = 0;
  const double node = 47.0, node_weight = 0.2;
  ASSERT_TRUE(waves.carries(node));
  for (int s = 0; s < 3; ++s)
    waves.add(stretches[std::size_t(s)], edges[s], psd[s], edges[s + 1], psd[s + 1]);
  waves.add_node(node, node_weight);
  for (int s = 0; s < 3; ++s) mass += 2 * pi * psd[s] * edges[s] * (edges[s + 1] - edges[s]);
  waves.arrange(mass);
  for (const double factor : {1.0, 1.3, 1.9, 7.7}) {
    const double r = factor * k / (2 * pi);
    double truth = node_weight * boost::math::cyl_bessel_j(0, 2 * pi * r * node);
    for (int s = 0; s < 3; ++s) {
      const Quadrature rule = gauss_legendre(400, edges[s], edges[s + 1]);
      for (int j = 0; j < 400; ++j)
        truth += rule.weights[j] * 2 * pi * rule.nodes[j] * psd[s] *
                 std::pow(rule.nodes[j] / edges[s], -exponents[s]) *
                 boost::math::cyl_bessel_j(0, 2 * pi * r * rule.nodes[j]);
    }
    // 1e-15 of the series, and rounding of phases.
    EXPECT_NEAR(waves(r) / mass, truth / mass, 1e-14) << factor;
  }
}
