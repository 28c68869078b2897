#include "aberfit/trace/central_difference.h"

namespace aberfit {
namespace {

// Sag of mirror plus terms at the pupil points shifted by (dx, dy).
Eigen::ArrayXd moved_sag(const Mirror& mirror, const PupilSample& pupil, const TermSet& terms,
                         const Eigen::VectorXd& coefficients, double dx, double dy, int threads) {
  const Eigen::ArrayXd x = pupil.x + dx, y = pupil.y + dy;
  SurfaceField field;
  SurfaceOperator(terms, x, y, threads).apply(coefficients, &field);
  Eigen::ArrayXd sag(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i)
    sag[i] = base_surface(mirror, x[i], y[i]).height + field.height[i];
  return sag;
}

}  // namespace

SurfaceField central_difference_field(const Mirror& mirror, const PupilSample& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients, double step, int threads) {
  SurfaceField field;
  SurfaceOperator(terms, pupil.x, pupil.y, threads).apply(coefficients, &field);
  const auto sag = [&](double dx, double dy) {
    return moved_sag(mirror, pupil, terms, coefficients, dx, dy, threads);
  };
  field.slope_x = (sag(step, 0) - sag(-step, 0)) / (2 * step);
  field.slope_y = (sag(0, step) - sag(0, -step)) / (2 * step);
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const SurfacePoint<double> base = base_surface(mirror, pupil.x[i], pupil.y[i]);
    field.slope_x[i] -= base.slope_x;
    field.slope_y[i] -= base.slope_y;
  }
  return field;
}

}  // namespace aberfit
