#include "aberfit/terms/operator_cost.h"

#include <fmt/core.h>

#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "aberfit/core/instruction_set.h"

namespace aberfit {

namespace {

/// Ratio of time to that of an AVX-512 core. The constants below are nanoseconds on such a core, measured by
/// tests/benchmarks/operator_benchmark; see surface_operator.cpp.
double slower() {
  switch (best_instruction_set()) {
    case InstructionSet::kAvx512:
      return 1;
    case InstructionSet::kAvx2:
      return 2;
    case InstructionSet::kBaseline:
      break;
  }
  return 5;
}
constexpr double kFusedPoint = 3.5, kFusedRow = 0.2;      // per point; per point and row (n, |m|)
constexpr double kPolarPoint = 4.5, kPolarRow = 0.3;      // per point; per ring and row
constexpr double kPhase = 0.6, kSpherical = 1.0;          // per point and term
constexpr double kLatticePoint = 60, kLatticeCell = 250;  // per point; per point of the lattice

void check_named(const TermSet& terms, const PointLayout& layout, const OperatorOptions& options) {
  if (!terms.zernike.empty() && options.zernike == ZernikeMethod::kPolar && layout.rings == 0)
    throw std::invalid_argument("SurfaceOperator: the polar method needs points on rings (a polar pupil)");
  if (!terms.fourier.empty() && options.fourier == FourierMethod::kLattice && !(terms.fourier_pitch > 0))
    throw std::invalid_argument("SurfaceOperator: the lattice method needs modes of a lattice");
}

double seconds_of(const OperatorChoice& choice, const TermSet& terms, const PointLayout& layout) {
  std::set<std::pair<int, int>> rows;
  for (const ZernikeMode& mode : terms.zernike) rows.emplace(mode.n, std::abs(mode.m));
  const double points = double(layout.points), modes = double(terms.fourier.size());
  double sum = kSpherical * points * double(terms.spherical.size());
  if (choice.zernike == ZernikeMethod::kPolar)
    sum += kPolarPoint * points + kPolarRow * double(layout.rings) * double(rows.size());
  else if (choice.zernike)
    sum += points * (kFusedPoint + kFusedRow * double(rows.size()));
  if (choice.fourier == FourierMethod::kLattice)
    sum += kLatticePoint * points + kLatticeCell * 2 * modes;
  else if (choice.fourier)
    sum += kPhase * points * modes;
  return 1e-9 * slower() * sum;
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

OperatorChoice choose_operator(const TermSet& terms, const PointLayout& layout,
                               const OperatorOptions& options) {
  check_named(terms, layout, options);
  OperatorChoice choice;
  std::string methods;
  const auto because = [](bool named) {
    return named ? "as requested" : "the fastest that their structure allows";
  };
  if (!terms.zernike.empty()) {
    choice.zernike =
        options.zernike.value_or(layout.rings > 0 ? ZernikeMethod::kPolar : ZernikeMethod::kFused);
    methods += fmt::format("{} Zernike terms {} ({})", terms.zernike.size(), to_string(*choice.zernike),
                           because(options.zernike.has_value()));
  }
  if (!terms.fourier.empty()) {
    choice.fourier = options.fourier.value_or(terms.fourier_pitch > 0 ? FourierMethod::kLattice
                                                                      : FourierMethod::kPhaseSums);
    methods += fmt::format("{}{} Fourier modes {} ({})", methods.empty() ? "" : ", ", terms.fourier.size(),
                           to_string(*choice.fourier), because(options.fourier.has_value()));
  }
  choice.forward_seconds = choice.adjoint_seconds = seconds_of(choice, terms, layout);
  choice.reason =
      fmt::format("{} {}{}{}", layout.points, arrangement(layout), methods.empty() ? "" : ": ", methods);
  return choice;
}

OperatorChoice choose_operator(const TermSet& terms, const PupilSample& pupil,
                               const OperatorOptions& options) {
  return choose_operator(terms, point_layout(pupil), options);
}

}  // namespace aberfit
