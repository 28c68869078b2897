#include "ray_forward.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/theory/scattered_rays.h"
#include "aberfit/trace/nominal_surface.h"

namespace aberfit::internal {

std::optional<Warning> undersampled(const TermSet& terms, double pitch) {
  double highest = 0;  // [cycles/m]
  for (const FourierMode& mode : terms.fourier)
    highest = std::max({highest, std::abs(mode.fx), std::abs(mode.fy)});
  for (const ZernikeMode& mode : terms.zernike)
    highest = std::max(highest, zernike_cutoff(mode.n, terms.radius));
  constexpr double kRounding = 1e-9;  // relative, for a pitch from a difference of positions
  if (2 * highest * pitch < 1 - kRounding) return std::nullopt;
  return Warning{"terms-undersampled",
                 fmt::format("terms of up to {} have at most two points per cycle on points {} apart, so "
                             "energy lands in the wrong place; take points {} apart or less, or fewer terms",
                             format_quantity(highest, Dimension::kSpatialFrequency),
                             format_quantity(pitch, Dimension::kLength),
                             format_quantity(1 / (3 * highest), Dimension::kLength))};
}

RayForward::RayForward(const LightPath& path, std::vector<Statistic> statistics, int threads)
    : path_(path),
      statistics_(std::move(statistics)),
      threads_(threads),
      nominal_(trace_nominal(path.mirror, path.pupil, threads)),
      of_revolution_(without_known_zernikes(path.mirror)),
      known_(known_zernike_field(path.mirror, path.pupil, {threads, {}, {}})) {
  if (path.scatter) add_scatter(*path.scatter, path.pupil, kScatterSeed, &known_);
  // Scatter angles need directions only; the rest is an eighth of the memory of a fit.
  for (Eigen::ArrayXd* unread : {&nominal_.x, &nominal_.y, &nominal_.weight}) unread->resize(0);
}

void RayForward::move_to(const Eigen::VectorXd& coefficients) {
  path_.surface.apply(coefficients, &field_);
  if (known_.size() > 0) {
    whole_.height = field_.height + known_.height;
    whole_.slope_x = field_.slope_x + known_.slope_x;
    whole_.slope_y = field_.slope_y + known_.slope_y;
  }
  trace(of_revolution_, path_.pupil, whole_field(), threads_, &rays_);
}

FocusInput RayForward::input() const {
  return {rays_, nominal_, field_.height, path_.centre, path_.scatter ? path_.scatter->rms_height() : 0};
}

// Gradients over the rays are computed with the values: nearly every point of a solver is accepted, and they
// then cost a fraction of a second pass. A focal spot of up to thirty rounding errors of the ray positions
// has no usable size: its values would be right to 1e-3 or worse (tests/stability/focus_edge_test.cpp).
bool RayForward::evaluate(double width, Eigen::VectorXd* values) {
  constexpr double kFew = 30 * std::numeric_limits<double>::epsilon();
  const double place = (path_.pupil.x.square() + path_.pupil.y.square()).maxCoeff();
  const auto in_focus = [](const Statistic& statistic) {
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) return ee->dz == 0;
    if (const auto* ring = std::get_if<RingFwhm>(&statistic)) return !ring->ring_radius;
    const auto* radius = std::get_if<RmsRadius>(&statistic);
    return radius && radius->dz == 0;
  };
  if (std::any_of(statistics_.begin(), statistics_.end(), in_focus) &&
      (rays_.weight * (rays_.x.square() + rays_.y.square())).sum() < kFew * kFew * place) {
    values->setConstant(Eigen::Index(statistics_.size()), std::nan(""));
    return false;
  }
  return evaluate_smooth(input(), statistics_, width, threads_, &workspace_, values, &gradients_);
}

bool RayForward::gradients(const GradientSink& sink) {
  std::vector<const RayGradient*> over_rays(gradients_.size(), nullptr);
  for (std::size_t k = 0; k < gradients_.size(); ++k) {
    Eigen::ArrayXd& d_height = gradients_[k].d_height;
    if (d_height.size() == 0) {
      over_rays[k] = &gradients_[k].rays;
      continue;
    }
    if (height_weights_.slope_x.size() != d_height.size()) {  // the height is swapped in only for use
      height_weights_.slope_x.setZero(d_height.size());
      height_weights_.slope_y.setZero(d_height.size());
    }
    height_weights_.height.swap(d_height);
    sink(k, path_.surface.apply_transpose(height_weights_));
    height_weights_.height.swap(d_height);
  }
  pull_back(over_rays, sink);
  return true;
}

void RayForward::pull_back(const std::vector<const RayGradient*>& gradients, const GradientSink& sink) const {
  // The most expensive rows come first, so that no thread is left with one at the end. If they are fewer than
  // the threads, they run one by one, and the operator divides their points among the threads.
  std::vector<std::size_t> sparse, dense;
  for (std::size_t k = 0; k < gradients.size(); ++k)
    if (gradients[k]) (gradients[k]->all_rays ? dense : sparse).push_back(k);
  const auto pull = [&](std::size_t k) {
    const RayGradient& rays = *gradients[k];
    const SurfaceField weights = trace_adjoint(of_revolution_, path_.pupil, whole_field(), rays);
    sink(k, rays.all_rays ? path_.surface.apply_transpose(weights)
                          : path_.surface.apply_transpose(rays.rays, weights));
  };
  if (dense.size() < std::size_t(std::max(threads_, 1))) {
    for (const std::size_t k : dense) pull(k);
    dense.clear();
  }
  std::stable_sort(sparse.begin(), sparse.end(), [&](std::size_t a, std::size_t b) {
    return gradients[a]->rays.size() > gradients[b]->rays.size();
  });
  dense.insert(dense.end(), sparse.begin(), sparse.end());
  parallel_for(dense.size(), threads_, [&](std::size_t i) { pull(dense[i]); });
}

Eigen::VectorXd RayForward::exact(Warnings* warnings) {
  if (statistics_.empty()) return {};
  const auto* grid = std::get_if<CartesianGrid>(&path_.pupil.structure);
  if (warnings && grid && grid->x.size() > 1)
    if (const auto coarse = undersampled(path_.surface.terms(), grid->x[1] - grid->x[0]))
      warnings->push_back(*coarse);
  return evaluate_exact(input(), statistics_, threads_, warnings);
}

std::string RayForward::trouble() const {
  return "a focal statistic has no derivative (all rays meet in one point, or the kernel is wider than the "
         "spot); start from a realisation instead of the perfect mirror";
}

}  // namespace aberfit::internal
