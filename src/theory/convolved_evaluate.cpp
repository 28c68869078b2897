#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "aberfit/core/parallel.h"
#include "aberfit/theory/convolved_focus.h"
#include "aberfit/focus/ring_search.h"

namespace aberfit {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// In a dark ring the energy does not change with the radius: EE'(r) r below this gives no derivative.
constexpr double kDark = 1e-10;

// Adds `scale` times d energy/dX of the plane z = f + dz to the crossings of z = f and the slopes.
void add(const Eigen::ArrayX2d& energy_gradient, double scale, double dz, RayGradient* gradient) {
  const auto count = std::size_t(energy_gradient.rows());
  gradient->all_rays = true;
  for (std::vector<double>* d : {&gradient->d_x, &gradient->d_y, &gradient->d_tx, &gradient->d_ty})
    if (d->size() != count) d->assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const double gx = scale * energy_gradient(Eigen::Index(i), 0);
    const double gy = scale * energy_gradient(Eigen::Index(i), 1);
    gradient->d_x[i] += gx;
    gradient->d_y[i] += gy;
    gradient->d_tx[i] += dz * gx;
    gradient->d_ty[i] += dz * gy;
  }
}

// The only term, in a plane that the gradient refers to.
void set(const Eigen::ArrayX2d& energy_gradient, double scale, double dz, RayGradient* gradient) {
  const auto count = std::size_t(energy_gradient.rows());
  gradient->all_rays = true;
  gradient->dz = dz;
  gradient->d_x.resize(count);
  gradient->d_y.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    gradient->d_x[i] = scale * energy_gradient(Eigen::Index(i), 0);
    gradient->d_y[i] = scale * energy_gradient(Eigen::Index(i), 1);
  }
}

// One statistic; NaN when it does not exist. The plane is null where the statistic needs none or has none.
class ConvolvedEvaluator {
 public:
  ConvolvedEvaluator(const AperturePattern& pattern, const RayBundle& rays, const ConvolvedPlane* plane,
                     RayGradient* gradient)
      : pattern_(pattern), rays_(rays), plane_(plane), gradient_(gradient) {}

  double operator()(const EncircledEnergyRadius& s) const {
    if (!plane_) return kNaN;
    const auto radius = plane_->radius(s.fraction);
    if (!radius) return kNaN;
    if (gradient_) {
      const double density = plane_->density(*radius);
      if (!(density * *radius > kDark)) return kNaN;
      set(plane_->energy_gradient(*radius), -1 / density, s.dz, gradient_);
    }
    return *radius;
  }
  double operator()(const RingThrough& s) const {
    if (!plane_ || !(s.ring_radius > 0) || s.ring_radius > plane_->largest_radius()) return kNaN;
    if (gradient_) set(plane_->energy_gradient(s.ring_radius), 1, s.dz, gradient_);
    return plane_->energy(s.ring_radius);
  }
  double operator()(const RingFwhm& s) const {
    const ConvolvedPlane focus(pattern_, rays_, 0.0);
    double ring = s.ring_radius.value_or(0.0);
    if (!s.ring_radius) {
      const auto radius = focus.radius(s.ring_fraction);
      if (!radius) return kNaN;
      ring = *radius;
    }
    const auto found = crossings(ring);
    if (!found) return kNaN;
    if (gradient_ && !ring_gradient(s, focus, ring, *found)) return kNaN;
    return found->upper - found->lower;
  }
  double operator()(const SpotFwhm&) const { return kNaN; }
  double operator()(const ScatterRms&) const { return kNaN; }
  double operator()(const ScatterMean&) const { return kNaN; }
  double operator()(const RmsRadius&) const { return kNaN; }
  double operator()(const RmsHeight&) const { return kNaN; }

 private:
  std::optional<RingCrossings> crossings(double ring) const {
    // A ring that holds a converging beam of RMS slope t is half empty about ring / t from the focus; rough
    // mirrors spread the profile about twice as far.
    const double light = rays_.weight.sum();
    const double slope = std::sqrt((rays_.weight * (rays_.tx.square() + rays_.ty.square())).sum() / light);
    if (!(ring > 0) || !(slope > 0)) return std::nullopt;
    const auto energy = [&](double dz) {
      if (!pattern_.has_plane(dz)) return kNaN;
      const ConvolvedPlane plane(pattern_, rays_, dz);
      return ring <= plane.largest_radius() ? plane.energy(ring) : kNaN;
    };
    const auto energy_slope = [&](double dz) {
      const ConvolvedPlane plane(pattern_, rays_, dz);
      return plane.energy_slope(ring, plane.energy_gradient(ring));
    };
    return search_ring(energy, energy_slope, 0.25 * ring / slope);
  }

  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; the peak does not move N(peak) to first
  // order.
  bool ring_gradient(const RingFwhm& s, const ConvolvedPlane& focus, double ring,
                     const RingCrossings& at) const {
    const ConvolvedPlane top(pattern_, rays_, at.peak);
    const Eigen::ArrayX2d top_gradient = top.energy_gradient(ring);
    double d_ring = 0, top_scale = 0;
    for (const double side : {-1.0, 1.0}) {
      const double dz = side < 0 ? at.lower : at.upper;
      const ConvolvedPlane plane(pattern_, rays_, dz);
      const Eigen::ArrayX2d gradient = plane.energy_gradient(ring);
      const double slope = plane.energy_slope(ring, gradient);
      if (!(std::abs(slope) > 0)) return false;
      add(gradient, -side / slope, dz, gradient_);
      top_scale += 0.5 * side / slope;
      d_ring += side * (0.5 * top.density(ring) - plane.density(ring)) / slope;
    }
    add(top_gradient, top_scale, at.peak, gradient_);
    if (s.ring_radius) return true;
    const double density = focus.density(ring);
    if (!(density * ring > kDark)) return false;
    add(focus.energy_gradient(ring), -d_ring / density, 0.0, gradient_);
    return true;
  }

  const AperturePattern& pattern_;
  const RayBundle& rays_;
  const ConvolvedPlane* plane_;
  RayGradient* gradient_;
};

}  // namespace

bool evaluate_convolved(const AperturePattern& pattern, const RayBundle& rays,
                        const std::vector<Statistic>& statistics, int threads, Eigen::VectorXd* values,
                        std::vector<RayGradient>* gradients) {
  values->setConstant(Eigen::Index(statistics.size()), kNaN);
  if (gradients) {
    gradients->resize(statistics.size());
    for (RayGradient& gradient : *gradients) gradient.clear();
  }
  if (!(rays.weight.sum() > 0)) return false;
  std::map<double, std::unique_ptr<const ConvolvedPlane>> planes;
  std::vector<double> plane_of(statistics.size(), kNaN);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    if (const auto* radius = std::get_if<EncircledEnergyRadius>(&statistics[k])) plane_of[k] = radius->dz;
    if (const auto* ring = std::get_if<RingThrough>(&statistics[k])) plane_of[k] = ring->dz;
    if (pattern.has_plane(plane_of[k]))
      planes[plane_of[k]];
    else
      plane_of[k] = kNaN;
  }
  std::vector<double> wanted;
  for (const auto& plane : planes) wanted.push_back(plane.first);
  std::vector<std::unique_ptr<const ConvolvedPlane>*> place;
  for (auto& plane : planes) place.push_back(&plane.second);
  parallel_for(wanted.size(), threads, [&](std::size_t j) {
    *place[j] = std::make_unique<const ConvolvedPlane>(pattern, rays, wanted[j]);
  });
  parallel_for(statistics.size(), threads, [&](std::size_t k) {
    const ConvolvedPlane* plane = std::isnan(plane_of[k]) ? nullptr : planes.at(plane_of[k]).get();
    const ConvolvedEvaluator evaluate(pattern, rays, plane, gradients ? &(*gradients)[k] : nullptr);
    (*values)[Eigen::Index(k)] = std::visit(evaluate, statistics[k]);
  });
  return values->allFinite();
}

}  // namespace aberfit
