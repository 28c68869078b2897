#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "budget_values.h"

namespace aberfit::internal {
namespace {

constexpr double kLongest = 0.35, kShortest = 2e-3, kFirst = 0.15;  // arc length [ln]
constexpr double kStraight = 0.5;  // a larger turn over a step is a kink rather than a bend [rad]
constexpr int kMostCorrections = 8, kEasy = 3;
constexpr double kLastStep = 3e-5;  // last Newton step; the next would be its square [ln]
constexpr std::size_t kMostPoints = 400;

using Place = Eigen::Vector2d;  // ln(unknown/start)

// The excess of the binding budget at a place, and its gradient.
struct Slope {
  double excess = 0;
  Place gradient = Place::Zero();
};
Slope slope_at(const BudgetValues& budgets, const Place& place) {
  Eigen::VectorXd gradient;
  const double excess = budgets.worst_excess({place[0], place[1]}, &gradient);
  return {excess, gradient};
}

// Returns the tangent of the curve, perpendicular to the gradient, in the direction of `along`.
Place tangent_of(const Place& gradient, const Place& along) {
  const Place tangent = Place(-gradient[1], gradient[0]).normalized();
  return tangent.dot(along) < 0 ? Place(-tangent) : tangent;
}

// A point on the curve, where a corrector step ended.
struct Reached {
  Place place;
  BudgetValues::WithSlopes values;
  Place gradient;  // at the last step but one; that of the curve to within that step
  int corrections = 0;
};

// Moves from `guess` in the direction `across` to the curve by Newton's method. The last step is predicted by
// the gradient and evaluated without a new one. Empty if it is further than `reach`.
std::optional<Reached> corrected(const BudgetValues& budgets, const Place& guess, const Place& across,
                                 double reach) {
  Reached at{guess, {}, Place::Zero(), 0};
  double t = 0;
  while (at.corrections < kMostCorrections) {
    const Slope here = slope_at(budgets, at.place);
    at.gradient = here.gradient;
    const double step = -here.excess / here.gradient.dot(across);
    t += step;
    if (!(std::abs(t) <= reach)) return std::nullopt;
    at.place = guess + t * across;
    ++at.corrections;
    if (std::abs(step) > kLastStep) continue;
    at.values = {budgets.at({at.place[0], at.place[1]}), {}};
    if (std::abs(budgets.excess(at.values.values).maxCoeff()) < 0.1 * kOnBudget) return at;
  }
  return std::nullopt;
}

struct Arm {
  std::vector<SolvePoint> points;  // without the start
  bool is_closed = false;
  std::string end;
};

// Follows the curve from `start` one way: tangents with curvature predict, and a step across them corrects.
Arm follow(const BudgetValues& budgets, const Place& start, Place along, double box) {
  Arm arm;
  Place here = start, bend = Place::Zero();  // d(along)/d(arc)
  double arc = kFirst;
  while (arm.points.size() < kMostPoints) {
    if (arc < kShortest) return arm.end = "the curve could not be followed further", arm;
    Place guess = here + arc * along + 0.5 * arc * arc * bend;
    Place across = Place(-(along + arc * bend)[1], (along + arc * bend)[0]).normalized();
    const bool leaves = guess.cwiseAbs().maxCoeff() > box;
    if (leaves) {  // to the edge of the box, and along that edge
      const int wall = std::abs(guess[0]) > std::abs(guess[1]) ? 0 : 1;
      const double edge = std::copysign(box, guess[wall]);
      guess = here + (guess - here) * (edge - here[wall]) / (guess[wall] - here[wall]);
      guess[wall] = edge;
      across = Place::Zero();
      across[1 - wall] = 1;
    }
    std::optional<Reached> next;
    try {
      next = corrected(budgets, guess, across, 0.5 * arc);
    } catch (const InputError& error) {
      if (arc < 2 * kShortest) return arm.end = "allowed is " + error.allowed(), arm;
    } catch (const ComputationError& error) {
      if (arc < 2 * kShortest) return arm.end = error.what(), arm;
    }
    if (!next || (next->place - here).dot(along) <= 0) {
      arc *= 0.5;
      bend.setZero();  // at a kink, where another budget starts to bind, the curvature is meaningless
      continue;
    }
    arm.points.push_back(budgets.point({next->place[0], next->place[1]}, next->values));
    if (leaves) return arm.end = "it reached the end of the range", arm;
    const Place moved = next->place - here, tangent = tangent_of(next->gradient, moved);
    bend = (tangent - along) / moved.norm();
    if (bend.norm() * arc > kStraight) bend.setZero();
    along = tangent;
    here = next->place;
    if (arm.points.size() > 3 && (here - start).norm() < 0.75 * arc) return arm.is_closed = true, arm;
    if (next->corrections <= kEasy) arc = std::min(1.5 * arc, kLongest);
  }
  arm.end = "the contour reached its largest number of points";
  return arm;
}

}  // namespace

Contour trace_contour(const BudgetValues& budgets, const std::array<double, 2>& start, double reach,
                      const RunContext& context) {
  const Place first(start[0], start[1]);
  const double box = std::max(reach, 1.001 * first.cwiseAbs().maxCoeff());
  const Place along = tangent_of(slope_at(budgets, first).gradient, Place(0, 1));
  std::array<Arm, 2> arms;
  parallel_for(2, context.threads,
               [&](std::size_t k) { arms[k] = follow(budgets, first, k == 0 ? along : -along, box); });
  Contour contour;
  contour.is_closed = arms[0].is_closed;
  if (!contour.is_closed) contour.points.assign(arms[1].points.rbegin(), arms[1].points.rend());
  contour.points.push_back(budgets.point({first[0], first[1]}, false));
  contour.points.insert(contour.points.end(), arms[0].points.begin(), arms[0].points.end());
  contour.ends = {arms[1].end, arms[0].end};
  // The second unknown ascends, as in a table.
  if (contour.points.front().at[1] > contour.points.back().at[1]) {
    std::reverse(contour.points.begin(), contour.points.end());
    std::swap(contour.ends[0], contour.ends[1]);
  }
  return contour;
}

}  // namespace aberfit::internal
