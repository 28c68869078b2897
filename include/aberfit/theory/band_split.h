#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// A roughness split at a frequency (PHYSICS 10). A surface represents the part below the cut. A scatter
/// function represents the part above: the factor exp(-(4 pi/lambda)^2 (C_rest(0) - C_rest(x))) on the
/// transfer function. Independent parts multiply, so the mean over such surfaces is generalised Harvey-Shack
/// of the whole for any cut. Heights and slopes add in squares. In the aperture-exact form the exponent
/// varies over the aperture; the factor is its mean over the overlap. That is exact in focus for a mirror
/// without aberrations. Else the error is about 1e-3 (f/2) of the energy that both scatter.
class BandSplit : public MeanScatter {
 public:
  /// cut [cycles/m] lies inside the band of `psd` or at one of its ends; then one part is empty. `whole`:
  /// prediction with the same psd, mirror, aperture and source.
  BandSplit(const RadialPsd& psd, double cut, const Mirror& mirror, const Aperture& aperture,
            const Light& light, std::shared_ptr<const GeneralisedHarveyShack> whole);

  double cut() const { return cut_; }              ///< [cycles/m]
  const RadialPsd& low() const { return low_; }    ///< the part that the surface terms represent
  const RadialPsd& rest() const { return rest_; }  ///< the part that scatters
  bool has_low() const { return low_light_.has_value(); }
  bool has_rest() const { return rest_light_.has_value(); }
  double tis() const;  ///< fraction of the energy that the rest scatters
  /// Radius [m] in focus that the field of view of a surface with the low part must hold. It covers 95 % of
  /// the mean spot of that part and the angle to which its highest frequency scatters.
  double low_reach() const { return low_reach_; }

  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override;
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override;
  double encircled_energy(double radius) const override { return in_plane(radius, 0)->energy; }
  double encircled_energy_slope(double radius) const override { return in_plane(radius, 0)->slope; }
  /// Keeps results: fits repeat radii and a wide band takes up to a millisecond. NaN for infinite radii.
  std::optional<Encircled> in_plane(double radius, double dz) const override;
  double irradiance() const override { return focus_.irradiance(0); }
  double image_transfer(double frequency) const override { return focus_.transfer(frequency); }
  double rms_height() const override { return rest_height_; }
  double rms_slope_per_axis() const override { return rest_slope_; }
  double scatter_rms() const override { return rest_angle_; }
  std::shared_ptr<const MeanScatter> of_line(std::size_t k) const override { return lines_[k]; }

 private:
  double cut_ = 0;
  RadialPsd low_, rest_;
  std::optional<GeneralisedHarveyShack> low_light_, rest_light_;
  double low_reach_ = 0, rest_height_ = 0, rest_slope_ = 0, rest_angle_ = 0;
  MeanSpot focus_;
  struct Memory {
    std::mutex mutex;
    std::map<double, std::optional<MeanSpot>> spots;       // by dz; empty if the phase is too steep
    std::map<std::pair<double, double>, Encircled> known;  // by dz and radius
  };
  std::unique_ptr<Memory> memory_;
  std::shared_ptr<const GeneralisedHarveyShack> whole_;
  std::vector<std::shared_ptr<const BandSplit>> lines_;  // one per wavelength of a band
};

}  // namespace aberfit
