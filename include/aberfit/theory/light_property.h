#pragma once
#include <Eigen/Core>
#include <memory>
#include <variant>
#include <vector>

#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {

class AberratedLight;

// Properties of the mean focal irradiance that are no statistics of rays (PHYSICS 2, "By wave optics alone").

/// TIS: fraction of the energy that is scattered, 1 - core.
struct TotalScatter {};
/// Side [m] of the square about the axis that holds `fraction` of the energy (MeanSpot::ensquared_side).
struct EnsquaredSide {
  double fraction = 0.8;  ///< in (0, 1)
  double dz = 0;          ///< [m]
};
/// Full width [m] at half maximum of the irradiance (MeanSpot::fwhm); SpotFwhm is that of a line spread.
struct IrradianceFwhm {
  double dz = 0;  ///< [m]
};
/// PSSN, normalised point source sensitivity (Seo, Nissly, Troy and Angeli 2009): int |OTF OTF_air|^2 d2nu
/// over the same integral of the perfect parabola. OTF_air = exp(-3.44 (x/r0)^(5/3)) is the long exposure
/// through Kolmogorov turbulence (Fried 1966). r0 goes as lambda^(6/5). Each OTF is averaged over direction.
struct PointSourceSensitivity {
  double r0 = 0.15;  ///< at kWavelengthOfR0 [m]
};
inline constexpr double kWavelengthOfR0 = 500e-9;  ///< [m]
/// BSDF [1/sr] of an infinite flat patch at normal incidence (ScatterFunction), not smoothed by the aperture.
/// The scatter is isotropic, so the value holds in every plane through the normal.
struct PatchBsdf {
  double theta = 0;  ///< angle from the specular direction [rad], in (0, pi/2)
};
/// StrehlRatio and ModulationTransfer are also statistics.
using LightProperty = std::variant<StrehlRatio, TotalScatter, ModulationTransfer, EnsquaredSide,
                                   IrradianceFwhm, PointSourceSensitivity, PatchBsdf>;

/// Values of properties for many PSDs in one scene. It keeps the values of the perfect parabola.
class LightProperties {
 public:
  /// Predicts the parabola without roughness once, where a property needs it. A Strehl ratio is that of the
  /// highest irradiance. A mirror without aberrations has it on the axis, one of revolution on a ring; for
  /// others AberratedLight finds it. Throws as GeneralisedHarveyShack and AberratedLight do.
  LightProperties(std::vector<LightProperty> wanted, const GhsPupil& pupil);

  const std::vector<LightProperty>& wanted() const { return wanted_; }
  /// Values in the order of `wanted` [m], [1/sr] or [1]; `mean` must be that of the same pupil. Infinite
  /// where a fraction of the energy does not lie within r = f; NaN where an irradiance does not fall to half
  /// within it. Each takes microseconds to a few milliseconds; a PatchBsdf and a StrehlRatio off the axis
  /// take tenths of a second. Const use from many threads is safe.
  Eigen::VectorXd operator()(const GeneralisedHarveyShack& mean) const;

 private:
  friend class JacobianOfGhs;
  double value(std::size_t k, const GeneralisedHarveyShack& mean) const;
  double r0_of(const PointSourceSensitivity& property) const;
  double strehl(std::size_t k, const GeneralisedHarveyShack& mean) const;

  std::vector<LightProperty> wanted_;
  std::vector<double> perfect_;  // value of the perfect parabola for each property
  double wavelength_ = 0;
  std::shared_ptr<const AberratedLight> aberrated_;  // null unless a Strehl ratio needs it
};

}  // namespace aberfit
