#pragma once
#include <Eigen/Core>
#include <memory>
#include <variant>
#include <vector>

#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {

class AberratedLight;

// Properties of the mean light in the focus that are no statistics of rays (PHYSICS 2, "Of light alone").

/// TIS: share of the light that is scattered, 1 - core.
struct TotalScatter {};
/// Side [m] of the square about the axis that holds a share of the light (MeanSpot::ensquared_side).
struct EnsquaredSide {
  double fraction = 0.8;  ///< in (0, 1)
  double dz = 0;          ///< [m]
};
/// Full width [m] at half maximum of the irradiance itself (MeanSpot::fwhm), not of a line spread as
/// SpotFwhm.
struct IrradianceFwhm {
  double dz = 0;  ///< [m]
};
/// PSSN, normalised point source sensitivity (Seo, Nissly, Troy and Angeli 2009): int |OTF OTF_air|^2 d2nu
/// over the same of the perfect parabola, OTF_air = exp(-3.44 (x/r0)^(5/3)) the long exposure through
/// Kolmogorov turbulence (Fried 1966). r0 goes as lambda^(6/5). Of pupils without symmetry with the OTFs'
/// means over direction.
struct PointSourceSensitivity {
  double r0 = 0.15;  ///< at kWavelengthOfR0 [m]
};
inline constexpr double kWavelengthOfR0 = 500e-9;  ///< [m]
/// BSDF [1/sr] of an infinite flat patch at normal incidence, in one plane through the normal: the scatter is
/// isotropic, so in every one (ScatterFunction). Not smoothed by the aperture.
struct PatchBsdf {
  double theta = 0;  ///< from the specular direction [rad], in (0, pi/2)
};
/// StrehlRatio and ModulationTransfer are statistics as well.
using LightProperty = std::variant<StrehlRatio, TotalScatter, ModulationTransfer, EnsquaredSide,
                                   IrradianceFwhm, PointSourceSensitivity, PatchBsdf>;

/// Values of properties for many PSDs in one scene, with what they have of the perfect parabola.
class LightProperties {
 public:
  /// Without roughness the parabola is predicted once where a property needs it. A Strehl ratio is that of
  /// the highest irradiance: on the axis of a mirror without aberrations, on a ring of one of revolution,
  /// else where AberratedLight finds it. Throws as GeneralisedHarveyShack and AberratedLight do.
  LightProperties(std::vector<LightProperty> wanted, const GhsPupil& pupil);

  const std::vector<LightProperty>& wanted() const { return wanted_; }
  /// In the order of `wanted` [m], [1/sr] or [1]; `mean` is of that pupil. Infinite where a share of the
  /// light does not lie within r = f, NaN where an irradiance does not fall to half within it. Microseconds
  /// to a few milliseconds each, a PatchBsdf tenths of a second, and so a StrehlRatio off the axis. Const use
  /// from many threads.
  Eigen::VectorXd operator()(const GeneralisedHarveyShack& mean) const;

 private:
  friend class JacobianOfGhs;
  double value(std::size_t k, const GeneralisedHarveyShack& mean) const;
  double r0_of(const PointSourceSensitivity& property) const;
  double strehl(std::size_t k, const GeneralisedHarveyShack& mean) const;

  std::vector<LightProperty> wanted_;
  std::vector<double> perfect_;  // what a property is relative to
  double wavelength_ = 0;
  std::shared_ptr<const AberratedLight> aberrated_;  // where a Strehl ratio needs it, else null
};

}  // namespace aberfit
