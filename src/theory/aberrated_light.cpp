#include "aberfit/theory/aberrated_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/trace/nominal_surface.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

constexpr int kLeastAcross = 128, kMostAcross = 2048;  // grid points across
// Largest phase change between neighbours [rad]. A change of pi sends energy to the edge of the field of
// view; half of that keeps all rays in its inner half.
constexpr double kMostTurn = 0.5 * kPi;

// H of all the roughness. The irradiance on the grid is completed with the mean spot of the parabola.
class MeanOfParabola : public MeanScatter {
 public:
  MeanOfParabola(const RadialPsd& psd, const GhsPupil& parabola)
      : mean_(psd, parabola), focus_(mean_.at_plane(0)) {}

  // The grid needs the factor of this part and that of the whole at the same shears; here they are equal.
  // Keeping them saves half of the work of a Strehl ratio.
  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override {
    const std::lock_guard lock(mutex_);
    if (shear.size() != shear_.size() || (shear != shear_).any()) {
      factor_ = mean_.overlap_transfer(shear);
      shear_ = shear;
    }
    return factor_;
  }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override { return transfer(shear); }
  double encircled_energy(double radius) const override { return focus_.encircled_energy(radius); }
  double encircled_energy_slope(double radius) const override {
    return focus_.encircled_energy_slope(radius);
  }
  double irradiance() const override { return focus_.irradiance(0); }
  double image_transfer(double frequency) const override { return focus_.transfer(frequency); }
  double rms_height() const override { return mean_.rms_height(); }
  double rms_slope_per_axis() const override { return psd_moments(mean_.psd()).rms_slope_per_axis(); }
  double scatter_rms() const override { return mean_.scatter_rms(); }

 private:
  GeneralisedHarveyShack mean_;
  MeanSpot focus_;
  mutable std::mutex mutex_;
  mutable Eigen::ArrayXd shear_, factor_;  // of the last call
};

}  // namespace

AberratedLight::AberratedLight(const GhsPupil& pupil) : parabola_(pupil.of_parabola()) {
  if (pupil.light().is_band())
    throw ComputationError(
        "for a band of wavelengths the peak of the PSF is not known if aberrations are not of revolution; "
        "request one wavelength, or leave out strehl and similar statistics");
  const Mirror& mirror = pupil.mirror();
  const double across = 2 * aperture_radius(pupil.aperture());
  for (int count = kLeastAcross;; count *= 2) {
    if (count > kMostAcross)
      throw ComputationError(fmt::format(
          "the aberrations of this mirror are too steep for its mean PSF in two dimensions: on {} grid "
          "points across the aperture their phase still changes by more than a quarter turn between "
          "neighbours. Take a mirror nearer to its parabola, or `\"theory\": \"geometric\"` in `target`",
          kMostAcross));
    cells_ = diffraction_pupil(parabola_.aperture(), mirror.focal_length, across / count);
    height_ = departure_from_parabola(mirror, cells_.sample);
    if (height_.size() == 0) height_ = Eigen::ArrayXd::Zero(cells_.sample.size());
    if (const auto& more = pupil.departure())
      for (Eigen::Index k = 0; k < height_.size(); ++k)
        height_[k] += more(cells_.sample.x[k], cells_.sample.y[k]);
    const DiffractionProblem flat{cells_, mirror.focal_length, pupil.wavelength()};
    if (check_diffraction(flat, height_, 0).largest_step <= kMostTurn) break;
  }
  const RayBundle rays = trace_nominal(mirror, cells_.sample);
  centroid_ = {(rays.weight * rays.x).sum() / rays.weight.sum(),
               (rays.weight * rays.y).sum() / rays.weight.sum()};
}

DiffractionProblem AberratedLight::problem(const RadialPsd& psd) const {
  DiffractionProblem problem{cells_, parabola_.mirror().focal_length, parabola_.wavelength()};
  problem.scatter = std::make_shared<const MeanOfParabola>(psd, parabola_);
  return problem;
}

DiffractionPeak AberratedLight::peak(const RadialPsd& psd) const {
  return diffraction_peak(problem(psd), height_);
}

// A tilt of the surface by X/(2f) along x moves the spot by X.
AberratedLight::HalfLight AberratedLight::half_light(const RadialPsd& psd) const {
  const DiffractionProblem problem = this->problem(psd);
  const double per_shift = 1 / (2 * problem.focal_length);
  const Eigen::ArrayXd tilt = per_shift * (centroid_[0] * cells_.sample.x + centroid_[1] * cells_.sample.y);
  const auto half = [&](const Eigen::ArrayXd& height) {
    Eigen::VectorXd value;
    evaluate_diffraction(problem, height, {EncircledEnergyRadius{0.5, 0}}, 1, nullptr, &value, nullptr);
    return value[0];
  };
  return {half(height_), half(height_ + tilt)};
}

}  // namespace aberfit
