#include "polar_rule.h"

#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/smooth_number.h"

namespace aberfit::internal {
namespace {

constexpr double kGoldenAngle = kPi * (3.0 - 2.2360679774997896);

}  // namespace

std::int64_t nearest_smooth(std::int64_t wanted) {
  for (std::int64_t away = 0;; ++away) {
    if (wanted - away >= 1 && is_smooth(wanted - away, 5)) return wanted - away;
    if (wanted + away >= 1 && is_smooth(wanted + away, 5)) return wanted + away;
  }
}

PupilSample polar_rule(double inner, double outer, std::int64_t rings, std::int64_t spokes) {
  const Quadrature rule = gauss_legendre(int(rings), inner * inner, outer * outer);

  PupilSample pupil;
  pupil.layout = PupilLayout::kPolar;
  PolarRings structure{Eigen::ArrayXd(rings), Eigen::ArrayXd(rings), spokes};
  pupil.x.resize(rings * spokes);
  pupil.y.resize(rings * spokes);
  pupil.weight.resize(rings * spokes);
  for (Eigen::Index i = 0, k = 0; i < rings; ++i) {
    const double rho = std::sqrt(rule.nodes[i]);
    const double weight = rule.weights[i] / ((outer * outer - inner * inner) * double(spokes));
    // Rotating the rings against each other keeps each ring exact and avoids aligned spokes, which matter for
    // discontinuous functions. The turn is reduced modulo a full turn, so angles keep their last digits.
    const double turn = std::remainder(kGoldenAngle * double(i), kTwoPi);
    structure.rho[i] = rho;
    structure.turn[i] = turn;
    for (Eigen::Index j = 0; j < spokes; ++j, ++k) {
      const double angle = kTwoPi * double(j) / double(spokes) + turn;
      pupil.x[k] = rho * std::cos(angle);
      pupil.y[k] = rho * std::sin(angle);
      pupil.weight[k] = weight;
    }
  }
  pupil.structure = std::move(structure);
  return pupil;
}

}  // namespace aberfit::internal
