#pragma once
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "aberfit/core/random.h"
#include "aberfit/report/pictures.h"
#include "sample_result.h"

namespace aberfit {

/// A scene for pictures: the f = 2.8 m, 0.4 m parabola with a surface of Zernikes, 60 plane waves of random
/// phase and a spherical term, and a Gaussian target of the same RMS slope.
struct PlotScene {
  static constexpr double kFocalLength = 2.8, kRadius = 0.2, kWavelength = 632.8e-9;
  static constexpr int kGrid = 129;

  explicit PlotScene(Aperture clear = CircleAperture{2 * kRadius, 0}, std::int64_t rays = 30000)
      : aperture(clear) {
    mirror.focal_length = kFocalLength;
    pupil = make_pupil(aperture, {PupilLayout::kSobol, rays, 3});
    result = sample_result();
    result.fitted.terms = TermSet{kRadius, zernike_modes(2, 6), {}, {4, 6}};
    const RandomStream random(11, "plot-scene");
    for (std::uint64_t k = 0; k < 60; ++k) {
      const double f = 2.5 * std::pow(8.0, (double(k) + 0.5) / 60), angle = 2.399963229728653 * double(k);
      result.fitted.terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
    }
    const Eigen::Index count = result.fitted.terms.size();
    result.fitted.fit.coefficients.resize(count);
    result.fitted.fit.coefficient_std.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const double size = i < result.fitted.terms.fourier_begin()     ? 8e-9
                          : i < result.fitted.terms.spherical_begin() ? 9e-9
                                                                      : 3e-9;
      result.fitted.fit.coefficients[i] = size * random.normal(100 + std::uint64_t(i));
      result.fitted.fit.coefficient_std[i] = 0.4 * size;
    }
    SurfaceOperator(result.fitted.terms, pupil.x, pupil.y).apply(result.fitted.fit.coefficients, &field);
    const double slope =
        std::sqrt(0.5 * (pupil.weight * (field.slope_x.square() + field.slope_y.square())).sum());
    focal_sigma = 2 * kFocalLength * slope;
    result.scene.numbers.rms_slope_per_axis = slope;
    ideal = trace_nominal(mirror, pupil);
    fitted = trace(mirror, pupil, field);
    // The spot is exactly Gaussian at z = f, so its encircled energy is Rayleigh's law. Out of focus it has
    // the geometry of the ideal mirror.
    target = ideal;
    const RandomStream spot(5, "plot-scene-target");
    for (Eigen::Index i = 0; i < target.size(); ++i) {
      const auto [a, b] = spot.normal_pair(std::uint64_t(i));
      target.x[i] += focal_sigma * a;
      target.y[i] += focal_sigma * b;
    }
    result.fitted.targets.clear();
    for (const double fraction : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95})
      result.fitted.targets.push_back(
          {EncircledEnergyRadius{fraction, 0}, focal_sigma * std::sqrt(-2 * std::log1p(-fraction)), 0, 1e-8});
    Eigen::ArrayXd x(kGrid * kGrid), y(kGrid * kGrid);
    for (int j = 0; j < kGrid; ++j) {
      for (int i = 0; i < kGrid; ++i) {
        x[j * kGrid + i] = line(i);
        y[j * kGrid + i] = line(j);
      }
    }
    grid = std::make_unique<SurfaceOperator>(result.fitted.terms, x, y);
  }

  static double line(int i) { return kRadius * (2.0 * i / (kGrid - 1) - 1); }

  std::vector<DrawnPicture> write(const std::string& directory, Warnings* warnings,
                                  const PictureOptions& options = {}) const {
    const auto light = [&](const RayBundle& rays) {
      return rays.size() > 0 ? ray_light(rays, ideal, Centre::kNominal) : nullptr;
    };
    const auto of_ideal = light(ideal), of_target = light(target), of_fitted = light(fitted);
    return draw_pictures(shown(*of_ideal, of_target.get(), *of_fitted), directory, options, warnings);
  }

  FitPictures shown(const FocalLight& of_ideal, const FocalLight* of_target,
                    const FocalLight& of_fitted) const {
    return {result, mirror,   aperture,   kWavelength, psd ? &*psd : nullptr,
            pupil,  of_ideal, of_target,  of_fitted,   field,
            *grid,  kGrid,    focal_sigma};
  }

  Mirror mirror;
  Aperture aperture;
  PupilSample pupil;
  ResultDocument result;
  SurfaceField field;
  RayBundle ideal, target, fitted;
  std::unique_ptr<SurfaceOperator> grid;
  double focal_sigma = 0;
  std::optional<RadialPsd> psd = RadialPsd(PsdModel{UniformPsd{3e-9, 2.5, 1000}});
};

}  // namespace aberfit
