#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {

/// Irradiance near a focus, by any model, as the pictures show it.
class FocalLight {
 public:
  virtual ~FocalLight() = default;
  /// The statistic as in the results; NaN if it does not exist.
  virtual double statistic(const Statistic& statistic) const = 0;
  /// Fraction of the energy within each of `radii` [m, ascending] at plane dz [m]; NaN where it is not known.
  virtual Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz = 0.0) const = 0;
  /// Fraction of the energy inside the ring of `radius` [m] at each of `planes` (dz [m], ascending).
  virtual Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const = 0;
  /// Fraction of the energy per pixel of a square image, pixels x pixels over +-half_width [m] about the
  /// centre at plane dz [m]; column = x, row = y, from -half_width up. Energy off the image is left out.
  virtual Eigen::ArrayXXd image(double dz, double half_width, int pixels) const = 0;
  /// Distance from the focus [m], on either side, beyond which the pupil grid is too coarse for the cone of
  /// light and gives no irradiance.
  virtual double farthest_plane() const { return HUGE_VAL; }
  /// Transfer function at z = f of one surface, at most 512 lags either way; empty if the model has none.
  virtual std::optional<TransferImage> transfer() const { return std::nullopt; }
  /// Transfer function of a round spot at `frequencies` [cycles/m]: the real part, averaged over directions.
  virtual std::optional<Eigen::ArrayXd> round_transfer(const Eigen::ArrayXd&) const { return std::nullopt; }
  /// Number of random points of equal weight behind a fraction of the energy; infinite for other methods.
  virtual double sample_size() const { return HUGE_VAL; }
};

/// Traced rays. nominal: the same pupil without surface error.
std::unique_ptr<FocalLight> ray_light(RayBundle rays, RayBundle nominal, Centre centre);

/// The spot of a term surface by the model of `path`, rays or waves. The parts of `path` must outlive it.
/// Throws std::invalid_argument as make_forward_model does.
std::unique_ptr<FocalLight> surface_light(const LightPath& path, const Eigen::VectorXd& coefficients,
                                          int threads);

/// The ensemble-mean spot of a rough surface, averaged over directions. shear_per_frequency: lambda f [m^2].
std::unique_ptr<FocalLight> mean_light(std::shared_ptr<const GeneralisedHarveyShack> spot,
                                       double shear_per_frequency, int threads);

}  // namespace aberfit
