#include <algorithm>
#include <cmath>

#include "aberfit/report/focal_light.h"
#include "aberfit/theory/convolved_focus.h"
#include "focus_curves.h"
#include "round_image.h"

namespace aberfit {
namespace {

// Statistics by the code that fits; what differs is how an image is made.
class DiffractedLight : public FocalLight {
 public:
  DiffractedLight(const FocusScene& scene, Eigen::VectorXd coefficients, int threads)
      : scene_(scene), coefficients_(std::move(coefficients)), threads_(threads) {}

  double statistic(const Statistic& wanted) const override { return values({wanted})[0]; }
  Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii) const override {
    std::vector<Statistic> wanted;
    for (const double radius : radii) wanted.push_back(RingThrough{radius, 0.0});
    Eigen::ArrayXd share = values(wanted);
    for (Eigen::Index k = 0; k < share.size(); ++k)
      if (radii[k] == 0) share[k] = 0;
    return share;
  }
  Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
    std::vector<Statistic> wanted;
    for (const double dz : planes) wanted.push_back(RingThrough{radius, dz});
    return values(wanted);
  }

 protected:
  Eigen::ArrayXd values(const std::vector<Statistic>& wanted) const {
    return focus_statistics(scene_, coefficients_, wanted, threads_, nullptr);
  }

  FocusScene scene_;
  Eigen::VectorXd coefficients_;
  int threads_;
};

// Common length of every pixel (rows) with every sample of a line (columns), both of even spacing [m].
Eigen::MatrixXd overlap(double half_width, int pixels, double first, double pitch, Eigen::Index samples) {
  const double pixel = 2 * half_width / pixels;
  Eigen::MatrixXd length = Eigen::MatrixXd::Zero(pixels, samples);
  for (Eigen::Index s = 0; s < samples; ++s) {
    const double left = first + (double(s) - 0.5) * pitch, right = left + pitch;
    const int from = std::max(0, int(std::floor((left + half_width) / pixel)));
    const int to = std::min(pixels - 1, int(std::floor((right + half_width) / pixel)));
    for (int p = from; p <= to; ++p) {
      const double begin = p * pixel - half_width;
      length(p, s) = std::max(0.0, std::min(right, begin + pixel) - std::max(left, begin));
    }
  }
  return length;
}

class WaveLight : public DiffractedLight {
 public:
  using DiffractedLight::DiffractedLight;

  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    constexpr double kSamplesPerPixel = 2;
    const double pixel = 2 * half_width / pixels;
    PsfWindow window;
    window.half_width = half_width + pixel;
    // Speckles are as wide as the pattern of the aperture: they are averaged over a pixel, not picked.
    const double speckle =
        scene_.wavelength * (scene_.mirror.focal_length + dz) / (2 * aperture_radius(*scene_.aperture));
    window.pitch = std::min(pixel / kSamplesPerPixel, speckle / 4);
    window.dz = dz;
    const PsfImage psf = focus_psf(scene_, coefficients_, window);
    const Eigen::MatrixXd x = overlap(half_width, pixels, psf.first, psf.pitch, psf.intensity.cols());
    const Eigen::MatrixXd y = overlap(half_width, pixels, psf.first, psf.pitch, psf.intensity.rows());
    return (y * psf.intensity.matrix() * x.transpose()).array();
  }
};

class ConvolvedLight : public DiffractedLight {
 public:
  ConvolvedLight(const FocusScene& scene, Eigen::VectorXd coefficients, int threads)
      : DiffractedLight(scene, std::move(coefficients), threads),
        pattern_(*scene.aperture, scene.mirror.focal_length, scene.wavelength) {
    SurfaceField field;
    scene.surface.apply(coefficients_, &field);
    rays_ = trace(scene.mirror, scene.pupil, field);
  }

  // Light of rays off the image is scattered into it, from as far as the image is wide.
  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    const int margin = pixels / 2, wide = pixels + 2 * margin;
    const double scale = double(wide) / pixels;
    const Eigen::ArrayXXd rays = focal_image(rays_, Centre::kNominal, dz, scale * half_width, wide);
    const int side = 2 * margin + 1;
    const Eigen::ArrayXXd kernel = round_image(
        [&](const Eigen::ArrayXd& radii) -> Eigen::ArrayXd {
          return radii.unaryExpr([&](double radius) { return pattern_.share(radius, 0.0, dz); });
        },
        half_width* side / pixels, side);
    Eigen::ArrayXXd image = Eigen::ArrayXXd::Zero(pixels, pixels);
    for (int column = 0; column < side; ++column)
      for (int row = 0; row < side; ++row)
        image += kernel(row, column) * rays.block(2 * margin - row, 2 * margin - column, pixels, pixels);
    return image;
  }

 private:
  AperturePattern pattern_;
  RayBundle rays_;
};

}  // namespace

std::unique_ptr<FocalLight> surface_light(const FocusScene& scene, const Eigen::VectorXd& coefficients,
                                          int threads) {
  if (scene.physics == FocusPhysics::kWaves) return std::make_unique<WaveLight>(scene, coefficients, threads);
  if (scene.physics == FocusPhysics::kConvolved)
    return std::make_unique<ConvolvedLight>(scene, coefficients, threads);
  SurfaceField field;
  scene.surface.apply(coefficients, &field);
  return ray_light(trace(scene.mirror, scene.pupil, field), trace_nominal(scene.mirror, scene.pupil),
                   scene.centre);
}

}  // namespace aberfit
