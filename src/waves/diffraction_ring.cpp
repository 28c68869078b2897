#include "diffraction_ring.h"

#include <cmath>
#include <map>

#include "ring_search.h"

namespace aberfit::internal {
namespace {

// What the mean spot of a plane has inside a ring beyond that of the focus, where the cells do not see it: a
// halo widens with the square of the defocus. A search asks for planes that no one asks for again, and this
// is as smooth as the mean spot: a straight line in dz^2 between planes that all surfaces share. A mean of
// every lag costs several planes of wide circles, so rings share them, too: planes at multiples of a power of
// two.
class OwnMeans {
 public:
  OwnMeans(DiffractionPlane* plane, double ring, double step)
      : plane_(plane), ring_(ring), apart_(std::exp2(std::ceil(std::log2(step)))) {}

  struct Line {
    double energy, slope;
  };
  /// Leaves the plane that `plane` was in.
  Line at(double dz) {
    const double z = dz / apart_, low = std::floor(z), here = of(low);
    const double by_square = (of(low + 1) - here) / (2 * low + 1);  // (low + 1)^2 - low^2
    return {here + (z * z - low * low) * by_square, 2 * z / apart_ * by_square};
  }

 private:
  double of(double place) {
    const auto known = known_.find(place);
    if (known != known_.end()) return known->second;
    return known_[place] = plane_->light_of_own_mean(ring_, place * apart_);
  }
  DiffractionPlane* plane_;
  double ring_, apart_;
  std::map<double, double> known_;
};

}  // namespace

std::optional<DiffractionRingWidth> diffraction_ring_width(const DiffractionScene& scene,
                                                           DiffractionPlane* plane, RingMemory* memory,
                                                           double ring, Eigen::ArrayXd* d_phase,
                                                           double* d_ring) {
  if (!(ring > 0)) return std::nullopt;
  // A perfect disc of light of RMS radius rho is half inside the ring at dz = f ring/rho; rays of a rough
  // mirror spread the profile about twice as far. Five steps of a quarter hold either, more are added as
  // needed.
  const PupilSample& sample = scene.problem().pupil.sample;
  const double rho = std::sqrt((sample.weight * (sample.x.square() + sample.y.square())).sum());
  if (!(rho > 0)) return std::nullopt;
  const double step = 0.25 * scene.problem().focal_length * ring / rho;
  OwnMeans own(plane, ring, step);
  const bool has_means = scene.problem().scatter != nullptr;
  // NaN where the plane does not exist or the ring leaves the field of view.
  const auto energy_at = [&](double dz, bool with_own) {
    if (!scene.has_plane(dz) || ring > scene.largest_radius(dz)) return std::nan("");
    const double more = with_own ? own.at(dz).energy : 0;
    plane->focus(dz);
    return plane->energy(ring) + more;
  };
  const auto slope_at = [&](double dz, bool with_own) {
    const double more = with_own ? own.at(dz).slope : 0;
    plane->focus(dz);
    return plane->energy_slope(ring, plane->energy_gradient(ring).over_phases()) + more;
  };
  const auto energy = [&](double dz) { return energy_at(dz, has_means); };
  const auto slope = [&](double dz) { return slope_at(dz, has_means); };
  const std::optional<RingMemory::Crossings> known = memory ? memory->find(ring, step) : std::nullopt;
  RingMemory::Crossings found = known ? *known : std::nullopt;
  if (!known) {
    if (const RingMemory::Crossings near = memory ? memory->near(ring) : std::nullopt)
      found = follow_ring(energy, slope, *near, step);
    if (!found) {  // dozens of planes: with the mean spot of the focus, and from there with those of the
                   // planes
      found = search_ring([&](double dz) { return energy_at(dz, false); },
                          [&](double dz) { return slope_at(dz, false); }, step);
      if (found && has_means) {
        const RingMemory::Crossings near = follow_ring(energy, slope, *found, step);
        found = near ? near : search_ring(energy, slope, step);
      }
    }
  }
  if (memory && !known) memory->keep(ring, step, found);
  if (!found) return std::nullopt;
  const DiffractionRingWidth result{found->upper - found->lower, found->peak, found->lower, found->upper};
  if (!d_phase) return result;
  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; the peak does not move N(peak) to first
  // order.
  struct End {
    double density, slope;
    Eigen::ArrayXd gradient;
  };
  const auto end_at = [&](double z) {
    const double more = has_means ? own.at(z).slope : 0;
    plane->focus(z);
    End end{plane->density(ring), 0.0, plane->energy_gradient(ring).over_phases()};
    end.slope = plane->energy_slope(ring, end.gradient) + more;
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
