#include "aberfit/trace/nominal_surface.h"

namespace aberfit {

SurfaceField known_zernike_field(const Mirror& mirror, const PupilSample& pupil,
                                 const OperatorOptions& options) {
  SurfaceField field;
  if (mirror.zernike.empty()) return field;
  TermSet terms;
  terms.radius = mirror.zernike_radius;
  Eigen::VectorXd heights(Eigen::Index(mirror.zernike.size()));
  for (const KnownZernike& term : mirror.zernike) {
    heights[Eigen::Index(terms.zernike.size())] = term.height;
    terms.zernike.push_back(term.mode);
  }
  SurfaceOperator(std::move(terms), pupil, options).apply(heights, &field);
  return field;
}

Eigen::ArrayXd departure_from_parabola(const Mirror& mirror, const PupilSample& pupil,
                                       const OperatorOptions& options) {
  if (is_parabola(mirror)) return {};
  const Mirror of_revolution = without_known_zernikes(mirror);
  Eigen::ArrayXd departure = Eigen::ArrayXd::Zero(pupil.size());
  if (!is_parabola(of_revolution))
    for (Eigen::Index i = 0; i < pupil.size(); ++i) {
      const double x = pupil.x[i], y = pupil.y[i];
      departure[i] = base_surface(of_revolution, x, y).height - (x * x + y * y) / (4 * mirror.focal_length);
    }
  if (!mirror.zernike.empty()) departure += known_zernike_field(mirror, pupil, options).height;
  return departure;
}

}  // namespace aberfit
