#include "aberfit/forward/term_moments.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/scene/quadrature_pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {
namespace {

constexpr int kDegreesOfTheMirror = 24;

int degree_of_moments(const Aperture& aperture, const TermSet& terms) {
  return 2 * polynomial_order(terms, aperture_radius(aperture)) + kDegreesOfTheMirror;
}

}  // namespace

int polynomial_order(const TermSet& terms, double reach) {
  int order = 0;
  for (const ZernikeMode& mode : terms.zernike) order = std::max(order, mode.n);
  for (const int power : terms.spherical) order = std::max(order, power);
  double highest = 0;
  for (const FourierMode& mode : terms.fourier) highest = std::max(highest, std::hypot(mode.fx, mode.fy));
  if (highest > 0) {
    const double k = kTwoPi * highest * reach;
    order = std::max(order, int(std::min(1e8, std::ceil(k + 6.3 * std::cbrt(k) + 4))));
  }
  return order;
}

std::optional<PupilSample> moment_pupil(const Aperture& aperture, const TermSet& terms) {
  const int degree = degree_of_moments(aperture, terms);
  if (quadrature_points(aperture, degree) > kMostMomentPoints) return std::nullopt;
  return quadrature_pupil(aperture, degree);
}

std::optional<PupilSample> mean_angle_pupil(const Aperture& aperture, const TermSet& terms) {
  // A polygon has as many times the points of a circle, which has one of degree 0, as it has edges.
  const double per_circle = quadrature_points(aperture, 0);
  const int degree = degree_of_moments(aperture, terms);
  for (int finer = int(std::lround(3 / std::sqrt(per_circle))); finer > 1; --finer)
    if (quadrature_points(aperture, finer * degree) <= kMostMomentPoints)
      return quadrature_pupil(aperture, finer * degree);
  return moment_pupil(aperture, terms);
}

std::optional<TermMoments> term_moments(const Aperture& aperture, const TermSet& terms,
                                        const Eigen::VectorXd& coefficients, int threads) {
  const std::optional<PupilSample> pupil = moment_pupil(aperture, terms);
  if (!pupil) return std::nullopt;
  SurfaceField field;
  const TermSet rough = terms.without_segments();
  SurfaceOperator(rough, *pupil, {threads, {}, {}}).apply(coefficients.head(rough.size()), &field);
  return moments_of(field, pupil->weight);
}

TermMoments moments_of(const SurfaceField& field, const Eigen::ArrayXd& weight) {
  const double mean = (weight * field.height).sum();
  return {std::sqrt((weight * (field.height - mean).square()).sum()),
          std::sqrt((weight * (field.slope_x.square() + field.slope_y.square())).sum() / 2)};
}

}  // namespace aberfit
