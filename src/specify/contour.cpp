#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "budget_values.h"

namespace aberfit::internal {
namespace {

constexpr double kLongest = 0.35, kShortest = 2e-3, kFirst = 0.15;  // arc [ln]
constexpr double kGradientStep = 1e-3;
constexpr int kMostCorrections = 8, kEasy = 4;
constexpr std::size_t kMostPoints = 400;

using Place = Eigen::Vector2d;  // ln(unknown/start)

double excess_at(const BudgetValues& budgets, const Place& place) {
  return budgets.worst_excess({place[0], place[1]});
}

// Along the curve: across the gradient.
Place tangent_at(const BudgetValues& budgets, const Place& place) {
  Place gradient;
  for (int k = 0; k < 2; ++k) {
    Place step = Place::Zero();
    step[k] = kGradientStep;
    gradient[k] = excess_at(budgets, place + step) - excess_at(budgets, place - step);
  }
  return Place(-gradient[1], gradient[0]).normalized();
}

// From `guess` along `across` to the curve by the secant method; empty where it is further than `reach`.
std::optional<Place> corrected(const BudgetValues& budgets, const Place& guess, const Place& across,
                               double slope, double reach, int* corrections) {
  double t = 0, value = excess_at(budgets, guess);
  for (*corrections = 0; *corrections < kMostCorrections; ++*corrections) {
    if (std::abs(value) < 0.1 * kOnBudget) return guess + t * across;
    const double next = t - value / slope;
    if (!(std::abs(next) <= reach)) return std::nullopt;
    const double there = excess_at(budgets, guess + next * across);
    if (there != value) slope = (there - value) / (next - t);
    t = next;
    value = there;
  }
  return std::nullopt;
}

struct Arm {
  std::vector<Place> places;  // without the start
  bool is_closed = false;
  std::string end;
};

// The curve from `start` one way: secants predict, a step across them corrects.
Arm follow(const BudgetValues& budgets, const Place& start, Place along, double box) {
  Arm arm;
  Place here = start;
  double arc = kFirst, slope = 0;
  bool slope_known = false;
  while (arm.places.size() < kMostPoints) {
    if (arc < kShortest) return arm.end = "the curve could not be followed further", arm;
    Place guess = here + arc * along, across(-along[1], along[0]);
    const bool leaves = guess.cwiseAbs().maxCoeff() > box;
    if (leaves) {  // to the edge of the box, and along that
      const int wall = std::abs(guess[0]) > std::abs(guess[1]) ? 0 : 1;
      const double edge = std::copysign(box, guess[wall]);
      guess = here + along * (edge - here[wall]) / along[wall];
      across = Place::Zero();
      across[1 - wall] = 1;
    }
    std::optional<Place> next;
    int corrections = 0;
    try {
      // Across a curve the slope hardly changes from point to point; at a kink, where another budget begins
      // to bind, and along the edge of the box it does.
      const double by = kGradientStep;
      if (!slope_known || leaves)
        slope =
            (excess_at(budgets, guess + by * across) - excess_at(budgets, guess - by * across)) / (2 * by);
      next = corrected(budgets, guess, across, slope, 0.5 * arc, &corrections);
    } catch (const InputError& error) {
      if (arc < 2 * kShortest) return arm.end = "allowed is " + error.allowed(), arm;
    } catch (const ComputationError& error) {
      if (arc < 2 * kShortest) return arm.end = error.what(), arm;
    }
    if (!next || (*next - here).dot(along) <= 0) {
      arc *= 0.5;
      slope_known = false;
      continue;
    }
    slope_known = !leaves;
    arm.places.push_back(*next);
    if (leaves) return arm.end = "the end of the range", arm;
    along = (*next - here).normalized();
    here = *next;
    if (arm.places.size() > 3 && (here - start).norm() < 0.75 * arc) return arm.is_closed = true, arm;
    if (corrections <= kEasy) arc = std::min(1.5 * arc, kLongest);
  }
  arm.end = "as many points as a contour has";
  return arm;
}

}  // namespace

Contour trace_contour(const BudgetValues& budgets, const std::array<double, 2>& start, double reach,
                      const RunContext& context) {
  const Place first(start[0], start[1]);
  const double box = std::max(reach, 1.001 * first.cwiseAbs().maxCoeff());
  const Place along = tangent_at(budgets, first);
  std::array<Arm, 2> arms;
  parallel_for(2, context.threads,
               [&](std::size_t k) { arms[k] = follow(budgets, first, k == 0 ? along : -along, box); });
  Contour contour;
  contour.is_closed = arms[0].is_closed;
  std::vector<Place> places;
  if (!contour.is_closed) places.assign(arms[1].places.rbegin(), arms[1].places.rend());
  places.push_back(first);
  places.insert(places.end(), arms[0].places.begin(), arms[0].places.end());
  contour.ends = {arms[1].end, arms[0].end};
  contour.points.resize(places.size());
  parallel_for(places.size(), context.threads, [&](std::size_t k) {
    contour.points[k] = budgets.point({places[k][0], places[k][1]}, false);
  });
  // From small to large values of the second unknown, as a table is read.
  if (contour.points.front().at[1] > contour.points.back().at[1]) {
    std::reverse(contour.points.begin(), contour.points.end());
    std::swap(contour.ends[0], contour.ends[1]);
  }
  return contour;
}

}  // namespace aberfit::internal
