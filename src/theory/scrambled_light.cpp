#include "scrambled_light.h"

#include <algorithm>
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
constexpr double kHalf = 0.5;                 // factor of I_c I_h, see the header
constexpr double kReach = 2.5, kBeyond = 10;  // radii of the largest disc, cycles across the aperture

}  // namespace

ScrambledLight::ScrambledLight(const RadialPsd& psd, const Scene& scene, const ApertureOtf& perfect,
                               double low, double high)
    : scene_(scene) {
  const double reach =
      std::min(kReach * scene.largest + kBeyond / scene.diameter, kMostCycles / scene.diameter);
  const double top = std::min(high, 2 * reach);  // larger frequencies move energy off the grid
  for (int j = 0; j < kFrequencies; ++j)
    frequency_.push_back(low * std::pow(top / low, (j + 0.5) / kFrequencies));
  set_shears(reach);
  set_radii(reach);
  focal_ = shear_.unaryExpr([&](double x) { return perfect(x); });
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

// Panels of one width, the first halved towards 0: the transfer function of a rough surface is narrow.
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

// Even steps in the core that grow with the radius: q = unit sinh(v), midpoints in v.
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

Eigen::ArrayXd ScrambledLight::smooth(const Eigen::ArrayXd& transfer, double pitch) const {
  Eigen::ArrayXd result(shear_.size());
  for (Eigen::Index i = 0; i < shear_.size(); ++i) {
    const double place = shear_[i] / pitch;
    const auto k = Eigen::Index(place);
    result[i] =
        k + 1 < transfer.size() ? transfer[k] + (place - double(k)) * (transfer[k + 1] - transfer[k]) : 0;
  }
  return result;
}

ScrambledLight::Light ScrambledLight::light(const Eigen::ArrayXd& transfer, double pitch) const {
  const Eigen::ArrayXd smooth = this->smooth(transfer, pitch);
  const double sharp = (smooth.square() * weight_).sum() / (focal_.square() * weight_).sum();
  return {std::max(0.0, 1 - sharp) * (bessel_ * (smooth * weight_).matrix()).cwiseMax(0.0),
          (bessel_ * ((smooth * weight_).matrix().asDiagonal() * below_)).cwiseMax(0.0), patches(smooth)};
}

Eigen::ArrayXd ScrambledLight::patches(const Eigen::ArrayXd& smooth) const {
  Eigen::ArrayXd result(kFrequencies);
  Eigen::ArrayXd z(shear_.size()), j0(shear_.size()), j1(shear_.size());
  for (int j = 0; j < kFrequencies; ++j) {
    z = kTwoPi * frequency_[std::size_t(j)] * shear_;
    bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
    const Eigen::ArrayXd own = below_.col(j).array().square() * weight_ * j0;
    const double local = (own * focal_.square()).sum(), all = (own * smooth.square()).sum();
    const double whole = (below_.col(j).array().square() * weight_ * smooth.square()).sum();
    result[j] = all > 1e-6 * whole ? std::max(0.0, local) / all : 1;
  }
  return result;
}

Eigen::MatrixXd ScrambledLight::landing(double rim) const {
  Eigen::ArrayXd z = kTwoPi * rim * shear_, j0(shear_.size()), j1(shear_.size());
  bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
  const Eigen::ArrayXd disc = rim * j1 / shear_;  // transform of the disc
  return bessel_ * ((disc * weight_).matrix().asDiagonal() * above_);
}

// Value on the grid of radii at a point that f moves energy from.
double ScrambledLight::at(const Moved& point, const Eigen::Ref<const Eigen::VectorXd>& values) {
  if (point.index < 0) return 0;
  return values[point.index] + point.part * (values[point.index + 1] - values[point.index]);
}

Eigen::ArrayXd ScrambledLight::pairs(std::size_t j, const Light& light) const {
  const auto column = Eigen::Index(j);
  const double below = core_below_[column], scale = scene_.wave_number * scene_.wave_number / scene_.area;
  const auto scattered = light.scattered.col(column);
  Eigen::ArrayXd result(kRadii * kAngles);
  const Moved* point = moved_[j].data();
  for (int i = 0; i < kRadii; ++i)
    for (int a = 0; a < kAngles; ++a, ++point) {
      const double there = at(*point, scattered);
      result[i * kAngles + a] =
          scale * ring_[i] / kAngles *
          (below * light.perfect[i] * kHalf * there +
           scattered[i] * (kHalf * below * at(*point, light.perfect) + light.patch[column] * there));
    }
  return result;
}

Eigen::ArrayXd ScrambledLight::differences(std::size_t j, const Light& light,
                                           const Eigen::Ref<const Eigen::VectorXd>& landing,
                                           double rim) const {
  const auto column = Eigen::Index(j);
  const double core = core_[column];
  Eigen::ArrayXd result(kRadii * kAngles);
  const Moved* point = moved_[j].data();
  double shift = 0;
  for (int i = 0; i < kRadii; ++i) {
    const double inside = landing[i] + (radius_[i] < rim ? core : 0);
    double mean = 0;
    for (int a = 0; a < kAngles; ++a, ++point) {
      const double change =
          point->index < 0 ? inside : inside - at(*point, landing) - (point->radius < rim ? core : 0);
      result[i * kAngles + a] = std::abs(change);
      mean += change;
    }
    shift +=
        ring_[i] * (core_below_[column] * light.perfect[i] + light.scattered(i, column)) * mean / kAngles;
  }
  return result - std::abs(shift);
}

std::optional<ScrambledLight::Among> ScrambledLight::among(double frequency) const {
  const double first = std::log(frequency_[0]), step = std::log(frequency_[1]) - first;
  const double place = std::max(0.0, (std::log(frequency) - first) / step);
  if (place > kFrequencies) return std::nullopt;  // moves energy off the grid
  const auto k = Eigen::Index(place);
  const Eigen::Index low = std::min<Eigen::Index>(k, kFrequencies - 1);
  return Among{low, std::min(low + 1, Eigen::Index(kFrequencies) - 1), place - double(k)};
}

Eigen::ArrayXXd ScrambledLight::operator()(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& transfer,
                                           double pitch, double distance,
                                           const std::vector<double>& radius) const {
  const Light light = this->light(transfer, pitch);
  Eigen::ArrayXXd known = Eigen::ArrayXXd::Zero(kFrequencies, Eigen::Index(radius.size()));
  Eigen::ArrayXXd result = Eigen::ArrayXXd::Zero(frequency.size(), Eigen::Index(radius.size()));
  std::vector<Eigen::ArrayXd> pairs;
  for (std::size_t j = 0; j < kFrequencies; ++j) pairs.push_back(this->pairs(j, light));
  for (std::size_t d = 0; d < radius.size(); ++d) {
    const double rim = radius[d] / (scene_.wavelength * distance);
    const Eigen::MatrixXd landing = this->landing(rim);
    for (std::size_t j = 0; j < kFrequencies; ++j)
      known(Eigen::Index(j), Eigen::Index(d)) =
          (pairs[j] * differences(j, light, landing.col(Eigen::Index(j)), rim).square()).sum();
  }
  for (Eigen::Index i = 0; i < frequency.size(); ++i)
    if (const std::optional<Among> place = among(frequency[i]))
      result.row(i) = known.row(place->low) + place->part * (known.row(place->high) - known.row(place->low));
  return result;
}

Eigen::MatrixXd ScrambledLight::covariance(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& weight,
                                           const Eigen::ArrayXd& transfer, double pitch, double distance,
                                           const std::vector<double>& radius) const {
  const Light light = this->light(transfer, pitch);
  const auto discs = Eigen::Index(radius.size());
  Eigen::ArrayXd of_known = Eigen::ArrayXd::Zero(kFrequencies);
  for (Eigen::Index i = 0; i < frequency.size(); ++i)
    if (const std::optional<Among> place = among(frequency[i])) {
      of_known[place->low] += (1 - place->part) * weight[i];
      of_known[place->high] += place->part * weight[i];
    }
  std::vector<Eigen::MatrixXd> landings;
  std::vector<double> rims;
  for (const double r : radius) {
    rims.push_back(r / (scene_.wavelength * distance));
    landings.push_back(landing(rims.back()));
  }
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(discs, discs), of_discs(kRadii * kAngles, discs);
  for (std::size_t j = 0; j < kFrequencies; ++j) {
    for (Eigen::Index d = 0; d < discs; ++d)
      of_discs.col(d) =
          differences(j, light, landings[std::size_t(d)].col(Eigen::Index(j)), rims[std::size_t(d)]);
    const Eigen::VectorXd pairs = of_known[Eigen::Index(j)] * this->pairs(j, light);
    result += of_discs.transpose() * pairs.asDiagonal() * of_discs;
  }
  return result;
}

}  // namespace aberfit::internal
