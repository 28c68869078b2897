#include "aberfit/specify/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/root.h"
#include "aberfit/core/units.h"
#include "aberfit/method/image_shift.h"
#include "aberfit/method/physics_choice.h"
#include "budget_values.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kFlat = 1e-8;        // a smaller change over a step counts as none
constexpr int kFlatSteps = 3;         // number in a row that ends the search
constexpr double kRootOfLog = 1e-11;  // tolerance of ln(unknown)
constexpr int kEndHalvings = 30;      // towards the end of the allowed range
constexpr int kTurningHalvings = 12;  // golden sections of a step

struct Step {
  double log = 0;
  Eigen::ArrayXd excess;
  double worst() const { return excess.maxCoeff(); }
};

// Returns the theory that targets without a value use, with its warnings.
Theory theory_of(const Task& task, Warnings* warnings) {
  const RadialPsd psd(*task.psd);
  const PhysicsChoice use = choose_physics(task, requested_physics(task), &psd);
  if (use.theory == Theory::kRays)
    throw FieldError("target.theory", "\"rays\", random deflections, whose statistics have a sampling error",
                     "\"auto\", \"ghs\"; \"geometric\" for mirrors of revolution");
  warnings->insert(warnings->end(), use.warnings.begin(), use.warnings.end());
  if (auto shift = image_shift_warning(task)) warnings->push_back(std::move(*shift));
  return use.theory;
}

// Steps from the start one way, without the start; `end` is the reason for the end.
class Search {
 public:
  Search(const BudgetValues& budgets, std::size_t unknowns, const SolveOptions& options)
      : budgets_(budgets), unknowns_(unknowns), options_(options) {}

  std::vector<double> place(double log) const {
    std::vector<double> logs(unknowns_, 0.0);
    logs[0] = log;
    return logs;
  }
  Step step(double log) const { return {log, budgets_.excess(budgets_.at(place(log)))}; }

  std::vector<Step> walk(const Step& start, int way, RangeEnd* end) const {
    const double by = way * std::log(options_.step), most = options_.decades * std::log(10.0);
    std::vector<Step> steps;
    int flat = 0;
    for (int k = 1; std::abs(k * by) <= most * (1 + 1e-9); ++k) {
      const double last = steps.empty() ? start.log : steps.back().log;
      std::string why;
      double next = k * by;
      const bool refused = !budgets_.allowed(place(next), &why);
      if (refused) next = last_allowed(last, next);
      if (refused && next == last) return finish(last, why, end), steps;
      try {
        steps.push_back(step(next));
      } catch (const ComputationError& error) {
        return finish(last, std::string("beyond it: ") + error.what(), end), steps;
      }
      if (refused) return finish(next, why, end), steps;
      const Step& before = steps.size() > 1 ? steps[steps.size() - 2] : start;
      flat = (steps.back().excess - before.excess).abs().maxCoeff() < kFlat ? flat + 1 : 0;
      if (flat == kFlatSteps) return finish(next, "the values no longer change", end), steps;
    }
    finish(steps.empty() ? start.log : steps.back().log,
           fmt::format("limit of {:g} decades from the start", options_.decades), end);
    return steps;
  }

 private:
  void finish(double log, const std::string& why, RangeEnd* end) const {
    *end = {budgets_.values_of(place(log))[0], why};
  }
  double last_allowed(double inside, double outside) const {
    std::string why;
    for (int k = 0; k < kEndHalvings; ++k) {
      const double middle = 0.5 * (inside + outside);
      (budgets_.allowed(place(middle), &why) ? inside : outside) = middle;
    }
    return inside;
  }

  const BudgetValues& budgets_;
  std::size_t unknowns_;
  const SolveOptions& options_;
};

std::vector<Step> search_steps(const Search& search, const RunContext& context,
                               std::array<RangeEnd, 2>* range) {
  const Step start = search.step(0);
  std::vector<Step> down, up;
  parallel_for(2, context.threads, [&](std::size_t way) {
    (way == 0 ? down : up) = search.walk(start, way == 0 ? -1 : 1, &(*range)[way]);
  });
  std::vector<Step> steps(down.rbegin(), down.rend());
  steps.push_back(start);
  steps.insert(steps.end(), up.begin(), up.end());
  return steps;
}

// Adds turning points where the strictest budget approaches its limit between two steps and may cross it
// twice. The nearest approach is found by golden sections.
void add_turning_points(const Search& search, std::vector<Step>* steps) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  std::vector<Step> found;
  double least = kInfinity;
  for (const Step& step : *steps) least = std::min(least, std::abs(step.worst()));
  for (std::size_t k = 1; k + 1 < steps->size(); ++k) {
    const double sign = (*steps)[k].worst() > 0 ? 1 : -1;
    const auto height = [&](const Step& step) { return sign * step.worst(); };
    const Step &left = (*steps)[k - 1], &here = (*steps)[k], &right = (*steps)[k + 1];
    const double rise = std::max(height(left), height(right)) - height(here);
    const bool turns = height(left) > height(here) && height(here) < height(right) && rise > kFlat;
    const bool nearest = height(here) == least;
    if (!turns || !(height(here) < rise || nearest)) continue;
    double a = left.log, b = right.log;
    Step low = search.step(b - golden * (b - a)), high = search.step(a + golden * (b - a));
    for (int i = 0; i < kTurningHalvings && height(low) > 0 && height(high) > 0; ++i) {
      if (height(low) < height(high)) {
        b = high.log, high = low, low = search.step(b - golden * (b - a));
      } else {
        a = low.log, low = high, high = search.step(a + golden * (b - a));
      }
    }
    found.push_back(height(low) < height(high) ? low : high);
  }
  steps->insert(steps->end(), found.begin(), found.end());
  std::sort(steps->begin(), steps->end(), [](const Step& a, const Step& b) { return a.log < b.log; });
}

struct Crossing {
  double log = 0;
  std::array<double, 2> bracket{};
  bool holds_below = true;
};

// Returns the sign changes of one budget or, for -1, of the strictest one; nearest to the start first.
std::vector<Crossing> crossings(const Search& search, const std::vector<Step>& steps, int budget,
                                int threads) {
  const auto height = [&](const Step& step) { return budget < 0 ? step.worst() : step.excess[budget]; };
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k + 1 < steps.size(); ++k)
    if ((height(steps[k]) > 0) != (height(steps[k + 1]) > 0)) at.push_back(k);
  std::vector<Crossing> found(at.size());
  parallel_for(at.size(), threads, [&](std::size_t i) {
    const Step &low = steps[at[i]], &high = steps[at[i] + 1];
    // The root is sought from 1 to 2, so that a relative tolerance applies to the length of the step.
    const double length = high.log - low.log;
    const double t = root_between([&](double s) { return height(search.step(low.log + (s - 1) * length)); },
                                  1, 2, height(low), height(high), kRootOfLog);
    found[i] = {low.log + (t - 1) * length, {low.log, high.log}, height(high) > 0};
  });
  std::sort(found.begin(), found.end(),
            [](const Crossing& a, const Crossing& b) { return std::abs(a.log) < std::abs(b.log); });
  return found;
}

std::string plain_reason(const Specification& spec) {
  const SolvePoint& nearest = spec.nearest;
  const Budget& budget = spec.budgets[nearest.binding];
  return fmt::format("the nearest is {} = {}, where {} is {}",
                     spec.unknowns[0].pointer.substr(spec.unknowns[0].pointer.rfind('/') + 1),
                     format_quantity(nearest.at[0], spec.unknowns[0].dimension), budget.key,
                     in_budget_unit(budget, nearest.budgets[nearest.binding].value));
}

std::string why_none(const Specification& spec, const Eigen::ArrayXd& perfect) {
  for (std::size_t k = 0; k < spec.budgets.size(); ++k) {
    const Budget& budget = spec.budgets[k];
    const bool violated = perfect[Eigen::Index(k)] > 0;
    if (!violated || budget.at_most != is_less_of_smoother(budget)) continue;
    return fmt::format("Without any roughness {} is already {}, {} {}: {}; {}.", budget.key,
                       in_budget_unit(budget, spec.perfect[k].value), budget.at_most ? "above" : "below",
                       in_budget_unit(budget, budget.limit),
                       spec.theory == Theory::kGhs
                           ? "diffraction (the Airy limit) and the mirror itself exceed the budget"
                           : "the mirror itself exceeds the budget",
                       plain_reason(spec));
  }
  return fmt::format("Within {} to {} no value meets {}: {}.",
                     format_quantity(spec.range[0].value, spec.unknowns[0].dimension),
                     format_quantity(spec.range[1].value, spec.unknowns[0].dimension),
                     spec.budgets.size() == 1 ? "the budget" : "all budgets at once", plain_reason(spec));
}

// Explains why every value meets them. core: least specular fraction in the range.
std::string why_all(const Specification& spec, double core) {
  const Budget& budget = spec.budgets[spec.nearest.binding];
  const bool is_statistic = !budget.of_light && !budget.of_surface;
  const auto* energy = is_statistic ? std::get_if<EncircledEnergyRadius>(&budget.statistic) : nullptr;
  const std::string known =
      fmt::format("Every value from {} to {} meets {}: {}",
                  format_quantity(spec.range[0].value, spec.unknowns[0].dimension),
                  format_quantity(spec.range[1].value, spec.unknowns[0].dimension),
                  spec.budgets.size() == 1 ? "the budget" : "all budgets", plain_reason(spec));
  if (energy && budget.at_most && core > energy->fraction)
    return known + fmt::format(
                       ". The specular core alone holds {} of the energy, more than the required {}, "
                       "wherever the rest goes.",
                       format_percent(core), format_percent(energy->fraction));
  return known + ".";
}

void explain(const BudgetValues& budgets, const Search& search, const std::vector<Step>& steps,
             Specification* spec) {
  // This step violates the budgets least, or has the least margin: a turning point or an end of the range.
  const bool none = steps.front().worst() > 0;
  const auto nearest = std::min_element(steps.begin(), steps.end(), [&](const Step& a, const Step& b) {
    return none ? a.worst() < b.worst() : a.worst() > b.worst();
  });
  spec->status = none ? SolveStatus::kNoSolution : SolveStatus::kUnbounded;
  spec->nearest = budgets.point(search.place(nearest->log), false);
  if (none) {
    spec->reason = why_none(*spec, budgets.excess(budgets.of_perfect_mirror()));
    return;
  }
  double core = kInfinity;
  for (const Step* end : {&steps.front(), &*nearest, &steps.back()}) {
    const double here = budgets.core_share(search.place(end->log));
    core = here < core ? here : core;
  }
  spec->reason = why_all(*spec, std::isfinite(core) ? core : 0);
}

// Checks the theory at the solution, where it may differ from that at the start.
void check_theory_there(const TaskAt& task_at, Specification* spec) {
  const Task task = task_at(spec->solutions.front().at);
  const RadialPsd psd(*task.psd);
  std::string found;
  try {
    const PhysicsChoice use = choose_physics(task, requested_physics(task), &psd);
    if (use.theory == spec->theory) return;
    found = use.obstacle.empty() ? "theory " + to_string(use.theory) : use.obstacle;
  } catch (const FieldError& error) {
    found = error.found();
  }
  spec->warnings.push_back(
      {"solve-theory-ends",
       fmt::format("at the solution theory {} is no longer the one that the study needs: {}; name another "
                   "with target.theory, or take the solution as a bound",
                   to_string(spec->theory), found)});
}

}  // namespace

std::string to_string(SolveStatus status) {
  static const char* const kNames[] = {"not_run", "solved", "no_solution", "unbounded"};
  return kNames[std::size_t(status)];
}

Specification solve_specification(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                  const std::vector<Budget>& budgets, const SolveOptions& options,
                                  const RunContext& context) {
  const auto begun = std::chrono::steady_clock::now();
  Specification spec;
  spec.unknowns = unknowns;
  spec.budgets = budgets;
  std::vector<double> own;
  for (const SolveUnknown& unknown : unknowns) {
    if (!(unknown.start > 0))
      throw FieldError("solve.for",
                       fmt::format("{}, which is {} in the study", unknown.pointer, unknown.start),
                       "a number above zero as start, because the search goes in factors");
    own.push_back(unknown.start);
  }
  spec.theory = theory_of(task_at(own), &spec.warnings);
  spec.confidence = options.confidence;
  for (Budget& budget : spec.budgets) budget = at_wavelength(std::move(budget), task_at(own).wavelength);
  for (const Budget& budget : spec.budgets) {
    if (!budget.of_light && !budget.of_surface) continue;
    if (budget.of_light && spec.theory != Theory::kGhs)
      throw FieldError("solve.so_that", budget.key + " with theory " + to_string(spec.theory),
                       "target.theory \"ghs\"; by rays only ee radii, heights, slopes and scatter_rms");
    if (options.confidence > 0)
      throw FieldError("solve.confidence", "beside the budget " + budget.key,
                       "beside budgets of ee radii and diameters, rms_height and scatter_rms only");
  }
  if (options.confidence > 0 && spec.theory != Theory::kGhs)
    throw FieldError("solve.confidence",
                     "theory " + to_string(spec.theory) + ", which predicts only the mean",
                     "a target.theory of \"ghs\", or no confidence");
  const BudgetValues values(task_at, spec.unknowns, spec.budgets, spec.theory, options.confidence,
                            context.threads);
  spec.focal_length = values.focal_length();
  const Search search(values, unknowns.size(), options);
  spec.start = values.point(search.place(0), false);
  spec.perfect = values.states(values.of_perfect_mirror());
  std::vector<Step> steps = search_steps(search, context, &spec.range);
  add_turning_points(search, &steps);
  const std::vector<Crossing> all = crossings(search, steps, -1, context.threads);
  for (std::size_t k = 0; k < budgets.size(); ++k) {
    spec.alone.emplace_back();
    const bool only = budgets.size() == 1;
    for (const Crossing& crossing : only ? all : crossings(search, steps, int(k), context.threads))
      spec.alone.back().push_back(values.values_of(search.place(crossing.log))[0]);
  }
  for (const Crossing& crossing : all) {
    spec.solutions.push_back(values.point(search.place(crossing.log), true));
    SolvePoint& solution = spec.solutions.back();
    solution.holds_below = crossing.holds_below;
    for (std::size_t end : {0, 1})
      solution.bracket[end] = values.values_of(search.place(crossing.bracket[end]))[0];
  }
  if (spec.solutions.empty()) {
    explain(values, search, steps, &spec);
  } else {
    spec.status = SolveStatus::kSolved;
    check_theory_there(task_at, &spec);
    if (unknowns.size() == 2)
      spec.contour = trace_contour(values, {std::log(spec.solutions.front().at[0] / unknowns[0].start), 0.0},
                                   options.contour_decades * std::log(10.0), context);
  }
  spec.evaluations = values.evaluations();
  spec.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return spec;
}

}  // namespace aberfit
