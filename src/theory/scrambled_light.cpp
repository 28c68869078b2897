#include "scrambled_light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {
namespace {

constexpr int kFrequencies = 24;
constexpr int kNodesPerPanel = 12, kFewestPanels = 12, kHalvings = 8;
constexpr double kCyclesPerPanel = 3, kMostCycles = 400;
constexpr int kRadii = 72, kAngles = 16;
constexpr double kHalf = 0.5;                 // of I_c I_h
constexpr double kReach = 2.5, kBeyond = 10;  // radii of the largest disc, cycles across the aperture

}  // namespace

ScrambledLight::ScrambledLight(const RadialPsd& psd, const Scene& scene, double low, double high)
    : scene_(scene) {
  const double reach =
      std::min(kReach * scene.largest + kBeyond / scene.diameter, kMostCycles / scene.diameter);
  const double top = std::min(high, 2 * reach);  // light does not move farther between points of the grid
  for (int j = 0; j < kFrequencies; ++j)
    frequency_.push_back(low * std::pow(top / low, (j + 0.5) / kFrequencies));
  set_shears(reach);
  set_radii(reach);
  const double square = scene.wave_number * scene.wave_number;
  const Eigen::ArrayXd all = square * structure_function(psd, shear_);
  below_.resize(shear_.size(), kFrequencies);
  above_.resize(shear_.size(), kFrequencies);
  core_.resize(kFrequencies), core_below_.resize(kFrequencies);
  for (int j = 0; j < kFrequencies; ++j) {
    const double f = frequency_[std::size_t(j)];
    const RadialPsd rest = psd.band(f, psd.f_max());
    const Eigen::ArrayXd exponent = square * structure_function(rest, shear_);
    core_[j] = std::exp(-square * radial_moment(rest, 0));
    above_.col(j) = (-exponent).exp() - core_[j];
    core_below_[j] = std::exp(-square * radial_moment(psd, 0, low, f));
    below_.col(j) = (exponent - all).min(0.0).exp() - core_below_[j];
    moved_.push_back(moved(f));
  }
}

// Panels of one width up to the diameter; the first is halved towards 0, where a rough surface has all of its
// transfer function.
void ScrambledLight::set_shears(double reach) {
  const int panels = std::max(kFewestPanels, int(std::ceil(reach * scene_.diameter / kCyclesPerPanel)));
  std::vector<double> edges{0};
  for (int i = kHalvings; i > 0; --i) edges.push_back(scene_.diameter / panels * std::pow(0.5, i));
  for (int i = 1; i <= panels; ++i) edges.push_back(scene_.diameter * i / panels);
  const Eigen::Index count = (Eigen::Index(edges.size()) - 1) * kNodesPerPanel;
  shear_.resize(count), weight_.resize(count);
  for (std::size_t p = 0; p + 1 < edges.size(); ++p) {
    const Quadrature rule = gauss_legendre(kNodesPerPanel, edges[p], edges[p + 1]);
    shear_.segment<kNodesPerPanel>(Eigen::Index(p) * kNodesPerPanel) = rule.nodes;
    weight_.segment<kNodesPerPanel>(Eigen::Index(p) * kNodesPerPanel) = kTwoPi * rule.nodes * rule.weights;
  }
}

// Even steps in the core, growing with the radius: q = unit sinh(v), midpoints in v.
void ScrambledLight::set_radii(double reach) {
  const double unit = 3 / scene_.diameter, last = std::asinh(reach / unit);
  radius_.resize(kRadii), ring_.resize(kRadii);
  bessel_.resize(kRadii, shear_.size());
  Eigen::ArrayXd z(shear_.size()), j0(shear_.size()), j1(shear_.size());
  for (int i = 0; i < kRadii; ++i) {
    const double v = last * (i + 0.5) / kRadii;
    radius_[i] = unit * std::sinh(v);
    ring_[i] = kTwoPi * radius_[i] * unit * std::cosh(v) * last / kRadii;
    z = kTwoPi * radius_[i] * shear_;
    bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
    bessel_.row(i) = j0.matrix().transpose();
  }
}

std::vector<ScrambledLight::Moved> ScrambledLight::moved(double f) const {
  std::vector<Moved> result;
  const double unit = 3 / scene_.diameter;
  const double per_step = kRadii / std::asinh(radius_[kRadii - 1] / unit) * (kRadii - 0.5) / kRadii;
  for (int i = 0; i < kRadii; ++i)
    for (int a = 0; a < kAngles; ++a) {
      const double cosine = std::cos(kPi * (a + 0.5) / kAngles);
      const double q = std::sqrt(radius_[i] * radius_[i] + f * f - 2 * radius_[i] * f * cosine);
      const double place = std::max(0.0, std::asinh(q / unit) * per_step - 0.5);
      const auto index = Eigen::Index(place);
      if (index + 1 < kRadii)
        result.push_back({index, place - double(index), q});
      else
        result.push_back({-1, 0, q});
    }
  return result;
}

double ScrambledLight::density(std::size_t j, const Eigen::VectorXd& unscattered,
                               const Eigen::VectorXd& scattered, const Eigen::VectorXd& landing,
                               double rim) const {
  const double core = core_[Eigen::Index(j)];
  // Probability of light that f moves to a point, and what there is at it.
  struct Moment {
    double change, unscattered, scattered;
  };
  std::array<Moment, kRadii * kAngles> moments;
  const Moved* point = moved_[j].data();
  double shift = 0;
  for (int i = 0; i < kRadii; ++i) {
    const double inside = landing[i] + (radius_[i] < rim ? core : 0);
    double mean = 0;
    for (int a = 0; a < kAngles; ++a, ++point) {
      Moment& moment = moments[std::size_t(i * kAngles + a)];
      moment = {inside, 0, 0};
      if (point->index >= 0) {
        const auto at = [&](const Eigen::VectorXd& values) {
          return values[point->index] + point->part * (values[point->index + 1] - values[point->index]);
        };
        moment = {inside - at(landing) - (point->radius < rim ? core : 0), at(unscattered), at(scattered)};
      }
      mean += moment.change;
    }
    shift += ring_[i] * (unscattered[i] + scattered[i]) * mean / kAngles;
  }
  shift = std::abs(shift);
  double sum = 0;
  for (int i = 0; i < kRadii; ++i) {
    double of_unscattered = 0, of_scattered = 0;
    for (int a = 0; a < kAngles; ++a) {
      const Moment& moment = moments[std::size_t(i * kAngles + a)];
      const double difference = std::abs(moment.change) - shift, square = difference * difference;
      of_unscattered += kHalf * moment.scattered * square;
      of_scattered += (kHalf * moment.unscattered + moment.scattered) * square;
    }
    sum += ring_[i] * (unscattered[i] * of_unscattered + scattered[i] * of_scattered) / kAngles;
  }
  return scene_.wave_number * scene_.wave_number / scene_.area * sum;
}

Eigen::ArrayXXd ScrambledLight::operator()(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& transfer,
                                           double pitch, double distance,
                                           const std::vector<double>& radius) const {
  Eigen::ArrayXd smooth(shear_.size());
  for (Eigen::Index i = 0; i < shear_.size(); ++i) {
    const double place = shear_[i] / pitch;
    const auto k = Eigen::Index(place);
    smooth[i] =
        k + 1 < transfer.size() ? transfer[k] + (place - double(k)) * (transfer[k + 1] - transfer[k]) : 0;
  }
  const double sharp = (smooth.square() * weight_).sum() / scene_.sharpness;
  const Eigen::VectorXd perfect =
      std::max(0.0, 1 - sharp) * (bessel_ * (smooth * weight_).matrix()).cwiseMax(0.0);
  const Eigen::MatrixXd scattered =
      (bessel_ * ((smooth * weight_).matrix().asDiagonal() * below_)).cwiseMax(0.0);
  Eigen::ArrayXXd result = Eigen::ArrayXXd::Zero(frequency.size(), Eigen::Index(radius.size()));
  Eigen::ArrayXd z(shear_.size()), j0(shear_.size()), j1(shear_.size());
  for (std::size_t d = 0; d < radius.size(); ++d) {
    const double rim = radius[d] / (scene_.wavelength * distance);
    z = kTwoPi * rim * shear_;
    bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
    const Eigen::ArrayXd disc = rim * j1 / shear_;  // transform of the disc
    const Eigen::MatrixXd landing = bessel_ * ((disc * weight_).matrix().asDiagonal() * above_);
    Eigen::ArrayXd known(kFrequencies);
    for (std::size_t j = 0; j < kFrequencies; ++j)
      known[Eigen::Index(j)] = density(j, core_below_[Eigen::Index(j)] * perfect,
                                       scattered.col(Eigen::Index(j)), landing.col(Eigen::Index(j)), rim);
    const double first = std::log(frequency_[0]), step = std::log(frequency_[1]) - first;
    for (Eigen::Index i = 0; i < frequency.size(); ++i) {
      const double place = std::max(0.0, (std::log(frequency[i]) - first) / step);
      const auto k = Eigen::Index(place);
      if (place > kFrequencies) continue;  // farther than light moves on the grid
      const Eigen::Index a = std::min<Eigen::Index>(k, kFrequencies - 1),
                         b = std::min(a + 1, Eigen::Index(kFrequencies) - 1);
      result(i, Eigen::Index(d)) = known[a] + (place - double(k)) * (known[b] - known[a]);
    }
  }
  return result;
}

}  // namespace aberfit::internal
