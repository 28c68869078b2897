#include "diffraction_ring.h"

#include <cmath>
#include <map>

#include "ring_search.h"

namespace aberfit::internal {
namespace {

// The encircled energy that the mean spot of a plane has beyond that of the focus, outside the grid. A halo
// widens with the square of the defocus. This is as smooth as the mean spot. So we interpolate linearly in
// dz^2 between planes at multiples of a power of two, which all surfaces and rings share.
class OwnMeans {
 public:
  OwnMeans(DiffractionPlane* plane, double ring, double step)
      : plane_(plane), ring_(ring), apart_(std::exp2(std::ceil(std::log2(step)))) {}

  struct Line {
    double energy, slope, density;  // slope: of the energy over dz; density: over the ring's radius
  };
  /// The object `plane` leaves its current plane.
  Line at(double dz) {
    const double z = dz / apart_, low = std::floor(z);
    const DiffractionPlane::InCircle here = of(low), next = of(low + 1);
    const double per_square = 1 / (2 * low + 1), part = (z * z - low * low) * per_square;
    const double by_square = (next.energy - here.energy) * per_square;
    return {here.energy + part * (next.energy - here.energy), 2 * z / apart_ * by_square,
            here.density + part * (next.density - here.density)};
  }

 private:
  DiffractionPlane::InCircle of(double place) {
    const auto known = known_.find(place);
    if (known != known_.end()) return known->second;
    return known_[place] = plane_->light_of_own_mean(ring_, place * apart_);
  }
  DiffractionPlane* plane_;
  double ring_, apart_;
  std::map<double, DiffractionPlane::InCircle> known_;
};

// N(z) and its slope. own: null: all planes use the mean spot of the focus beyond the grid.
class RingLight {
 public:
  RingLight(const DiffractionScene& scene, DiffractionPlane* plane, double ring, OwnMeans* own)
      : scene_(scene), plane_(plane), ring_(ring), own_(own) {}

  // NaN when the plane does not exist or the ring exceeds the field of view.
  double energy(double dz) const {
    if (!scene_.has_plane(dz) || ring_ > scene_.largest_radius(dz)) return std::nan("");
    const double more = beyond(dz).energy;
    plane_->focus(dz);
    return plane_->energy(ring_) + more;
  }
  double slope(double dz) const {
    Eigen::ArrayXd gradient;
    return slope(dz, &gradient);
  }
  // Derivative with respect to the ring's radius.
  double density(double dz) const {
    const double more = beyond(dz).density;
    plane_->focus(dz);
    return plane_->density(ring_) + more;
  }
  // gradient: of the energy with respect to the phases.
  double slope(double dz, Eigen::ArrayXd* gradient) const {
    const double more = beyond(dz).slope;
    plane_->focus(dz);
    *gradient = plane_->energy_gradient(ring_).over_phases();
    return plane_->energy_slope(ring_, *gradient) + more;
  }
  RingMemory::Crossings search(double step) const {
    return search_ring([this](double dz) { return energy(dz); }, [this](double dz) { return slope(dz); },
                       step);
  }
  RingMemory::Crossings follow(const RingCrossings& near, double step) const {
    return follow_ring([this](double dz) { return energy(dz); }, [this](double dz) { return slope(dz); },
                       near, step);
  }

 private:
  OwnMeans::Line beyond(double dz) const { return own_ ? own_->at(dz) : OwnMeans::Line{0, 0, 0}; }
  const DiffractionScene& scene_;
  DiffractionPlane* plane_;
  double ring_;
  OwnMeans* own_;
};

}  // namespace

std::optional<DiffractionRingWidth> diffraction_ring_width(const DiffractionScene& scene,
                                                           DiffractionPlane* plane, RingMemory* memory,
                                                           double ring, Eigen::ArrayXd* d_phase,
                                                           double* d_ring) {
  if (!(ring > 0)) return std::nullopt;
  // A uniform disc of RMS radius rho is half inside the ring at dz = f ring/rho; rays of a rough mirror make
  // the profile about twice as wide. Five steps of a quarter cover both, and the search adds more if needed.
  const PupilSample& sample = scene.problem().pupil.sample;
  const double rho = std::sqrt((sample.weight * (sample.x.square() + sample.y.square())).sum());
  if (!(rho > 0)) return std::nullopt;
  const double step = 0.25 * scene.problem().focal_length * ring / rho;
  std::optional<OwnMeans> own;
  if (scene.problem().scatter) own.emplace(plane, ring, step);
  const RingLight light(scene, plane, ring, own ? &*own : nullptr);
  const std::optional<RingMemory::Crossings> known = memory ? memory->find(ring, step) : std::nullopt;
  RingMemory::Crossings found = known ? *known : std::nullopt;
  if (!known) {
    if (const RingMemory::Crossings near = memory ? memory->near(ring) : std::nullopt)
      found = light.follow(*near, step);
    if (!found && own) {  // we search with the mean spot of the focus, then follow with those of the planes
      const RingMemory::Crossings roughly = RingLight(scene, plane, ring, nullptr).search(step);
      if (roughly) found = light.follow(*roughly, step);
      if (roughly && !found) found = light.search(step);
    } else if (!found) {
      found = light.search(step);
    }
  }
  if (memory && !known) memory->keep(ring, step, found);
  if (!found) return std::nullopt;
  const DiffractionRingWidth result{found->upper - found->lower, found->peak, found->lower, found->upper};
  if (!d_phase) return result;
  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; N is stationary at the peak.
  struct End {
    double density, slope;
    Eigen::ArrayXd gradient;
  };
  const auto end_at = [&](double z) {
    End end;
    end.slope = light.slope(z, &end.gradient);
    end.density = light.density(z);
    return end;
  };
  const End at_upper = end_at(found->upper), at_lower = end_at(found->lower), at_peak = end_at(found->peak);
  if (at_upper.slope == 0 || at_lower.slope == 0) return std::nullopt;
  const double for_upper = -1 / at_upper.slope, for_lower = 1 / at_lower.slope;
  const double for_peak = -0.5 * (for_upper + for_lower);
  *d_phase = for_upper * at_upper.gradient + for_lower * at_lower.gradient + for_peak * at_peak.gradient;
  *d_ring = for_upper * at_upper.density + for_lower * at_lower.density + for_peak * at_peak.density;
  return result;
}

}  // namespace aberfit::internal
