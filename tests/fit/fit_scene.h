#pragma once
#include <cmath>

#include "aberfit/fit/calibrate.h"

namespace aberfit {

/// A small scene for fits: f/7 parabola, Zernikes n = 2..n_max and the given spherical powers, prior from a
/// uniform PSD of 100 nm over a band [cycles/m].
struct FitScene {
  Mirror mirror;
  PupilSample pupil;
  TermSet terms;
  SurfaceOperator surface;
  CoefficientPrior prior;
  double focal_sigma;

  FitScene(int n_max, std::vector<int> spherical, std::int64_t rays, PupilLayout layout, double scale = 1.0,
           double f_min = 0.5, double f_max = 5)
      : mirror(parabola()),
        pupil(make_pupil(CircleAperture{0.4, 0}, {layout, rays, 1})),
        terms(make_terms(n_max, std::move(spherical))),
        surface(terms, pupil.x, pupil.y, 1),
        prior(prior_of(terms, scale, f_min, f_max)) {
    // Scale of the spot: RMS radius of a realisation over sqrt 2.
    SurfaceField field;
    surface.apply(prior.colour(draw_white(prior.size(), 1)), &field);
    const RayBundle rays_of_draw = trace(mirror, pupil, field);
    focal_sigma = std::sqrt((pupil.weight * (rays_of_draw.x.square() + rays_of_draw.y.square())).sum() / 2);
  }

  FitProblem problem(std::vector<Target> targets) const {
    return {{mirror, pupil, surface}, prior, std::move(targets), {}, focal_sigma};
  }

 private:
  static Mirror parabola() {
    Mirror mirror;
    mirror.focal_length = 2.8;
    return mirror;
  }
  static TermSet make_terms(int n_max, std::vector<int> spherical) {
    TermSet terms;
    terms.radius = 0.2;
    if (n_max >= 2) terms.zernike = zernike_modes(2, n_max);
    terms.spherical = std::move(spherical);
    return terms;
  }
  static CoefficientPrior prior_of(const TermSet& all, double scale, double f_min, double f_max) {
    TermSet zernike = all;
    zernike.spherical.clear();
    std::vector<CoefficientPrior::Block> blocks;
    const RadialPsd psd(UniformPsd{100e-9 * scale, f_min, f_max});
    if (zernike.size() > 0) blocks = make_prior(zernike, psd, CovarianceKind::kFull).blocks();
    if (!all.spherical.empty()) blocks.push_back(spherical_prior_block(all, 50e-9 * scale));
    return CoefficientPrior(all.size(), std::move(blocks));
  }
};

}  // namespace aberfit
