#pragma once
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/fourier_transform.h"

namespace aberfit::test {

inline constexpr Eigen::Index kLinePoints = 1024;
inline constexpr double kLinePitch = 1e-3;  // [m]: 1 to 500 cycles/m

using Spectrum = std::function<double(double)>;  // one-sided [m^3]

// An eighth of a periodic line of independent Gaussian ordinates, as exact heights or exact slopes.
inline Profile random_line(const Spectrum& spectrum, ProfileQuantity quantity, Eigen::Index points,
                           const RandomStream& stream) {
  constexpr int kOversize = 8;
  const int n = int(points) * kOversize;
  const double step = 1 / (n * kLinePitch);
  std::vector<std::complex<double>> values(std::size_t(n), 0.0);
  for (int k = 1; k < n / 2; ++k) {
    const auto [re, im] = stream.normal_pair(std::uint64_t(k));
    values[std::size_t(k)] = std::sqrt(spectrum(k * step) * step) * std::complex<double>(re, im);
    if (quantity == ProfileQuantity::kSlope)
      values[std::size_t(k)] *= std::complex<double>(0, 2 * std::numbers::pi * k * step);
  }
  fourier_transform(1, n, values.data());
  Profile profile;
  profile.quantity = quantity;
  profile.x = Eigen::ArrayXd::LinSpaced(points, 0, double(points - 1) * kLinePitch);
  profile.value.resize(points);
  for (Eigen::Index i = 0; i < points; ++i) profile.value[i] = values[std::size_t(i)].real();
  return profile;
}
inline Profile random_line(const Spectrum& spectrum, ProfileQuantity quantity, int seed) {
  return random_line(spectrum, quantity, kLinePoints, RandomStream(std::uint64_t(seed), "random line"));
}

}  // namespace aberfit::test
