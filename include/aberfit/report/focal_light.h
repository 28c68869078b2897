#pragma once
#include <Eigen/Core>
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {

/// Light near a focus as the pictures look at it, whatever model it comes from.
class FocalLight {
 public:
  virtual ~FocalLight() = default;
  /// The statistic as results have it; NaN where it does not exist.
  virtual double statistic(const Statistic& statistic) const = 0;
  /// Share of the light within each of `radii` [m, ascending] at z = f. NaN where it is not known.
  virtual Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii) const = 0;
  /// Share of the light inside the ring of `radius` [m] at each of `planes` (dz [m], ascending).
  virtual Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const = 0;
  /// Share of the light per pixel of a square image, pixels x pixels over +-half_width [m] about the centre
  /// at plane dz [m]; column = x, row = y, from -half_width up. Light off the image is left out.
  virtual Eigen::ArrayXXd image(double dz, double half_width, int pixels) const = 0;
  /// Points of equal weight that a share is counted from, each drawn at random; infinite where none are.
  virtual double sample_size() const { return HUGE_VAL; }
};

/// Traced rays. nominal: the same pupil without surface error.
std::unique_ptr<FocalLight> ray_light(RayBundle rays, RayBundle nominal, Centre centre);

/// The spot of a term surface by the model of `path`: rays or waves. The path's parts must outlive the light.
/// Throws std::invalid_argument as make_forward_model does.
std::unique_ptr<FocalLight> surface_light(const LightPath& path, const Eigen::VectorXd& coefficients,
                                          int threads);

/// The ensemble-mean spot of a rough surface, which is round.
std::unique_ptr<FocalLight> mean_light(std::shared_ptr<const GeneralisedHarveyShack> spot, int threads);

}  // namespace aberfit
