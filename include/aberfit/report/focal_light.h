#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {

/// Light near a focus as the pictures look at it, whatever model it comes from.
class FocalLight {
 public:
  virtual ~FocalLight() = default;
  /// The statistic as results have it; NaN where it does not exist.
  virtual double statistic(const Statistic& statistic) const = 0;
  /// Share of the light within each of `radii` [m, ascending] at plane dz [m]. NaN where it is not known.
  virtual Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz = 0.0) const = 0;
  /// Share of the light inside the ring of `radius` [m] at each of `planes` (dz [m], ascending).
  virtual Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const = 0;
  /// Share of the light per pixel of a square image, pixels x pixels over +-half_width [m] about the centre
  /// at plane dz [m]; column = x, row = y, from -half_width up. Light off the image is left out.
  virtual Eigen::ArrayXXd image(double dz, double half_width, int pixels) const = 0;
  /// No plane farther from the focus than this [m], on either side, has any light: cells of a pupil are too
  /// few for its cone.
  virtual double farthest_plane() const { return HUGE_VAL; }
  /// The transfer function at z = f of one surface, at most 512 lags either way; nothing where there is none.
  virtual std::optional<TransferImage> transfer() const { return std::nullopt; }
  /// The same at `frequencies` [cycles/m] of light that is round: its real part, the mean over directions.
  virtual std::optional<Eigen::ArrayXd> round_transfer(const Eigen::ArrayXd&) const { return std::nullopt; }
  /// Points of equal weight that a share is counted from, each drawn at random; infinite where none are.
  virtual double sample_size() const { return HUGE_VAL; }
};

/// Traced rays. nominal: the same pupil without surface error.
std::unique_ptr<FocalLight> ray_light(RayBundle rays, RayBundle nominal, Centre centre);

/// The spot of a term surface by the model of `path`: rays or waves. The path's parts must outlive the light.
/// Throws std::invalid_argument as make_forward_model does.
std::unique_ptr<FocalLight> surface_light(const LightPath& path, const Eigen::VectorXd& coefficients,
                                          int threads);

/// The ensemble-mean spot of a rough surface, which is round. shear_per_frequency: lambda f [m^2].
std::unique_ptr<FocalLight> mean_light(std::shared_ptr<const GeneralisedHarveyShack> spot,
                                       double shear_per_frequency, int threads);

}  // namespace aberfit
