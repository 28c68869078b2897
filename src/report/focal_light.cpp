#include "aberfit/report/focal_light.h"

#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "focus_curves.h"
#include "round_image.h"

namespace aberfit {
using namespace internal;

namespace {

class RayLight : public FocalLight {
 public:
  RayLight(RayBundle rays, RayBundle nominal, Centre centre)
      : rays_(std::move(rays)), nominal_(std::move(nominal)), centre_(centre) {}

  // These are the estimators of the result, so that picture and table agree.
  double statistic(const Statistic& wanted) const override {
    return ray_statistic(rays_, nominal_, centre_, wanted);
  }
  Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz) const override {
    return encircled_energy_curve(rays_, centre_, dz, radii);
  }
  Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
    return ring_through_curve(rays_, centre_, radius, planes);
  }
  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    return focal_image(rays_, centre_, dz, half_width, pixels);
  }
  // N_eff = (sum w)^2 / sum w^2 (Kish 1965).
  double sample_size() const override {
    const double sum = rays_.weight.sum();
    return sum * sum / rays_.weight.square().sum();
  }

 private:
  RayBundle rays_, nominal_;
  Centre centre_;
};

class MeanLight : public FocalLight {
 public:
  MeanLight(std::shared_ptr<const GeneralisedHarveyShack> spot, double shear_per_frequency, int threads)
      : spot_(std::move(spot)), shear_per_frequency_(shear_per_frequency), threads_(threads) {}

  double statistic(const Statistic& wanted) const override {
    try {
      return (*spot_)(wanted);
    } catch (const ComputationError&) {
      return std::nan("");
    }
  }
  Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz) const override {
    return shares(dz, radii);
  }
  Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
    Eigen::ArrayXd share(planes.size());
    parallel_for(std::size_t(planes.size()), threads_, [&](std::size_t k) {
      share[Eigen::Index(k)] = spot_->encircled_energy(radius, planes[Eigen::Index(k)]);
    });
    return share;
  }
  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    const GhsPupil& pupil = spot_->pupil();
    const double detail = shear_per_frequency_ * (1 + dz / pupil.mirror().focal_length) /
                          (2 * aperture_radius(pupil.aperture()));
    return round_image([&](const Eigen::ArrayXd& radii) { return shares(dz, radii); }, detail, half_width,
                       pixels);
  }
  std::optional<Eigen::ArrayXd> round_transfer(const Eigen::ArrayXd& frequencies) const override {
    Eigen::ArrayXd value(frequencies.size());
    parallel_for(std::size_t(frequencies.size()), threads_, [&](std::size_t k) {
      const double shear = shear_per_frequency_ * frequencies[Eigen::Index(k)];
      value[Eigen::Index(k)] = spot_->transfer(shear, 0.0);
    });
    return value;
  }

 private:
  Eigen::ArrayXd shares(double dz, const Eigen::ArrayXd& radii) const {
    const MeanSpot plane = spot_->at_plane(dz);
    Eigen::ArrayXd share(radii.size());
    parallel_for(std::size_t(radii.size()), threads_, [&](std::size_t k) {
      share[Eigen::Index(k)] = plane.encircled_energy(radii[Eigen::Index(k)]);
    });
    return share;
  }

  std::shared_ptr<const GeneralisedHarveyShack> spot_;
  double shear_per_frequency_;
  int threads_;
};

}  // namespace

std::unique_ptr<FocalLight> ray_light(RayBundle rays, RayBundle nominal, Centre centre) {
  return std::make_unique<RayLight>(std::move(rays), std::move(nominal), centre);
}

std::unique_ptr<FocalLight> mean_light(std::shared_ptr<const GeneralisedHarveyShack> spot,
                                       double shear_per_frequency, int threads) {
  return std::make_unique<MeanLight>(std::move(spot), shear_per_frequency, threads);
}

}  // namespace aberfit
