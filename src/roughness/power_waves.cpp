#include "power_waves.h"

#include <cmath>

#include "aberfit/core/constants.h"
#include "wave_sum.h"

namespace aberfit::internal {

PowerStretch::PowerStretch(double f_min, double f_max, double exponent) : f_min_(f_min), f_max_(f_max) {
  const double q = 0.5 - exponent;
  // h_n = (-i)^n |h_n|, so every second a_n is real and the others are imaginary.
  double h = 1;
  a_[0] = -1;
  for (int n = 1; n < kTerms; ++n) {
    h *= (2 * n - 1) * (2 * n - 1) / (8.0 * n);
    const double step = (q - n + 1) * a_[std::size_t(n - 1)];
    a_[std::size_t(n)] = (n % 4 < 2 ? -h : h) + (n % 2 == 1 ? -step : step);
  }
  smallest_ = std::pow(std::abs(a_.back()) / 1e-15, 1.0 / (kTerms - 1));
}

// int_f^inf = -S f^2 x^(-3/2) pi^(-1/2) (Re a (cos x + sin x) - Im a (sin x - cos x)), x = k f.
void PowerWaves::add_end(const PowerStretch& stretch, double f, double amplitude) {
  const double inverse = 1 / (k_ * f);
  if (ends_.waves.empty() || ends_.waves.back().f != f) ends_.waves.push_back({f, {}});
  std::array<double, PowerStretch::kTerms + 1>& series = ends_.waves.back().series;
  double factor = 2 * std::sqrt(kPi) * amplitude * f * f * inverse * std::sqrt(inverse);
  for (std::size_t n = 0; n < PowerStretch::kTerms; ++n) {
    series[n] += factor * stretch.series()[n];
    factor *= inverse;
  }
}

void PowerWaves::add(const PowerStretch& stretch, double a, double psd_a, double b, double psd_b) {
  add_end(stretch, a, -psd_a);
  add_end(stretch, b, psd_b);
}

// J0(x) = (pi x)^(-1/2) (P (cos x + sin x) - Q (sin x - cos x)), DLMF 10.17.3. P is even in x, but `wave_sum`
// has an odd series there; a negative frequency exchanges the two.
void PowerWaves::add_node(double f, double weight) {
  const double inverse = 1 / (k_ * f);
  Wave& wave = nodes_.waves.emplace_back(Wave{-f, {}});
  double term = weight * std::sqrt(inverse / kPi);
  for (int n = 0; n < PowerStretch::kTerms; ++n) {
    wave.series[std::size_t(n)] = n % 4 == 0 || n % 4 == 3 ? term : -term;
    term *= (2 * n + 1) * (2 * n + 1) / (8.0 * (n + 1)) * inverse;
  }
}

void PowerWaves::arrange(double scale) {
  ends_.arrange(scale);
  nodes_.arrange(scale);
}

void PowerWaves::Set::arrange(double scale) {
  constexpr double kNegligible = 1e-17;
  const std::size_t blocks = (waves.size() + kWaveBlock - 1) / kWaveBlock;
  waves.resize(blocks * kWaveBlock, {0, {}});
  for (std::size_t block = 0; block < blocks; ++block) {
    const Wave* const first = &waves[block * kWaveBlock];
    int terms = 0;
    for (int i = 0; i < kWaveBlock; ++i) {
      data.push_back(first[i].f);
      for (int n = terms; n < PowerStretch::kTerms; ++n)
        if (std::abs(first[i].series[std::size_t(n)]) > kNegligible * scale) terms = n + 1;
    }
    pairs.push_back((terms + 1) / 2);
    for (int n = 0; n < 2 * pairs.back(); ++n)
      for (int i = 0; i < kWaveBlock; ++i) data.push_back(first[i].series[std::size_t(n)]);
  }
  waves.clear();
}

double PowerWaves::operator()(double r) const {
  const double y = k_ / (2 * kPi * r);
  return std::sqrt(y) * (y * wave_sum(r, y, ends_.data.data(), ends_.pairs.data(), int(ends_.pairs.size())) +
                         wave_sum(r, y, nodes_.data.data(), nodes_.pairs.data(), int(nodes_.pairs.size())));
}

}  // namespace aberfit::internal
