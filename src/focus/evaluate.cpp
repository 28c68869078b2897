#include "aberfit/focus/evaluate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "aberfit/core/parallel.h"
#include "kernel.h"
#include "line_spread.h"
#include "radial_distribution.h"
#include "ring_through.h"
#include "scatter_angle.h"

namespace aberfit {
namespace {

template <typename... F>
struct Overloaded : F... {
  using F::operator()...;
};

// Radial distributions of the planes that the statistics look at, built once each, in parallel.
class Planes {
 public:
  Planes(const FocusInput& input, const std::vector<Statistic>& statistics, int threads) {
    std::vector<double> wanted;
    for (const Statistic& statistic : statistics) {
      std::visit(Overloaded{[&](const EncircledEnergyRadius& s) { wanted.push_back(s.dz); },
                            [&](const RingFwhm& s) {
                              if (!s.ring_radius) wanted.push_back(0.0);
                            },
                            [&](const RingThrough& s) { wanted.push_back(s.dz); },
                            [&](const RmsRadius& s) { wanted.push_back(s.dz); }, [](const auto&) {}},
                 statistic);
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    std::vector<std::unique_ptr<RadialDistribution>> built(wanted.size());
    parallel_for(wanted.size(), threads, [&](std::size_t k) {
      built[k] =
          std::make_unique<RadialDistribution>(input.rays, wanted[k], input.centre == Centre::kCentroid);
    });
    for (std::size_t k = 0; k < wanted.size(); ++k) planes_.emplace(wanted[k], std::move(built[k]));
  }
  const RadialDistribution& at(double dz) const { return *planes_.at(dz); }

 private:
  std::map<double, std::unique_ptr<RadialDistribution>> planes_;
};

struct Point {
  double x = 0, y = 0;
};

// Centre of the ring of the ring-through profile: fixed through focus.
Point ring_centre(const FocusInput& input) {
  const double total = input.rays.weight.sum();
  if (input.centre == Centre::kNominal || !(total > 0)) return {};
  return {(input.rays.weight * input.rays.x).sum() / total, (input.rays.weight * input.rays.y).sum() / total};
}

struct HeightMoments {
  double mean, rms;
};

HeightMoments height_moments(const FocusInput& input) {
  const Eigen::ArrayXd& weight = input.rays.weight;
  const double total = weight.sum();
  const double mean = (weight * input.height).sum() / total;
  return {mean, std::sqrt((weight * (input.height - mean).square()).sum() / total)};
}

RayGradient all_rays(Eigen::Index n) {
  RayGradient gradient;
  gradient.rays.resize(std::size_t(n));
  for (std::size_t i = 0; i < gradient.rays.size(); ++i) gradient.rays[i] = std::uint32_t(i);
  gradient.d_x.assign(std::size_t(n), 0.0);
  gradient.d_y = gradient.d_tx = gradient.d_ty = gradient.d_x;
  return gradient;
}

void store(const Eigen::ArrayXd& values, double scale, std::vector<double>* out) {
  for (Eigen::Index i = 0; i < values.size(); ++i) (*out)[std::size_t(i)] = scale * values[i];
}

// Rays within this many rounding errors of their nominal ones carry no scatter: the derivative of every
// statistic is undefined there.
constexpr double kNoScatter = 1e-14;

double scatter_rms(const FocusInput& input) {
  const Eigen::ArrayXd angle = scatter_angles(input.rays, input.nominal);
  return std::sqrt((input.rays.weight * angle.square()).sum() / input.rays.weight.sum());
}

// One smooth statistic with its gradient; NaN when it does not exist.
class SmoothEvaluator {
 public:
  SmoothEvaluator(const FocusInput& input, const Planes& planes, double width, StatisticGradient* gradient)
      : in_(input), planes_(planes), width_(width), gradient_(gradient) {}

  double operator()(const EncircledEnergyRadius& s) const {
    const RadialDistribution& plane = planes_.at(s.dz);
    const auto radius = plane.smooth_radius(s.fraction, width_);
    if (!radius) return std::nan("");
    if (gradient_) plane.radius_gradient(*radius, width_, 1.0, &gradient_->rays);
    return *radius;
  }
  double operator()(const RingFwhm& s) const {
    double ring = s.ring_radius.value_or(0.0);
    if (!s.ring_radius) {
      const auto radius = planes_.at(0.0).smooth_radius(s.ring_fraction, width_);
      if (!radius) return std::nan("");
      ring = *radius;
    }
    const Point centre = ring_centre(in_);
    RayGradient* rays = gradient_ ? &gradient_->rays : nullptr;
    double d_ring = 0;
    const auto result =
        smooth_ring_width(in_.rays, ring, centre.x, centre.y, width_, rays, gradient_ ? &d_ring : nullptr);
    if (!result) return std::nan("");
    if (rays && in_.centre == Centre::kCentroid) follow_centroid(rays);
    if (rays && !s.ring_radius) planes_.at(0.0).radius_gradient(ring, width_, d_ring, rays);
    return result->fwhm;
  }
  double operator()(const RingThrough& s) const {
    const RadialDistribution& plane = planes_.at(s.dz);
    const double total = plane.total_weight();
    if (gradient_) plane.count_gradient(s.ring_radius, width_, 1.0 / total, &gradient_->rays);
    return plane.smooth_count(s.ring_radius, width_).weight / total;
  }
  double operator()(const ScatterRms&) const {
    const double rms = scatter_rms(in_);
    if (!(rms > kNoScatter)) return std::nan("");
    if (gradient_) {
      Eigen::ArrayXd d_tx, d_ty;
      squared_angle_gradient(in_.rays, in_.nominal, in_.rays.weight, &d_tx, &d_ty);
      spread(d_tx, d_ty, 1.0 / (rms * in_.rays.weight.sum()));
    }
    return rms;
  }
  double operator()(const ScatterMean&) const {
    const Eigen::ArrayXd angle = scatter_angles(in_.rays, in_.nominal);
    const double total = in_.rays.weight.sum(), mean = (in_.rays.weight * angle).sum() / total;
    if (!(mean > kNoScatter)) return std::nan("");
    if (gradient_) {
      const Eigen::ArrayXd weights = (angle > 0).select(in_.rays.weight / angle, 0.0);
      Eigen::ArrayXd d_tx, d_ty;
      squared_angle_gradient(in_.rays, in_.nominal, weights, &d_tx, &d_ty);
      spread(d_tx, d_ty, 1.0 / total);
    }
    return mean;
  }
  double operator()(const SpotFwhm& s) const {
    Eigen::ArrayXd d_x, d_y;
    const auto x = line_spread_fwhm(in_.rays.x, in_.rays.weight, s.bandwidth, gradient_ ? &d_x : nullptr);
    const auto y = line_spread_fwhm(in_.rays.y, in_.rays.weight, s.bandwidth, gradient_ ? &d_y : nullptr);
    if (!x || !y) return std::nan("");
    if (gradient_) {
      gradient_->rays = all_rays(in_.rays.size());
      store(d_x, 0.5, &gradient_->rays.d_x);
      store(d_y, 0.5, &gradient_->rays.d_y);
    }
    return 0.5 * (*x + *y);
  }
  double operator()(const RmsRadius& s) const {
    const RayBundle& rays = in_.rays;
    const double total = rays.weight.sum();
    Eigen::ArrayXd x = rays.x + s.dz * rays.tx, y = rays.y + s.dz * rays.ty;
    if (in_.centre == Centre::kCentroid) {
      x -= (rays.weight * x).sum() / total;
      y -= (rays.weight * y).sum() / total;
    }
    const double rms = std::sqrt((rays.weight * (x.square() + y.square())).sum() / total);
    if (!(rms > 0)) return std::nan("");
    if (gradient_) {  // the centroid drops out: first moments about it vanish
      gradient_->rays = all_rays(rays.size());
      const double unit = 1.0 / (total * rms);
      store(rays.weight * x, unit, &gradient_->rays.d_x);
      store(rays.weight * y, unit, &gradient_->rays.d_y);
      store(rays.weight * x, unit * s.dz, &gradient_->rays.d_tx);
      store(rays.weight * y, unit * s.dz, &gradient_->rays.d_ty);
    }
    return rms;
  }
  double operator()(const RmsHeight&) const {
    const HeightMoments moments = height_moments(in_);
    if (!(moments.rms > 0)) return std::nan("");
    if (gradient_)
      gradient_->d_height =
          in_.rays.weight * (in_.height - moments.mean) / (moments.rms * in_.rays.weight.sum());
    return moments.rms;
  }

 private:
  void spread(const Eigen::ArrayXd& d_tx, const Eigen::ArrayXd& d_ty, double scale) const {
    gradient_->rays = all_rays(in_.rays.size());
    store(d_tx, scale, &gradient_->rays.d_tx);
    store(d_ty, scale, &gradient_->rays.d_ty);
  }
  // The ring's centre is the centroid of z = f and moves with every ray.
  void follow_centroid(RayGradient* gradient) const {
    double d_x = 0, d_y = 0;
    for (const double d : gradient->d_x) d_x -= d;
    for (const double d : gradient->d_y) d_y -= d;
    const double total = in_.rays.weight.sum();
    for (Eigen::Index i = 0; i < in_.rays.size(); ++i) {
      const double share = in_.rays.weight[i] / total;
      if (share == 0.0) continue;
      gradient->rays.push_back(std::uint32_t(i));
      gradient->d_x.push_back(share * d_x);
      gradient->d_y.push_back(share * d_y);
      gradient->d_tx.push_back(0.0);
      gradient->d_ty.push_back(0.0);
    }
  }

  const FocusInput& in_;
  const Planes& planes_;
  double width_;
  StatisticGradient* gradient_;
};

// One exact statistic; NaN when it does not exist.
class ExactEvaluator {
 public:
  ExactEvaluator(const FocusInput& input, const Planes& planes, Warning* warning)
      : in_(input), planes_(planes), warning_(warning) {}

  double operator()(const EncircledEnergyRadius& s) const {
    return planes_.at(s.dz).exact_radius(s.fraction);
  }
  double operator()(const RingFwhm& s) const {
    const double ring = s.ring_radius ? *s.ring_radius : planes_.at(0.0).exact_radius(s.ring_fraction);
    const Point centre = ring_centre(in_);
    const auto result = exact_ring_width(in_.rays, ring, centre.x, centre.y);
    if (!result) {
      *warning_ = {
          "ring-fwhm-missing",
          "the share of light inside the ring does not fall to half its maximum on both sides of focus"};
      return std::nan("");
    }
    if (result->crossings > 2)
      *warning_ = {"ring-fwhm-crossings", "the ring-through profile crosses half its maximum " +
                                              std::to_string(result->crossings) +
                                              " times; the width is that of the main peak"};
    return result->fwhm;
  }
  double operator()(const RingThrough& s) const {
    const RayBundle& rays = in_.rays;
    const Point centre = plane_centre(s.dz);
    const Eigen::ArrayXd x = rays.x + s.dz * rays.tx - centre.x, y = rays.y + s.dz * rays.ty - centre.y;
    const double ring2 = s.ring_radius * s.ring_radius;
    return (x.square() + y.square() <= ring2).select(rays.weight, 0.0).sum() / rays.weight.sum();
  }
  double operator()(const ScatterRms&) const { return scatter_rms(in_); }
  double operator()(const ScatterMean&) const {
    return (in_.rays.weight * scatter_angles(in_.rays, in_.nominal)).sum() / in_.rays.weight.sum();
  }
  double operator()(const SpotFwhm& s) const {
    const auto x = line_spread_fwhm(in_.rays.x, in_.rays.weight, s.bandwidth, nullptr);
    const auto y = line_spread_fwhm(in_.rays.y, in_.rays.weight, s.bandwidth, nullptr);
    if (!x || !y) return std::nan("");
    return 0.5 * (*x + *y);
  }
  double operator()(const RmsRadius& s) const { return planes_.at(s.dz).rms(); }
  double operator()(const RmsHeight&) const { return height_moments(in_).rms; }

 private:
  Point plane_centre(double dz) const {
    if (in_.centre == Centre::kNominal) return {};
    const RayBundle& rays = in_.rays;
    const double total = rays.weight.sum();
    return {(rays.weight * (rays.x + dz * rays.tx)).sum() / total,
            (rays.weight * (rays.y + dz * rays.ty)).sum() / total};
  }

  const FocusInput& in_;
  const Planes& planes_;
  Warning* warning_;
};

}  // namespace

Eigen::VectorXd evaluate_exact(const FocusInput& input, const std::vector<Statistic>& statistics, int threads,
                               Warnings* warnings) {
  Eigen::VectorXd values = Eigen::VectorXd::Constant(Eigen::Index(statistics.size()), std::nan(""));
  if (!(input.rays.weight.sum() > 0)) {
    if (warnings) warnings->push_back({"no-light", "every ray is lost: no focal statistic exists"});
    return values;
  }
  const Planes planes(input, statistics, threads);
  std::vector<Warning> found(statistics.size());
  parallel_for(statistics.size(), threads, [&](std::size_t k) {
    values[Eigen::Index(k)] = std::visit(ExactEvaluator(input, planes, &found[k]), statistics[k]);
  });
  for (std::size_t k = 0; warnings && k < found.size(); ++k) {
    if (found[k].code.empty()) continue;
    found[k].message = statistic_name(statistics[k]) + ": " + found[k].message;
    warnings->push_back(found[k]);
  }
  return values;
}

bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, Eigen::VectorXd* values, std::vector<StatisticGradient>* gradients) {
  values->setConstant(Eigen::Index(statistics.size()), std::nan(""));
  if (gradients) gradients->assign(statistics.size(), {});
  if (!(input.rays.weight.sum() > 0) || !(width > 0)) return false;
  const Planes planes(input, statistics, threads);
  parallel_for(statistics.size(), threads, [&](std::size_t k) {
    const SmoothEvaluator evaluate(input, planes, width, gradients ? &(*gradients)[k] : nullptr);
    (*values)[Eigen::Index(k)] = std::visit(evaluate, statistics[k]);
  });
  return values->allFinite();
}

struct FocusWorkspace::Buffers {};
FocusWorkspace::FocusWorkspace() : buffers_(std::make_unique<Buffers>()) {}
FocusWorkspace::~FocusWorkspace() = default;
FocusWorkspace::FocusWorkspace(FocusWorkspace&&) noexcept = default;
FocusWorkspace& FocusWorkspace::operator=(FocusWorkspace&&) noexcept = default;

bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, FocusWorkspace* /*workspace*/, Eigen::VectorXd* values,
                     std::vector<StatisticGradient>* gradients) {
  return evaluate_smooth(input, statistics, width, threads, values, gradients);
}

}  // namespace aberfit
