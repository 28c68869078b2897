// What does a surface of given terms do to the focus? This program traces 100 nm RMS of defocus, whose answer
// is known, and then a seeded realisation of a roughness in terms of the same kind.
#include <fmt/format.h>

#include "aberfit/focus/evaluate.h"
#include "aberfit/terms/modal_covariance.h"

namespace {

const aberfit::Mirror kMirror{.focal_length = 2.8};
const aberfit::Aperture kAperture = aberfit::CircleAperture{.diameter = 0.4};

// Prints the radius of 90 % encircled energy and the RMS scatter angle of the mirror plus these terms.
void report(const char* what, const aberfit::TermSet& terms, const Eigen::VectorXd& coefficients) {
  const aberfit::PupilSample pupil =
      aberfit::make_pupil(kAperture, {.layout = aberfit::PupilLayout::kSobol, .rays = 65536});
  aberfit::SurfaceField field;  // height and slopes at the pupil points
  aberfit::SurfaceOperator(terms, pupil.x, pupil.y).apply(coefficients, &field);
  const aberfit::RayBundle nominal = aberfit::trace_nominal(kMirror, pupil);
  const aberfit::RayBundle rays = aberfit::trace(kMirror, pupil, field);

  const Eigen::VectorXd values = aberfit::evaluate_exact(
      {rays, nominal, field.height},
      {aberfit::EncircledEnergyRadius{0.9}, aberfit::ScatterRms{}, aberfit::RmsHeight{}}, /*threads=*/1);
  fmt::print("{}: {} terms, ee90 {:.3f} um, RMS scatter {:.3f} urad, RMS height {:.2f} nm\n", what,
             coefficients.size(), 1e6 * values[0], 1e6 * values[1], 1e9 * values[2]);
}

}  // namespace

int main() {
  aberfit::TermSet terms;
  terms.radius = 0.2;
  terms.zernike = {{2, 0}};
  report("defocus", terms, Eigen::VectorXd::Constant(1, 100e-9));

  const aberfit::RadialPsd psd(aberfit::UniformPsd{.rms = 100e-9, .f_min = 2.5, .f_max = 39.92});
  terms.zernike = aberfit::zernike_modes(2, 55);
  const aberfit::CoefficientPrior prior = aberfit::make_prior(terms, psd, aberfit::CovarianceKind::kFull);
  report("one draw of the roughness", terms, prior.colour(aberfit::draw_white(terms.size(), /*seed=*/1)));
}
