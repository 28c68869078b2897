#include "aberfit/fit/map_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/random.h"
#include "aberfit/core/units.h"
#include "aberfit/terms/surface_operator.h"
#include "area_weights.h"
#include "independent_points.h"
#include "map_design.h"

namespace aberfit {
using namespace internal;

namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

// Most terms of a dense triangle: 18 MB and some seconds for the singular values.
constexpr Index kDenseTerms = 1500;
constexpr double kRimRounding = 1e-9;  // tolerance of a circle through points

void check(const HeightMap& map, const MapFitOptions& options) {
  if (!(map.pitch_x > 0) || !(map.pitch_y > 0))
    throw std::invalid_argument("fit_map: the map has no pitch, so the positions of its points are unknown");
  if (!(options.held_out >= 0 && options.held_out < 1))
    throw std::invalid_argument(fmt::format("fit_map: held_out is {}, must be in [0, 1)", options.held_out));
}

// Points of the map with their index in the grid, fitted and held out.
struct ChosenPoints {
  MapPoints fitted, held_out;
  std::vector<Index> fitted_index;
  double largest_distance = 0;
};

MapPoints gather(const HeightMap& map, const std::vector<Index>& index) {
  const Index count = Index(index.size());
  MapPoints points{ArrayXd(count), ArrayXd(count), ArrayXd(count), ArrayXd::Ones(count)};
  for (Index i = 0; i < count; ++i) {
    const Index at = index[std::size_t(i)];
    points.x[i] = map.x(at % map.columns());
    points.y[i] = map.y(at / map.columns());
    points.height[i] = map.height.data()[at];
  }
  return points;
}

ChosenPoints choose(const HeightMap& map, double radius, const MapFitOptions& options) {
  const RandomStream stream(options.seed, "map-fit-held-out");
  ChosenPoints chosen;
  std::vector<Index> held_out, known;  // known: all points that the fit may use, also beyond the radius
  for (Index at = 0; at < map.height.size(); ++at) {
    if (!std::isfinite(map.height.data()[at])) continue;
    const bool kept_back = stream.uniform(std::uint64_t(at)) < options.held_out;
    if (!kept_back) known.push_back(at);
    const double distance = std::hypot(map.x(at % map.columns()), map.y(at / map.columns()));
    if (radius > 0 && distance > radius * (1 + kRimRounding)) continue;
    chosen.largest_distance = std::max(chosen.largest_distance, distance);
    (kept_back ? held_out : chosen.fitted_index).push_back(at);
  }
  chosen.fitted = gather(map, chosen.fitted_index);
  if (options.weighting == MapWeighting::kArea && !chosen.fitted_index.empty())
    chosen.fitted.root_weight = area_weights(map, known, chosen.fitted_index).sqrt();
  chosen.held_out = gather(map, held_out);
  return chosen;
}

// The terms with the piston and tilt they lack, appended to the Zernikes.
struct JointTerms {
  TermSet terms;
  std::vector<bool> added;       // per term
  std::vector<Index> requested;  // indices of the caller's terms
};

JointTerms join(const TermSet& terms, double largest_distance) {
  JointTerms joint{terms, {}, {}};
  // Plane waves need no radius, but the added tilt does: any length of the map's size.
  if (!(joint.terms.radius > 0) && terms.zernike.empty() && terms.spherical.empty())
    joint.terms.radius = largest_distance > 0 ? largest_distance : 1;
  for (const ZernikeMode mode : {ZernikeMode{0, 0}, ZernikeMode{1, -1}, ZernikeMode{1, 1}})
    if (std::find(terms.zernike.begin(), terms.zernike.end(), mode) == terms.zernike.end())
      joint.terms.zernike.push_back(mode);
  joint.added.assign(std::size_t(joint.terms.size()), false);
  for (Index j = 0; j < joint.terms.size(); ++j) {
    const bool added = j >= terms.fourier_begin() && j < joint.terms.fourier_begin();
    joint.added[std::size_t(j)] = added;
    if (!added) joint.requested.push_back(j);
  }
  return joint;
}

// The Zernike modes next beyond the terms: the fewest whole orders with kModes of them, fewer where the
// points are few. A plane wave of f cycles/m has orders up to 2 pi f radius on the disc.
TermSet next_orders(const TermSet& terms, Index points) {
  constexpr std::size_t kModes = 40;  // gives their mean square to 22 %, a standard deviation to 11 %
  double order = 1;
  for (const ZernikeMode& mode : terms.zernike) order = std::max(order, double(mode.n));
  for (const FourierMode& mode : terms.fourier)
    order = std::max(order, std::ceil(2 * kPi * std::hypot(mode.fx, mode.fy) * terms.radius));
  for (const int power : terms.spherical) order = std::max(order, double(power));
  TermSet next;
  next.radius = terms.radius;
  for (int n = int(order) + 1; next.zernike.size() < kModes; ++n) {
    if (terms.size() + next.size() + n + 1 >= points) break;
    const std::vector<ZernikeMode> modes = zernike_modes(n, n);
    next.zernike.insert(next.zernike.end(), modes.begin(), modes.end());
  }
  return next;
}

double rms(const ArrayXd& values) { return values.size() > 0 ? std::sqrt(values.square().mean()) : 0.0; }

// rho^p is a sum of the m = 0 Zernikes up to n = p; the piston is always in the fit.
bool overlaps_m0(const TermSet& terms) {
  const auto has = [&](int n) {
    return std::find(terms.zernike.begin(), terms.zernike.end(), ZernikeMode{n, 0}) != terms.zernike.end();
  };
  return std::any_of(terms.spherical.begin(), terms.spherical.end(), [&](int power) {
    for (int n = 2; n <= power; n += 2)
      if (!has(n)) return false;
    return true;
  });
}

// The orthonormal modes 1, 2 rho cos, 2 rho sin that the caller did not request.
MapPlane plane_of(const JointTerms& joint, const VectorXd& coefficients) {
  MapPlane plane;
  for (std::size_t i = 0; i < joint.terms.zernike.size(); ++i) {
    if (!joint.added[i]) continue;
    const ZernikeMode mode = joint.terms.zernike[i];
    const double value = coefficients[Index(i)], slope = 2 * value / joint.terms.radius;
    (mode.n == 0 ? plane.height : mode.m > 0 ? plane.slope_x : plane.slope_y) = mode.n == 0 ? value : slope;
  }
  return plane;
}

ArrayXd residual_at(const TermSet& terms, const VectorXd& coefficients, const MapPoints& points,
                    int threads) {
  SurfaceField field;
  SurfaceOperator(terms, points.x, points.y, threads).apply(coefficients, &field);
  return points.height - field.height;
}

// Warns where the points hardly separate the terms: the standard deviation of a coefficient (RMS over the
// disc) exceeds the map itself. Noise alone stays far below, because many points average it.
void warn_of_unknown_terms(MapFitResult* result) {
  const double largest = result->coefficient_std.size() > 0 ? result->coefficient_std.maxCoeff() : 0;
  if (largest <= result->rms_map) return;
  const Index unknown = (result->coefficient_std.array() > result->rms_map).count();
  result->warnings.push_back(
      {"not-identified",
       fmt::format("{} of {} terms have standard deviations up to {:.3g} m, more than the map's RMS of "
                   "{:.3g} m. Its points can hardly distinguish them (condition number {:.3g}); fit fewer "
                   "terms, or a radius that the points fill",
                   unknown, result->coefficient_std.size(), largest, result->rms_map,
                   result->condition_number)});
}

// The residual beyond the terms: a density, and components that stand out of it. The latter are figure that
// the terms leave, such as one aberration of the next order.
struct Beyond {
  double density = 0;  // mean square of the other components [m^2]
  VectorXd figure;     // the components that stand out, zero elsewhere [m]
};

Beyond split_beyond(const VectorXd& components) {
  constexpr double kStandsOut = 4;  // standard deviations; 40 Gaussians exceed it in one of 400 maps
  constexpr double kMedianOfSquares = 0.4549;  // median of squared Gaussian numbers over their variance
  VectorXd squares = components.cwiseAbs2();
  std::sort(squares.begin(), squares.end());
  Beyond beyond;
  beyond.density = squares[squares.size() / 2] / kMedianOfSquares;
  const auto most = [&] { return kStandsOut * kStandsOut * beyond.density; };
  for (Index kept = 0, before = -1; kept != before;) {
    before = kept;
    kept = std::upper_bound(squares.begin(), squares.end(), most()) - squares.begin();
    if (kept > 0) beyond.density = squares.head(kept).mean();
  }
  beyond.figure = (components.array().square() > most()).select(components, 0.0);
  return beyond;
}

// Standard deviations from the residual just beyond the terms (see fit_map). With too few points, the whole
// residual is used.
void fill_uncertainty(const HeightMap& map, const ChosenPoints& points, const ArrayXd& residual,
                      const JointTerms& joint, const MapSolution& solution, int threads,
                      MapFitResult* result) {
  Grid grid = Grid::Zero(map.rows(), map.columns());
  for (Index i = 0; i < residual.size(); ++i) grid.data()[points.fitted_index[std::size_t(i)]] = residual[i];
  const double neighbours = correlated_neighbours(grid, map.pitch_x, map.pitch_y, threads);
  result->independent_points = double(residual.size()) / neighbours;
  // The fit removes `rank` of the independent residuals.
  double left = result->independent_points - double(solution.rank);
  if (left < 1) {
    left = 1;
    result->warnings.push_back({"few-independent-points",
                                fmt::format("the residuals are worth {:.3g} independent points, no more than "
                                            "the {} fitted terms, so the standard deviations are rough",
                                            result->independent_points, result->rank)});
  }
  Beyond beyond{residual.square().sum() / left, {}};
  if (solution.beyond.size() > 0) beyond = split_beyond(solution.beyond);
  const Index count = Index(joint.requested.size());
  if (solution.root.size() == 0) {
    result->coefficient_std =
        std::sqrt(beyond.density) * solution.column_norm(joint.requested).cwiseInverse();
    return;
  }
  const Eigen::MatrixXd root = solution.root(joint.requested, Eigen::all);
  result->covariance = Eigen::MatrixXd::Zero(count, count);
  result->covariance.selfadjointView<Eigen::Lower>().rankUpdate(root, beyond.density);
  // The terms contain part of the figure that they leave, where the points do not separate the two. Its size
  // is known and counts as a standard deviation.
  if (beyond.figure.size() > 0)
    result->covariance.selfadjointView<Eigen::Lower>().rankUpdate(
        VectorXd(solution.leak(joint.requested, Eigen::all) * beyond.figure));
  result->covariance.triangularView<Eigen::StrictlyUpper>() = result->covariance.transpose();
  result->coefficient_std = result->covariance.diagonal().cwiseSqrt();
}

void fill_status(const TermSet& terms, const JointTerms& joint, const MapSolution& solution,
                 MapFitResult* result) {
  const int added = int(joint.terms.size() - terms.size());
  result->rank = std::max(0, solution.rank - added);
  result->condition_number = solution.condition_number;
  if (!solution.converged || !result->coefficients.allFinite()) {
    result->status = MapFitResult::Status::kFailed;
    result->message = "the solution did not settle, because the terms are nearly dependent on this mask";
    return;
  }
  if (solution.rank == joint.terms.size()) {
    result->status = MapFitResult::Status::kConverged;
    result->message = fmt::format("{} terms from {} points, condition number {:.3g}", terms.size(),
                                  result->points, result->condition_number);
    return;
  }
  result->status = MapFitResult::Status::kRankDeficient;
  result->message =
      fmt::format("the points determine only {} of {} terms; the solution of least norm is given",
                  result->rank, terms.size());
  if (overlaps_m0(terms))
    result->warnings.push_back({"m0-overlap",
                                "spherical powers are sums of the m = 0 Zernikes fitted with them; the "
                                "division of the height between the two is a convention (least norm)"});
}

}  // namespace

MapFitResult fit_map(const HeightMap& map, const TermSet& terms, const MapFitOptions& options) {
  check(map, options);
  MapFitResult result;
  const ChosenPoints points = choose(map, terms.radius, options);
  result.points = points.fitted.size();
  result.held_out_points = points.held_out.size();
  if (result.points == 0 || terms.size() == 0) {
    result.status = MapFitResult::Status::kFailed;
    result.message = terms.size() == 0 ? "there are no terms to fit"
                                       : "no valid point of the map lies within the radius of the terms";
    return result;
  }
  ArrayXd all(result.points + result.held_out_points);
  all << points.fitted.height, points.held_out.height;
  result.rms_map = rms(all - all.mean());

  const JointTerms joint = join(terms, points.largest_distance);
  const bool dense = joint.terms.size() <= kDenseTerms;
  const TermSet next = next_orders(joint.terms, result.points);
  const MapSolution solution =
      dense ? solve_by_qr(joint.terms, next, points.fitted, joint.added, options.threads)
            : solve_by_conjugate_gradients(joint.terms, next, points.fitted, options.threads);
  if (!dense)
    result.warnings.push_back(
        {"iterative-solution",
         fmt::format("{} terms are too many for a dense solution. Standard deviations are those of terms "
                     "orthogonal on the mask (a lower bound); there is no covariance and no rank",
                     terms.size())});
  result.coefficients = solution.coefficients(joint.requested);
  result.mount = plane_of(joint, solution.coefficients);
  const ArrayXd residual = residual_at(joint.terms, solution.coefficients, points.fitted, options.threads);
  result.rms_residual = rms(residual);
  result.rms_held_out =
      rms(residual_at(joint.terms, solution.coefficients, points.held_out, options.threads));
  fill_status(terms, joint, solution, &result);
  if (result.status != MapFitResult::Status::kFailed) {
    fill_uncertainty(map, points, residual, joint, solution, options.threads, &result);
    warn_of_unknown_terms(&result);
  }
  return result;
}

}  // namespace aberfit
