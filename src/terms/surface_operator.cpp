// Method. L is a sum of parts (term_operator.h), one for each family of terms or for several families:
//   pointwise_operator.h  any points: Zernike recurrences (kFused), Fourier phase sums, spherical powers
//   zernike_polar.h       Zernike terms on rings (kPolar): radial sums, then transforms over the angle
//   fourier_lattice.h     Fourier terms on a lattice (kLattice): a nonuniform fast Fourier transform
//   segment_terms.h       pistons and tilts of segments, each point in one of them
// The pointwise part always exists. It handles small sets of rays, and tests compare the others with it.
//
// Error of one Zernike mode against its factorial sum in 200 digits, relative to its largest value (gradient)
// over the disc (tests/terms/zernike_test.cpp): 4e-14 to n = 40, 2.5e-13 at n = 100, 2.2e-12 at n = 300. This
// is the error at the rim, where rounding of tau costs about n^2 eps / 16; between 0.1 and 0.9 of the radius
// it is below 7e-15.
//
// Speed in 1e9 term-points (Fourier: mode-points, with two terms per mode) per second, for value and gradient
// on one thread of a Xeon server core (AVX-512, two multiply-add units). Release build, 65536 points (8192 at
// n = 300), median of at least 15 runs, quartiles within 5 %. The same core also ran the AVX2 and SSE2
// kernels:
//                     AVX-512            AVX2               SSE2
//                     forward  adjoint   forward  adjoint   forward  adjoint
//     n =   8,    45     4.5      3.5       3.0      2.3       1.4      1.2
//     n =  20,   231     8.2      6.8       4.8      3.9       1.7      1.7
//     n =  40,   861    10.4      9.1       5.7      4.8       1.9      1.9
//     n = 300, 45451    12.7     11.4       5.3      4.7       2.0      2.1
//     400 modes          1.7      1.6       1.0      1.0       0.3      0.3
//
// The other methods on the same core with AVX-512, in nanoseconds per point, forward and adjoint; smallest of
// many runs on a busy machine. The last column of kPolar is the largest difference from kFused relative to
// the largest slope:
//     kPolar            10,000 points     65,536 points     1,000,000 points
//     n =   8,    42     3.7   3.7         4.4   4.2         4.5   3.5          6e-15
//     n =  20,   228     4.0   4.3         4.6   4.6         4.5   3.6          3e-14
//     n =  40,   858     4.4   5.7         5.0   5.4         4.4   3.7          8e-14
//     n =  60,  1888     6.0   7.8         5.8   6.0         4.7   3.9          2e-13
//     n =  80,  3318     7.4   9.9         6.2   6.7         5.1   4.1          3e-13
//     n = 137,  9588    11    18           7.9  11           5.5   5.5          8e-13
// Transforms dominate: they take twice as long at 544 = 32 17 spokes and five times as long at 536 = 8 67,
// because FFTW has no code for these primes. With few rings and many terms (n = 137) the radial sums add to
// this, and in the adjoint the sums over lanes after each 16 rings.
//     kPhaseSums 1.7 and 1.6 1e9 mode-points/s (20,000 modes, 15,000 points).
//     kLattice, milliseconds at 51,468 points: 10,080 coefficients 3.5 and 5.9, 150 weights of heights at
//     once 220; 71,288 coefficients 13 and 15, 640.
#include "aberfit/terms/surface_operator.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "aberfit/terms/operator_cost.h"
#include "fourier_lattice.h"
#include "height_products.h"
#include "pointwise_operator.h"
#include "segment_terms.h"
#include "zernike_polar.h"

namespace aberfit {
using namespace internal;

namespace {

using Eigen::Index;

void check(const TermSet& terms, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  if (x.size() != y.size())
    throw std::invalid_argument(
        fmt::format("SurfaceOperator: {} x but {} y coordinates", x.size(), y.size()));
  const bool on_disc = !terms.zernike.empty() || !terms.spherical.empty();
  if (on_disc && !(terms.radius > 0 && std::isfinite(terms.radius)))
    throw std::invalid_argument(fmt::format("SurfaceOperator: radius {} m, must be positive", terms.radius));
  for (const int power : terms.spherical)
    if (power < 2 || power % 2 != 0)
      throw std::invalid_argument(
          fmt::format("SurfaceOperator: spherical power {}, must be even and positive", power));
}

bool well_formed(const PolarRings& rings, Index points) {
  return rings.spokes > 0 && rings.turn.size() == rings.rho.size() &&
         rings.rho.size() * rings.spokes == points;
}

bool well_formed(const CartesianGrid& grid, Index points) {
  if (Index(grid.column.size()) != points || Index(grid.row.size()) != points) return false;
  for (std::size_t i = 0; i < grid.column.size(); ++i)
    if (Index(grid.column[i]) >= grid.x.size() || Index(grid.row[i]) >= grid.y.size()) return false;
  return true;
}

/// Throws unless the structure, if there is one, gives the points of the pupil to 1e-12 of the farthest one.
/// The tolerance is needed because angles of many turns and products of cosines round differently.
void check_structure(const PupilSample& pupil) {
  const auto matches = [&pupil](const auto& structure) {
    if (!well_formed(structure, pupil.size())) return false;
    const PointCoordinates points(structure);
    const double tolerance = 1e-12 * std::max(pupil.x.abs().maxCoeff(), pupil.y.abs().maxCoeff());
    PointBlock block;
    for (Index at = 0; at < pupil.size(); at += kBlockPoints) {
      const int used = int(std::min<Index>(kBlockPoints, pupil.size() - at));
      points.gather(nullptr, at, used, 1.0, &block);
      for (int i = 0; i < used; ++i)
        if (!(std::abs(block.x[i] - pupil.x[at + i]) <= tolerance &&
              std::abs(block.y[i] - pupil.y[at + i]) <= tolerance))
          return false;
    }
    return true;
  };
  const auto* rings = std::get_if<PolarRings>(&pupil.structure);
  const auto* grid = std::get_if<CartesianGrid>(&pupil.structure);
  if (const auto* directions = std::get_if<DirectionGrid>(&pupil.structure);
      directions && !well_formed(directions->cells, pupil.size()))
    throw std::invalid_argument(
        "SurfaceOperator: the pupil's points do not have the structure that it states");
  if (pupil.size() > 0 && ((rings && !matches(*rings)) || (grid && !matches(*grid))))
    throw std::invalid_argument(
        "SurfaceOperator: the pupil's points do not have the structure that it states");
}

/// Coordinates from the structure if only subsets and spherical terms need them, else the pupil's own.
PointCoordinates coordinates_of(const PupilSample& pupil, const OperatorChoice& choice) {
  const bool all_structured = (!choice.zernike || *choice.zernike == ZernikeMethod::kPolar) &&
                              (!choice.fourier || *choice.fourier == FourierMethod::kLattice);
  if (all_structured) {
    if (const auto* rings = std::get_if<PolarRings>(&pupil.structure)) return PointCoordinates(*rings);
    if (const auto* grid = std::get_if<CartesianGrid>(&pupil.structure)) return PointCoordinates(*grid);
  }
  return PointCoordinates(pupil.x, pupil.y);
}

/// Number of listed rays above which rings are faster than recurrences at each ray. Recurrences cost in
/// proportion to the rows (n, |m|); rings cost as much as about fourteen rows at any order (the table above).
Index polar_rays(const TermSet& terms, Index points) {
  constexpr double kRowsOfRings = 14;
  return Index(double(points) * kRowsOfRings / (kRowsOfRings + 0.5 * double(terms.zernike.size())));
}

}  // namespace

std::string to_string(ZernikeMethod method) {
  // The order is that of the enum.
  static constexpr const char* kNames[] = {"fused", "polar"};
  return kNames[std::size_t(method)];
}

std::string to_string(FourierMethod method) {
  // The order is that of the enum.
  static constexpr const char* kNames[] = {"phase-sums", "lattice"};
  return kNames[std::size_t(method)];
}

struct SurfaceOperator::Plan {
  /// A part that works on all points at once.
  struct WholePart {
    Families families;
    std::unique_ptr<TermOperator> part;
    Index enough_rays;  // number of listed rays above which it is faster than the pointwise part
  };

  TermSet terms;
  Index points = 0;
  int threads = 1;
  OperatorChoice choice;
  std::unique_ptr<PointwiseOperator> pointwise;
  std::vector<WholePart> whole;
  const FourierLattice* lattice = nullptr;  // one of the whole parts
  const SegmentTerms* segments = nullptr;   // one of the whole parts
  std::unique_ptr<HeightProducts> heights;  // for all terms except those of the lattice
  mutable ScratchPool<SurfaceField> scattered;
};

namespace {

PupilSample scattered_points(Eigen::ArrayXd x, Eigen::ArrayXd y) {
  PupilSample pupil;
  pupil.x = std::move(x);
  pupil.y = std::move(y);
  return pupil;
}

}  // namespace

SurfaceOperator::SurfaceOperator(TermSet terms, Eigen::ArrayXd x, Eigen::ArrayXd y, int threads)
    : SurfaceOperator(std::move(terms), scattered_points(std::move(x), std::move(y)), {threads, {}, {}}) {}

SurfaceOperator::SurfaceOperator(TermSet terms, const PupilSample& pupil, const OperatorOptions& options) {
  check(terms, pupil.x, pupil.y);
  check_structure(pupil);
  auto plan = std::make_unique<Plan>();
  plan->points = pupil.size();
  plan->threads = options.threads;
  plan->choice = choose_operator(terms, point_layout(pupil), options);
  const OperatorChoice& choice = plan->choice;

  PointCoordinates points = coordinates_of(pupil, choice);
  points.hold_at_rim = options.hold_at_rim;
  const bool polar = choice.zernike == ZernikeMethod::kPolar,
             lattice = choice.fourier == FourierMethod::kLattice;
  TermSet cell_by_cell = terms;
  if (polar)
    plan->whole.push_back({{true, false, false},
                           std::make_unique<ZernikePolar>(terms, std::get<PolarRings>(pupil.structure)),
                           polar_rays(terms, pupil.size())});
  if (lattice) {
    auto part = std::make_unique<FourierLattice>(terms, pupil.x, pupil.y);
    plan->lattice = part.get();
    plan->whole.push_back({{false, true, false}, std::move(part), plan->lattice->enough_rays()});
    cell_by_cell.fourier.clear();
  }
  if (terms.of_a_segment() > 0) {
    auto part = std::make_unique<SegmentTerms>(terms, pupil);
    plan->segments = part.get();
    plan->whole.push_back({{false, false, false}, std::move(part), 0});
    cell_by_cell.segments.reset();
  }
  const Families pointwise{choice.zernike && !polar, choice.fourier && !lattice, !terms.spherical.empty()};
  plan->pointwise = std::make_unique<PointwiseOperator>(terms, points, pointwise);
  plan->heights = std::make_unique<HeightProducts>(cell_by_cell, pupil, options.hold_at_rim);
  plan->terms = std::move(terms);
  plan_ = std::move(plan);
}

SurfaceOperator::~SurfaceOperator() = default;
SurfaceOperator::SurfaceOperator(SurfaceOperator&&) noexcept = default;
SurfaceOperator& SurfaceOperator::operator=(SurfaceOperator&&) noexcept = default;

const TermSet& SurfaceOperator::terms() const { return plan_->terms; }
Index SurfaceOperator::points() const { return plan_->points; }
const OperatorChoice& SurfaceOperator::choice() const { return plan_->choice; }

void SurfaceOperator::apply(const Eigen::VectorXd& coefficients, SurfaceField* field) const {
  assert(coefficients.size() == terms().size());
  field->resize(points());
  bool add = false;
  for (const Plan::WholePart& whole : plan_->whole) {
    whole.part->forward(coefficients, plan_->threads, add, field);
    add = true;
  }
  // Without any terms the pointwise part writes the zeros.
  if (!add || plan_->pointwise->families().any())
    plan_->pointwise->forward(coefficients, plan_->threads, add, field);
}

void SurfaceOperator::apply_transpose(const SurfaceField& weights, Eigen::VectorXd* result) const {
  assert(weights.size() == points());
  result->resize(terms().size());
  for (const Plan::WholePart& whole : plan_->whole) whole.part->adjoint(weights, plan_->threads, result);
  if (plan_->pointwise->families().any()) plan_->pointwise->adjoint(weights, plan_->threads, result);
}

void SurfaceOperator::apply_transpose(std::span<const std::uint32_t> rays, const SurfaceField& weights,
                                      Eigen::VectorXd* result) const {
  assert(weights.size() == Index(rays.size()));
  result->resize(terms().size());
  Families pointwise = plan_->pointwise->families();
  std::vector<const TermOperator*> whole_parts;
  for (const Plan::WholePart& whole : plan_->whole) {
    if (Index(rays.size()) >= whole.enough_rays) {
      whole_parts.push_back(whole.part.get());
    } else {
      pointwise.zernike |= whole.families.zernike;
      pointwise.fourier |= whole.families.fourier;
    }
  }
  if (!whole_parts.empty()) {
    const auto all = plan_->scattered.take();
    all->resize(points());
    for (Eigen::ArrayXd* plane : {&all->height, &all->slope_x, &all->slope_y}) plane->setZero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      all->height[rays[i]] += weights.height[Index(i)];
      all->slope_x[rays[i]] += weights.slope_x[Index(i)];
      all->slope_y[rays[i]] += weights.slope_y[Index(i)];
    }
    for (const TermOperator* part : whole_parts) part->adjoint(*all, plan_->threads, result);
  }
  if (pointwise.any()) plan_->pointwise->adjoint(rays.data(), weights, pointwise, plan_->threads, result);
}

Eigen::MatrixXd SurfaceOperator::apply_transpose_heights(std::span<const Eigen::ArrayXd> weights) const {
  if (!plan_->lattice && !plan_->segments) return (*plan_->heights)(weights, plan_->threads);
  // The lattice and the segments have separate rows, between and after those of the other terms.
  const Index begin = plan_->lattice ? terms().fourier_begin() : terms().spherical_begin(),
              end = terms().spherical_begin(), behind = terms().segments_begin() - end;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(terms().size(), Index(weights.size()));
  if (plan_->lattice) plan_->lattice->heights(weights, plan_->threads, begin, &result);
  if (begin + behind > 0) {
    const Eigen::MatrixXd others = (*plan_->heights)(weights, plan_->threads);
    result.topRows(begin) = others.topRows(begin);
    result.middleRows(end, behind) = others.bottomRows(behind);
  }
  if (plan_->segments)
    for (std::size_t k = 0; k < weights.size(); ++k)
      plan_->segments->add_heights(weights[k], result.col(Index(k)));
  return result;
}

Eigen::VectorXd SurfaceOperator::apply_transpose(const SurfaceField& weights) const {
  Eigen::VectorXd result;
  apply_transpose(weights, &result);
  return result;
}

Eigen::VectorXd SurfaceOperator::apply_transpose(std::span<const std::uint32_t> rays,
                                                 const SurfaceField& weights) const {
  Eigen::VectorXd result;
  apply_transpose(rays, weights, &result);
  return result;
}

}  // namespace aberfit
