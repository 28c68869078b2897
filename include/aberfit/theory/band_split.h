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

/// A roughness split at a frequency (PHYSICS 10): below it a surface stands for it, above it a scatter
/// function does, exp(-(4 pi/lambda)^2 (C_rest(0) - C_rest(x))) on the transfer function. Independent parts
/// multiply, so that the mean over such surfaces is generalised Harvey-Shack of the whole, wherever the cut;
/// heights and slopes add in squares. In its aperture-exact form the exponent varies over the aperture; what
/// multiplies is its mean over the overlap, exact in focus for a mirror without aberrations. Out of focus and
/// over f/2 mirrors that is some 1e-3 of the light that both parts scatter.
class BandSplit : public MeanScatter {
 public:
  /// cut [cycles/m] inside the band of `psd`, or at one of its ends: then one part is empty. `whole`: of the
  /// same psd, mirror, aperture and light.
  BandSplit(const RadialPsd& psd, double cut, const Mirror& mirror, const Aperture& aperture,
            const Light& light, std::shared_ptr<const GeneralisedHarveyShack> whole);

  double cut() const { return cut_; }              ///< [cycles/m]
  const RadialPsd& low() const { return low_; }    ///< what the terms stand for
  const RadialPsd& rest() const { return rest_; }  ///< what scatters
  bool has_low() const { return low_light_.has_value(); }
  bool has_rest() const { return rest_light_.has_value(); }
  double tis() const;  ///< share of the light that the rest scatters
  /// Radius [m] of the light in focus that a surface with the low part needs room for: the 95 % of its mean
  /// spot, and where its highest frequency scatters to.
  double low_reach() const { return low_reach_; }

  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override;
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override;
  double encircled_energy(double radius) const override { return in_plane(radius, 0)->energy; }
  double encircled_energy_slope(double radius) const override { return in_plane(radius, 0)->slope; }
  /// Remembered: a wide band takes up to a millisecond, and a fit asks for the same radii in every step. NaN
  /// for a radius that is not finite.
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
    std::map<double, std::optional<MeanSpot>> spots;       // by dz; nothing: aberrations turn too often there
    std::map<std::pair<double, double>, Encircled> known;  // by dz and radius
  };
  std::unique_ptr<Memory> memory_;
  std::shared_ptr<const GeneralisedHarveyShack> whole_;
  std::vector<std::shared_ptr<const BandSplit>> lines_;  // of a band
};

}  // namespace aberfit
