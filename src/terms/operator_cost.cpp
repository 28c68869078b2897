#include "aberfit/terms/operator_cost.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/instruction_set.h"
#include "grid_kernel.h"
#include "polar_kernel.h"
#include "zernike_kernel.h"

namespace aberfit {
using namespace internal;

namespace {

using Eigen::Index;

constexpr OperatorSeconds kImpossible{kInfinity, kInfinity};

/// Nanoseconds of the forward and of the adjoint product.
struct Nanoseconds {
  double forward, adjoint;
};

/// To be measured anew with tests/benchmarks/operator_benchmark; figures in surface_operator.cpp. AVX-512:
/// all measured, rows there are 0.6 to 1.4 times what they predict. AVX2 and baseline: the pointwise methods
/// measured, the others scaled from AVX-512 by the number of lanes.
struct Constants {
  Nanoseconds fused_point, fused_order, fused_row;  // per point; and azimuthal order m; and row (n, |m|)
  Nanoseconds polar_row;                            // per ring and row
  Nanoseconds polar_order;                          // per ring and order
  Nanoseconds phase;                                // per point and mode
  Nanoseconds grid;                                 // per place of the grid and mode
  Nanoseconds grid_table;                           // per mode and row or column of a tile
  Nanoseconds dense_near, dense_far;                // per point and term, basis in and beyond the cache
  Nanoseconds spherical;                            // per point and term
};

Constants constants(InstructionSet set) {
  switch (set) {
    case InstructionSet::kAvx512:
      return {.fused_point = {3.0, 4.0},
              .fused_order = {0.35, 0.45},
              .fused_row = {0.155, 0.19},
              .polar_row = {0.16, 0.42},
              .polar_order = {6.0, 6.0},
              .phase = {0.60, 0.62},
              .grid = {0.13, 0.125},
              .grid_table = {0.5, 0.5},
              .dense_near = {0.16, 0.27},
              .dense_far = {2.0, 2.0},
              .spherical = {1.0, 1.0}};
    case InstructionSet::kAvx2:
      return {.fused_point = {4.0, 5.0},
              .fused_order = {0.6, 0.8},
              .fused_row = {0.36, 0.42},
              .polar_row = {0.38, 0.6},
              .polar_order = {7.0, 7.0},
              .phase = {1.0, 1.0},
              .grid = {0.3, 0.3},
              .grid_table = {1.0, 1.0},
              .dense_near = {0.4, 0.4},
              .dense_far = {2.0, 2.0},
              .spherical = {1.0, 1.0}};
    case InstructionSet::kBaseline:
      break;
  }
  return {.fused_point = {6.0, 8.0},
          .fused_order = {1.5, 2.0},
          .fused_row = {1.0, 0.95},
          .polar_row = {1.0, 1.2},
          .polar_order = {9.0, 9.0},
          .phase = {3.3, 3.3},
          .grid = {1.2, 1.2},
          .grid_table = {3.0, 3.0},
          .dense_near = {1.0, 1.0},
          .dense_far = {2.0, 2.0},
          .spherical = {1.0, 1.0}};
}

// FFTW has its own vector code, so these do not depend on the instruction set: per point of a ring, beside
// what log2 of its length costs.
constexpr Nanoseconds kPolarPoint{1.0, 1.0}, kTransform{0.22, 0.22};
// Lengths with a prime factor that FFTW has no code for cost this much more.
constexpr double kLargePrime = 10.0;
constexpr int kLargestCodedPrime = 13;
constexpr double kScatter = 2.0;      // per point: clearing the field and putting listed weights into it
constexpr double kNearBytes = 1.5e6;  // what a second-level cache holds

OperatorSeconds& operator+=(OperatorSeconds& sum, const OperatorSeconds& more) {
  sum.forward += more.forward;
  sum.adjoint += more.adjoint;
  return sum;
}
OperatorSeconds times(double count, const Nanoseconds& each) {
  return {1e-9 * count * each.forward, 1e-9 * count * each.adjoint};
}
double round_up(Index count, int unit) { return double((count + unit - 1) / unit * unit); }

Index largest_prime_factor(Index n) {
  Index largest = 1;
  for (Index p = 2; p * p <= n; ++p)
    for (; n % p == 0; n /= p) largest = p;
  return std::max(largest, n);
}

OperatorSeconds dense_seconds(double terms, double points) {
  if (24 * terms * points > kDenseBytesMax) return kImpossible;
  const Constants c = constants(best_instruction_set());
  return times(points * terms, 24 * terms * points > kNearBytes ? c.dense_far : c.dense_near);
}

Index rays_from(const OperatorSeconds& whole, const OperatorSeconds& point_by_point, Index points) {
  const double scattered = whole.adjoint + 1e-9 * kScatter * double(points);
  const double per_ray = point_by_point.adjoint / double(points);
  return per_ray > 0 ? Index(std::min(std::ceil(scattered / per_ray), double(points) + 1)) : 0;
}

template <typename Method>
Method cheapest(std::initializer_list<Method> methods, const TermSet& terms, const PointLayout& layout) {
  Method best = *methods.begin();
  double least = kInfinity;
  for (const Method method : methods) {
    const OperatorSeconds seconds = predicted_seconds(method, terms, layout);
    if (seconds.forward + seconds.adjoint < least) best = method, least = seconds.forward + seconds.adjoint;
  }
  return best;
}

void check_dense(double terms, Index points) {
  const double bytes = 24 * terms * double(points);
  if (bytes > kDenseBytesMax)
    throw std::invalid_argument(fmt::format(
        "SurfaceOperator: a stored basis of {} terms at {} points takes {:.3g} GB, allowed are {:.3g} GB",
        terms, points, bytes / 1e9, kDenseBytesMax / 1e9));
}

void check_named(const TermSet& terms, const PointLayout& layout, const OperatorOptions& options) {
  if (!terms.zernike.empty() && options.zernike == ZernikeMethod::kPolar && layout.rings == 0)
    throw std::invalid_argument("SurfaceOperator: the polar method needs points on rings (a polar pupil)");
  if (!terms.fourier.empty() && options.fourier == FourierMethod::kGrid && layout.rows == 0)
    throw std::invalid_argument("SurfaceOperator: the grid method needs points on a Cartesian grid");
  if (options.zernike == ZernikeMethod::kDense) check_dense(double(terms.zernike.size()), layout.points);
  if (options.fourier == FourierMethod::kDense)
    check_dense(2.0 * double(terms.fourier.size()), layout.points);
}

const char* arrangement(const PointLayout& layout) {
  return layout.rings > 0 ? "points on rings" : layout.rows > 0 ? "points on a grid" : "scattered points";
}

}  // namespace

PointLayout point_layout(const PupilSample& pupil) {
  PointLayout layout;
  layout.points = pupil.size();
  if (const auto* rings = std::get_if<PolarRings>(&pupil.structure)) {
    layout.rings = rings->rho.size();
    layout.spokes = rings->spokes;
  } else if (const auto* grid = std::get_if<CartesianGrid>(&pupil.structure)) {
    layout.rows = grid->y.size();
    layout.columns = grid->x.size();
  }
  return layout;
}

OperatorSeconds predicted_seconds(ZernikeMethod method, const TermSet& terms, const PointLayout& layout) {
  if (terms.zernike.empty()) return {};
  const Constants c = constants(best_instruction_set());
  const ZernikeRows zernike = zernike_rows(terms.zernike);
  const double points = double(layout.points), rows = double(zernike.rows()), orders = zernike.m_max() + 1.0;
  if (method == ZernikeMethod::kDense) return dense_seconds(double(terms.zernike.size()), points);
  if (method == ZernikeMethod::kFused) {
    OperatorSeconds sum = times(points, c.fused_point);
    sum += times(points * orders, c.fused_order);
    return sum += times(points * rows, c.fused_row);
  }
  if (layout.rings == 0) return kImpossible;
  OperatorSeconds sum = times(round_up(layout.rings, kBlockRings) * rows, c.polar_row);
  sum += times(double(layout.rings) * orders, c.polar_order);
  sum += times(points, kPolarPoint);
  const bool slow = largest_prime_factor(layout.spokes) > kLargestCodedPrime;
  return sum += times(points * std::log2(double(layout.spokes)) * (slow ? kLargePrime : 1.0), kTransform);
}

OperatorSeconds predicted_seconds(FourierMethod method, const TermSet& terms, const PointLayout& layout) {
  if (terms.fourier.empty()) return {};
  const Constants c = constants(best_instruction_set());
  const double points = double(layout.points), modes = double(terms.fourier.size());
  if (method == FourierMethod::kDense) return dense_seconds(2 * modes, points);
  if (method == FourierMethod::kPhaseSums) return times(points * modes, c.phase);
  if (layout.rows == 0) return kImpossible;
  // Points leave part of the grid's corners out, columns come in groups.
  const double places = std::min(double(layout.rows * layout.columns), points + 16.0 * double(layout.rows));
  const double tiles =
      std::ceil(double(layout.rows) / kTileRows) * std::ceil(double(layout.columns) / kTileColumns);
  const double edges = tiles * (std::min<double>(double(layout.rows), kTileRows) +
                                std::min<double>(double(layout.columns), kTileColumns));
  OperatorSeconds sum = times(places * modes, c.grid);
  return sum += times(edges * modes, c.grid_table);
}

OperatorSeconds predicted_seconds(const OperatorChoice& choice, const TermSet& terms,
                                  const PointLayout& layout) {
  OperatorSeconds sum = times(double(layout.points) * double(terms.spherical.size()),
                              constants(best_instruction_set()).spherical);
  if (choice.zernike) sum += predicted_seconds(*choice.zernike, terms, layout);
  if (choice.fourier) sum += predicted_seconds(*choice.fourier, terms, layout);
  return sum;
}

OperatorChoice choose_operator(const TermSet& terms, const PointLayout& layout,
                               const OperatorOptions& options) {
  check_named(terms, layout, options);
  OperatorChoice choice;
  std::string methods;
  if (!terms.zernike.empty()) {
    choice.zernike = options.zernike
                         ? *options.zernike
                         : cheapest({ZernikeMethod::kFused, ZernikeMethod::kPolar}, terms, layout);
    methods += fmt::format("{} Zernike terms {} ({})", terms.zernike.size(), to_string(*choice.zernike),
                           options.zernike ? "as asked for" : "least predicted time");
  }
  if (!terms.fourier.empty()) {
    choice.fourier = options.fourier
                         ? *options.fourier
                         : cheapest({FourierMethod::kPhaseSums, FourierMethod::kGrid}, terms, layout);
    methods +=
        fmt::format("{}{} Fourier modes {} ({})", methods.empty() ? "" : ", ", terms.fourier.size(),
                    to_string(*choice.fourier), options.fourier ? "as asked for" : "least predicted time");
  }
  const OperatorSeconds seconds = predicted_seconds(choice, terms, layout);
  choice.forward_seconds = seconds.forward;
  choice.adjoint_seconds = seconds.adjoint;
  choice.reason =
      fmt::format("{} {}{}{}", layout.points, arrangement(layout), methods.empty() ? "" : ": ", methods);
  return choice;
}

OperatorChoice choose_operator(const TermSet& terms, const PupilSample& pupil,
                               const OperatorOptions& options) {
  return choose_operator(terms, point_layout(pupil), options);
}

Index enough_rays(ZernikeMethod method, const TermSet& terms, const PointLayout& layout) {
  return rays_from(predicted_seconds(method, terms, layout),
                   predicted_seconds(ZernikeMethod::kFused, terms, layout), layout.points);
}

Index enough_rays(FourierMethod method, const TermSet& terms, const PointLayout& layout) {
  return rays_from(predicted_seconds(method, terms, layout),
                   predicted_seconds(FourierMethod::kPhaseSums, terms, layout), layout.points);
}

}  // namespace aberfit
