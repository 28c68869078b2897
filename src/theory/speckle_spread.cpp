#include "speckle_spread.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {
namespace {

constexpr int kPanelNodesOfShear = 12, kFewestPanels = 12, kHalvings = 10;
constexpr double kCyclesPerPanel = 3;
constexpr int kNodesOfRadius = 32;

}  // namespace

SpeckleSpread::SpeckleSpread(const RadialPsd& psd, const Scene& scene, std::vector<double> cuts)
    : scene_(scene), cuts_(std::move(cuts)) {
  // Panels of one width up to the diameter; the first is halved towards 0, where a rough surface has all of
  // its transfer function.
  const int panels = std::max(kFewestPanels, int(std::ceil(scene.cycles / kCyclesPerPanel)));
  std::vector<double> edges{0};
  for (int i = kHalvings; i > 0; --i) edges.push_back(scene.diameter / panels * std::pow(0.5, i));
  for (int i = 1; i <= panels; ++i) edges.push_back(scene.diameter * i / panels);
  const Eigen::Index count = (Eigen::Index(edges.size()) - 1) * kPanelNodesOfShear;
  shear_.resize(count), weight_.resize(count);
  for (std::size_t p = 0; p + 1 < edges.size(); ++p) {
    const Quadrature rule = gauss_legendre(kPanelNodesOfShear, edges[p], edges[p + 1]);
    shear_.segment<kPanelNodesOfShear>(Eigen::Index(p) * kPanelNodesOfShear) = rule.nodes;
    weight_.segment<kPanelNodesOfShear>(Eigen::Index(p) * kPanelNodesOfShear) = rule.weights;
  }
  const double square = scene.wave_number * scene.wave_number;
  const auto columns = Eigen::Index(cuts_.size());
  const Eigen::ArrayXd all = square * structure_function(psd, shear_);
  factor_.resize(count, 1 + 2 * columns);
  factor_.col(0) = (-all).exp();
  for (Eigen::Index c = 0; c < columns; ++c) {
    const RadialPsd rest = psd.band(cuts_[std::size_t(c)], psd.f_max());
    const double limit = square * radial_moment(rest, 0);
    const Eigen::ArrayXd here = square * structure_function(rest, shear_), low = (all - here).max(0.0);
    factor_.col(1 + c) = (-low - limit).exp();
    factor_.col(1 + columns + c) = factor_.col(1 + c) - (-low - 2 * limit + here).exp();
  }
}

Eigen::ArrayXXd SpeckleSpread::variance(const Eigen::ArrayXd& transfer, double pitch, double distance,
                                        const std::vector<double>& radius) const {
  const auto columns = Eigen::Index(cuts_.size());
  Eigen::MatrixXd weighted(shear_.size(), factor_.cols());
  for (Eigen::Index i = 0; i < shear_.size(); ++i) {
    const double place = shear_[i] / pitch;
    const auto k = Eigen::Index(place);
    const double smooth =
        k + 1 < transfer.size() ? transfer[k] + (place - double(k)) * (transfer[k + 1] - transfer[k]) : 0;
    weighted.row(i) = (kTwoPi * weight_[i] * shear_[i] * smooth) * factor_.row(i).matrix();
  }
  // Over q = X/(lambda F), and its root, since the core is narrow beside a wide disc.
  const Quadrature rule = gauss_legendre(kNodesOfRadius, 0, 1);
  Eigen::ArrayXXd result(Eigen::Index(radius.size()), columns);
  Eigen::MatrixXd bessel(shear_.size(), kNodesOfRadius);
  Eigen::ArrayXd z(shear_.size()), unused(shear_.size());
  for (std::size_t d = 0; d < radius.size(); ++d) {
    const double rim = radius[d] / (scene_.wavelength * distance);
    for (int k = 0; k < kNodesOfRadius; ++k) {
      z = kTwoPi * rim * rule.nodes[k] * rule.nodes[k] * shear_;
      bessel_j0_j1(z.data(), int(z.size()), bessel.col(k).data(), unused.data());
    }
    const Eigen::ArrayXXd irradiance = (bessel.transpose() * weighted).array();
    const Eigen::ArrayXd area = 4 * kPi * rim * rim * rule.weights * rule.nodes.cube();
    for (Eigen::Index c = 0; c < columns; ++c) {
      const Eigen::ArrayXd core = irradiance.col(1 + c), halo = irradiance.col(0) - core;
      result(Eigen::Index(d), c) =
          (area * (halo.square() + 2 * core * (halo - irradiance.col(1 + columns + c)))).sum() / scene_.area;
    }
  }
  return result.max(0.0);
}

}  // namespace aberfit::internal
