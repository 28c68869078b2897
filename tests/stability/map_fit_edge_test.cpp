// Least squares of Zernikes on points that do not distinguish them: thin annuli, slim polygons, few points,
// clusters. The truth is the coefficients of the map, with white noise on every point.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "aberfit/core/random.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/scene/zernike.h"
#include "edge.h"

namespace aberfit::test {
namespace {

using Inside = std::function<bool(double, double)>;

constexpr double kNoise = 1e-9;          // [m], white
constexpr double kStandardErrors = 4.5;  // largest of 25 coefficients and as many steps: 1e-3 by chance

TermSet terms_of(int n_max) {
  TermSet terms;
  terms.radius = 1;
  terms.zernike = zernike_modes(2, n_max);
  return terms;
}

HeightMap empty_map(Eigen::Index points, double pitch, double x0, double y0) {
  HeightMap map;
  map.height = Grid::Constant(points, points, std::nan(""));
  map.pitch_x = map.pitch_y = pitch;
  map.x0 = x0, map.y0 = y0;
  return map;
}

struct Judged {
  double error = 0;     // largest error of a coefficient [m]
  double promised = 0;  // by the standard deviations of the result, at most those of the map's RMS [m]
  bool told = false;
  MapFitResult fit;
};

// Fits a map of the terms where `inside`, plus noise. The result promises a number of its own standard
// deviations, plus the rounding of map_design.h: 1e-15 of the coefficients times the condition number.
// Without the warning `not-identified`, it also promises standard deviations below the RMS of the map.
Judged judge(HeightMap map, const TermSet& terms, const Inside& inside) {
  const RandomStream stream(1, "map-fit-edge");
  Eigen::VectorXd truth(terms.size());
  for (Eigen::Index j = 0; j < terms.size(); ++j) truth[j] = 1e-7 * stream.normal(std::uint64_t(j));
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k) {
      if (!inside(map.x(k), map.y(i))) continue;
      double height = kNoise * stream.normal(std::uint64_t(1000 + i * map.columns() + k));
      for (Eigen::Index j = 0; j < terms.size(); ++j)
        height += truth[j] * zernike(terms.zernike[std::size_t(j)], map.x(k), map.y(i)).value;
      map.height(i, k) = height;
    }
  Judged judged;
  judged.fit = fit_map(map, terms);
  const MapFitResult& fit = judged.fit;
  judged.told = fit.status != MapFitResult::Status::kConverged || !fit.warnings.empty();
  judged.error = std::nan("");
  if (fit.coefficients.size() == terms.size()) {
    judged.error = (fit.coefficients - truth).cwiseAbs().maxCoeff();
    judged.promised = kStandardErrors * std::min(fit.coefficient_std.maxCoeff(), fit.rms_map) +
                      1e-14 * fit.condition_number * truth.cwiseAbs().maxCoeff();
  }
  return judged;
}

void add(double parameter, const Judged& judged, Edge* edge) {
  edge->add({parameter, judged.error, judged.promised, judged.told});
}

TEST(StabilityEdge, ZernikesOnThinAnnuli) {
  // On a ring of relative width w the radial functions of one m differ by powers of w.
  Edge edge("map_fit_annulus", "width of the annulus / its radius [1]", "largest coefficient error [m]");
  const TermSet terms = terms_of(8);
  for (const double width : geometric_steps(0.8, 0.02, 14)) {
    const auto inside = [&](double x, double y) {
      const double rho = std::hypot(x, y);
      return rho <= 1 && rho >= 1 - width;
    };
    add(width, judge(empty_map(161, 0.0125, -1, -1), terms, inside), &edge);
  }
  edge.expect();
}

TEST(StabilityEdge, ZernikesOnSlimRectangles) {
  Edge edge("map_fit_rectangle", "width / length of the rectangle [1]", "largest coefficient error [m]");
  const TermSet terms = terms_of(6);
  for (const double width : geometric_steps(1, 1e-3, 13)) {
    // The map always has 41 rows across the rectangle.
    HeightMap map = empty_map(41, 1.4 / 40, -0.7, -0.7 * width);
    map.pitch_y = 1.4 * width / 40;
    add(width, judge(map, terms, [](double, double) { return true; }), &edge);
  }
  edge.expect();
}

TEST(StabilityEdge, ZernikesOnFewPoints) {
  // The fit has 33 terms, piston and tilt; a tenth of the points is held out.
  Edge edge("map_fit_few_points", "points of the map [1]", "largest coefficient error [m]");
  const TermSet terms = terms_of(7);
  const RandomStream stream(3, "few-points");
  for (const double share : geometric_steps(0.3, 0.01, 12)) {
    int points = 0;
    const auto inside = [&](double x, double y) {
      const bool in =
          std::hypot(x, y) <= 1 &&
          stream.uniform(std::uint64_t(1000 * std::lround(50 * (x + 1)) + std::lround(50 * (y + 1)))) < share;
      points += in;
      return in;
    };
    const Judged judged = judge(empty_map(61, 2.0 / 60, -1, -1), terms, inside);
    add(points, judged, &edge);
  }
  edge.expect();
}

TEST(StabilityEdge, ZernikesOnClusteredPoints) {
  // All points in a patch about the axis: a term of order n is known through patch^n of its height.
  Edge edge("map_fit_cluster", "radius of the sampled patch / radius of the terms [1]",
            "largest coefficient error [m]");
  const TermSet terms = terms_of(6);
  for (const double patch : geometric_steps(1, 1e-3, 13))
    add(patch,
        judge(empty_map(31, patch / 15, -patch, -patch), terms,
              [&](double x, double y) { return std::hypot(x, y) <= patch; }),
        &edge);
  // The noise of 700 points hides what patch^6 leaves of the highest order.
  edge.follows(
      {"noise / patch^6", [](double patch) { return 0.6 * kNoise * std::pow(patch, -6); }, 0.03, 0.6, 2});
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
