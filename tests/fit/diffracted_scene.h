#pragma once
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/fit/calibrate.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// f/7 parabola of 0.4 m at 632.8 nm, on the points of a diffraction pupil `cells` across. Plane waves sample
/// a PSD of the given g = 4 pi sigma/lambda.
struct DiffractedScene {
  Mirror mirror{2.8, -1, {}};
  Aperture aperture = CircleAperture{0.4};
  double wavelength = 632.8e-9;
  RadialPsd psd;
  DiffractionPupil pupil;
  SurfaceOperator surface;
  CoefficientPrior prior;

  DiffractedScene(const RadialPsd& of_unit_rms, double g, int modes, int cells, int threads = 1)
      : psd(of_unit_rms.scaled(g * wavelength / (4 * std::numbers::pi))),
        pupil(diffraction_pupil(aperture, mirror.focal_length, 0.4 / cells)),
        surface(terms_of(psd, modes), pupil.sample, {threads, {}, {}}),
        prior(make_prior(surface.terms(), psd, CovarianceKind::kFull)) {}

  /// lambda F [m]
  double unit() const { return wavelength * mirror.focal_length / 0.4; }
  FitProblem problem(std::vector<Target> targets, FocusModel model) const {
    return {path(model), prior, std::move(targets), {}, 2 * unit()};
  }
  LightPath path(FocusModel model) const {
    return {mirror, pupil.sample, surface, model, wavelength, &aperture, Centre::kNominal};
  }
  static TermSet terms_of(const RadialPsd& psd, int modes) {
    TermSet terms;
    terms.radius = 0.2;
    // The number of waves is about the area of half the ring over that of a grid cell.
    terms.fourier_pitch =
        std::sqrt(0.5 * std::numbers::pi * (std::pow(psd.f_max(), 2) - std::pow(psd.f_min(), 2)) / modes);
    terms.fourier = fourier_lattice(psd, terms.fourier_pitch);
    return terms;
  }
};

}  // namespace aberfit
