#include "aberfit/focus/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "encircled_radii.h"
#include "kernel.h"
#include "line_spread.h"
#include "ray_blocks.h"
#include "ring_through.h"
#include "scatter_angle.h"

namespace aberfit {
using namespace internal;

struct FocusWorkspace::Buffers {
  std::vector<RadiusRequest> requests;
  std::vector<std::size_t> request_of;  // per statistic; its own index if it needs no radius
  RadiusBuffers radii;
  std::vector<RingBuffers> rings;           // per statistic, for ring widths
  std::vector<RayGradient> ring_gradients;  // gradients of the ring radii, per statistic
};

namespace {

// If all rays agree with their nominal rays within this many rounding errors, there is no scatter. Then the
// derivative of every statistic is undefined.
constexpr double kNoScatter = 1e-14;

struct Point {
  double x = 0, y = 0;
};

// Weighted sum of squared distances from `centre` at plane dz [m^2]; next, `scale` times half its gradient.
double second_moment(const RayBundle& rays, double dz, Point centre) {
  return (rays.weight *
          ((rays.x + dz * rays.tx - centre.x).square() + (rays.y + dz * rays.ty - centre.y).square()))
      .sum();
}

void second_moment_gradient(const RayBundle& rays, double dz, Point centre, double scale,
                            RayGradient* gradient) {
  gradient->dz = dz;
  gradient->all_rays = true;
  gradient->d_x.resize(std::size_t(rays.size()));
  gradient->d_y.resize(std::size_t(rays.size()));
  Eigen::Map<Eigen::ArrayXd>(gradient->d_x.data(), rays.size()) =
      scale * rays.weight * (rays.x + dz * rays.tx - centre.x);
  Eigen::Map<Eigen::ArrayXd>(gradient->d_y.data(), rays.size()) =
      scale * rays.weight * (rays.y + dz * rays.ty - centre.y);
}

struct HeightMoments {
  double mean, rms;
};
HeightMoments height_moments(const Eigen::ArrayXd& weight, const Eigen::ArrayXd& height) {
  const double total = weight.sum(), mean = (weight * height).sum() / total;
  return {mean, std::sqrt((weight * (height - mean).square()).sum() / total)};
}

struct Shared {
  const FocusInput& input;
  RaySums sums;
  AngleSums angles;  // only when a statistic needs them
  double width = 0;  // 0: exact
  int threads = 1;
  FocusWorkspace::Buffers& buffers;

  bool about_centroid() const { return input.centre == Centre::kCentroid; }
  Point centre(double dz) const {
    if (!about_centroid()) return {};
    return {(sums.x + dz * sums.tx) / sums.weight, (sums.y + dz * sums.ty) / sums.weight};
  }
  double radius_of(std::size_t k) const { return buffers.requests[buffers.request_of[k]].radius; }
  double share_of(std::size_t k) const { return buffers.requests[buffers.request_of[k]].fraction; }
  Ring ring_of(std::size_t k, const RingFwhm& s) const {
    const Point middle = centre(0.0);  // the same centre for all planes
    return {s.ring_radius ? *s.ring_radius : radius_of(k), middle.x, middle.y};
  }
};

// Computes the radii of all planes, and the sums that several statistics share.
void prepare(const std::vector<Statistic>& statistics, std::vector<StatisticGradient>* gradients,
             Shared* shared) {
  FocusWorkspace::Buffers& b = shared->buffers;
  const std::size_t count = statistics.size();
  b.requests.clear();
  b.request_of.assign(count, 0);
  if (b.rings.size() < count) b.rings.resize(count);
  if (b.ring_gradients.size() < count) b.ring_gradients.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    b.request_of[k] = b.requests.size();
    if (const auto* radius = std::get_if<EncircledEnergyRadius>(&statistics[k])) {
      b.requests.push_back({radius->dz, radius->fraction, gradients ? &(*gradients)[k].rays : nullptr});
    } else if (const auto* ring = std::get_if<RingFwhm>(&statistics[k]); ring && !ring->ring_radius) {
      b.ring_gradients[k].clear();
      b.requests.push_back({0.0, ring->ring_fraction, gradients ? &b.ring_gradients[k] : nullptr});
    } else if (const auto* share = std::get_if<RingThrough>(&statistics[k])) {
      b.requests.push_back(
          {share->dz, std::nan(""), gradients ? &(*gradients)[k].rays : nullptr, share->ring_radius, true});
    }
  }
  encircled_radii(shared->input.rays, shared->sums, shared->about_centroid(), shared->width, shared->threads,
                  &b.radii, &b.requests);
  const auto of_angles = [](const Statistic& s) { return kind_of(s).dimension == Dimension::kAngle; };
  if (std::any_of(statistics.begin(), statistics.end(), of_angles))
    shared->angles = sum_angles(shared->input.rays, shared->input.nominal, shared->threads);
}

// Threads divide each large bundle of rays; with a small bundle, each statistic has one thread.
void for_each_statistic(const std::vector<Statistic>& statistics, Shared* shared,
                        const std::function<void(std::size_t)>& evaluate) {
  const int threads = shared->threads;
  if (RayGroups(shared->input.rays.size()).count >= 4) {
    for (std::size_t k = 0; k < statistics.size(); ++k) evaluate(k);
  } else {
    // A statistic that only reads a stored value needs no thread.
    std::vector<std::size_t> heavy;
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      if (std::holds_alternative<EncircledEnergyRadius>(statistics[k]) ||
          std::holds_alternative<RingThrough>(statistics[k]))
        evaluate(k);
      else
        heavy.push_back(k);
    }
    parallel_for(heavy.size(), threads, [&](std::size_t j) { evaluate(heavy[j]); });
  }
}

// Adds `scale` times the gradient of a radius at dz = 0 to the gradient of a ring width.
void add_ring_radius(const RayGradient& radius, double scale, RayGradient* gradient) {
  if (radius.all_rays) {
    for (std::size_t i = 0; i < radius.d_x.size(); ++i) gradient->d_x[i] += scale * radius.d_x[i];
    for (std::size_t i = 0; i < radius.d_y.size(); ++i) gradient->d_y[i] += scale * radius.d_y[i];
    return;
  }
  for (std::size_t i = 0; i < radius.rays.size(); ++i) {
    gradient->rays.push_back(radius.rays[i]);
    gradient->d_x.push_back(scale * radius.d_x[i]);
    gradient->d_y.push_back(scale * radius.d_y[i]);
    gradient->d_tx.push_back(0.0);
    gradient->d_ty.push_back(0.0);
  }
  // Spare room, because the next evaluation may have a few more entries.
  const std::size_t size = gradient->rays.size(), spare = size + size / 8;
  gradient->rays.reserve(spare);
  for (std::vector<double>* d : {&gradient->d_x, &gradient->d_y, &gradient->d_tx, &gradient->d_ty})
    d->reserve(spare);
}

// Evaluates one statistic, exact where the width of `shared` is 0, else smooth; NaN when it does not exist.
// The derivative of a smooth one must exist, too.
class Evaluator {
 public:
  Evaluator(const Shared& shared, std::size_t index, StatisticGradient* gradient, Warning* warning)
      : shared_(shared), in_(shared.input), index_(index), gradient_(gradient), warning_(warning) {}

  double operator()(const EncircledEnergyRadius&) const { return shared_.radius_of(index_); }
  double operator()(const RingFwhm& s) const { return exact() ? exact_ring(s) : smooth_ring(s); }
  double operator()(const RingThrough&) const { return shared_.share_of(index_); }
  double operator()(const ScatterRms&) const {
    const double total = shared_.sums.weight, rms = std::sqrt(shared_.angles.squares / total);
    if (!exact() && !(rms > kNoScatter)) return std::nan("");
    if (gradient_) spread_angles(1.0 / (rms * total), false);
    return rms;
  }
  double operator()(const ScatterMean&) const {
    const double total = shared_.sums.weight, mean = shared_.angles.firsts / total;
    if (!exact() && !(mean > kNoScatter)) return std::nan("");
    if (gradient_) spread_angles(1.0 / total, true);
    return mean;
  }
  double operator()(const SpotFwhm& s) const {
    RayGradient* rays = gradient_ ? &gradient_->rays : nullptr;
    const double factor = exact() ? 1.0 : 0.5;
    const auto x =
        line_spread_fwhm(in_.rays.x, in_.rays.weight, s.bandwidth, factor, rays ? &rays->d_x : nullptr);
    const auto y =
        line_spread_fwhm(in_.rays.y, in_.rays.weight, s.bandwidth, factor, rays ? &rays->d_y : nullptr);
    if (!x || !y) {
      if (exact() && s.bandwidth > 0) warn_of_bandwidth(s.bandwidth);
      return std::nan("");
    }
    if (rays) rays->all_rays = true;
    return 0.5 * (*x + *y);
  }
  double operator()(const RmsRadius& s) const {
    const Point centre = shared_.centre(s.dz);
    const double total = shared_.sums.weight, rms = std::sqrt(second_moment(in_.rays, s.dz, centre) / total);
    if (!exact() && !(rms > 0)) return std::nan("");
    // The centroid does not contribute, because first moments about it vanish.
    if (gradient_) second_moment_gradient(in_.rays, s.dz, centre, 1.0 / (total * rms), &gradient_->rays);
    return rms;
  }
  double operator()(const RmsHeight&) const {
    const HeightMoments moments = height_moments(in_.rays.weight, in_.height);
    const double rms = std::hypot(moments.rms, in_.unseen_height);
    if (!exact() && !(rms > 0)) return std::nan("");
    if (gradient_)
      gradient_->d_height =
          in_.rays.weight * (in_.height - moments.mean) * (1.0 / (rms * shared_.sums.weight));
    return rms;
  }
  double operator()(const WaveKind auto&) const { return std::nan(""); }

 private:
  bool exact() const { return shared_.width == 0; }
  double exact_ring(const RingFwhm& s) const {
    const auto result = exact_ring_width(in_.rays, shared_.sums, shared_.ring_of(index_, s), shared_.threads,
                                         &shared_.buffers.rings[index_]);
    if (!result) {
      *warning_ = {"ring-fwhm-missing",
                   "the energy inside the ring does not fall to half its maximum on both sides of focus"};
      return std::nan("");
    }
    if (result->crossings > 2)
      *warning_ = {"ring-fwhm-crossings", "the energy through the ring crosses half its maximum " +
                                              std::to_string(result->crossings) +
                                              " times; the width is that of the main peak"};
    return result->fwhm;
  }
  double smooth_ring(const RingFwhm& s) const {
    const Ring ring = shared_.ring_of(index_, s);
    RayGradient* rays = gradient_ ? &gradient_->rays : nullptr;
    double d_ring = 0;
    const auto result = smooth_ring_width(in_.rays, shared_.sums, ring, shared_.width, shared_.threads,
                                          &shared_.buffers.rings[index_], shared_.about_centroid(), rays,
                                          gradient_ ? &d_ring : nullptr);
    if (!result) return std::nan("");
    // The centre of the ring is the centroid at z = f, which depends on every ray.
    if (rays && shared_.about_centroid()) follow_centroid(in_.rays, shared_.sums.weight, rays);
    if (rays && !s.ring_radius) add_ring_radius(shared_.buffers.ring_gradients[index_], d_ring, rays);
    return result->fwhm;
  }
  void warn_of_bandwidth(double bandwidth) const {
    const double spread = operator()(RmsRadius{0});
    *warning_ = {"spot-fwhm-missing",
                 fmt::format("the `bandwidth` of spot_fwhm is {}, narrower than 1/{} of the spot's RMS "
                             "radius {}, so single rays appear as peaks; {} is wide enough",
                             format_quantity(bandwidth, Dimension::kLength), kNarrowestLine,
                             format_quantity(spread, Dimension::kLength),
                             format_quantity(spread / kNarrowestLine, Dimension::kLength))};
  }
  void spread_angles(double scale, bool mean) const {
    gradient_->rays.all_rays = true;
    angle_gradient(in_.rays, in_.nominal, scale, mean, shared_.threads, &gradient_->rays.d_tx,
                   &gradient_->rays.d_ty);
  }

  const Shared& shared_;
  const FocusInput& in_;
  std::size_t index_;
  StatisticGradient* gradient_;  // null for exact ones
  Warning* warning_;             // null for smooth ones
};

}  // namespace

Eigen::VectorXd evaluate_exact(const FocusInput& input, const std::vector<Statistic>& statistics, int threads,
                               Warnings* warnings) {
  Eigen::VectorXd values = Eigen::VectorXd::Constant(Eigen::Index(statistics.size()), std::nan(""));
  FocusWorkspace workspace;
  Shared shared{input, sum_rays(input.rays, threads), {}, 0.0, threads, workspace.buffers()};
  if (!(shared.sums.weight > 0)) {
    if (warnings) warnings->push_back({"no-light", "every ray is lost, so no focal statistic exists"});
    return values;
  }
  prepare(statistics, nullptr, &shared);
  std::vector<Warning> found(statistics.size());
  for_each_statistic(statistics, &shared, [&](std::size_t k) {
    values[Eigen::Index(k)] = std::visit(Evaluator(shared, k, nullptr, &found[k]), statistics[k]);
  });
  for (std::size_t k = 0; warnings && k < found.size(); ++k) {
    if (found[k].code.empty()) continue;
    found[k].message = statistic_name(statistics[k]) + ": " + found[k].message;
    warnings->push_back(found[k]);
  }
  return values;
}

bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, FocusWorkspace* workspace, Eigen::VectorXd* values,
                     std::vector<StatisticGradient>* gradients) {
  values->setConstant(Eigen::Index(statistics.size()), std::nan(""));
  if (gradients) {
    gradients->resize(statistics.size());
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      (*gradients)[k].rays.clear();
      if (!std::holds_alternative<RmsHeight>(statistics[k])) (*gradients)[k].d_height.resize(0);
    }
  }
  Shared shared{input, sum_rays(input.rays, threads), {}, width, threads, workspace->buffers()};
  if (!(shared.sums.weight > 0) || !(width > 0)) return false;
  prepare(statistics, gradients, &shared);
  for_each_statistic(statistics, &shared, [&](std::size_t k) {
    const Evaluator evaluate(shared, k, gradients ? &(*gradients)[k] : nullptr, nullptr);
    (*values)[Eigen::Index(k)] = std::visit(evaluate, statistics[k]);
  });
  return values->allFinite();
}

bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, Eigen::VectorXd* values, std::vector<StatisticGradient>* gradients) {
  FocusWorkspace workspace;
  return evaluate_smooth(input, statistics, width, threads, &workspace, values, gradients);
}

FocusWorkspace::FocusWorkspace() : buffers_(std::make_unique<Buffers>()) {}
FocusWorkspace::~FocusWorkspace() = default;
FocusWorkspace::FocusWorkspace(FocusWorkspace&&) noexcept = default;
FocusWorkspace& FocusWorkspace::operator=(FocusWorkspace&&) noexcept = default;

}  // namespace aberfit
