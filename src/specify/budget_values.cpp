#include "budget_values.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/height_on_aperture.h"
#include "exact_variable.h"
#include "held_by.h"

namespace aberfit::internal {
namespace {

constexpr double kNoRoughness = 1e-9;  // fraction of the heights; scatters 1e-18 of the energy

bool is_statistic(const Budget& budget) { return !budget.of_light && !budget.of_surface; }

bool needs_light(const Budget& budget) {
  return budget.of_light ||
         (is_statistic(budget) && std::holds_alternative<EncircledEnergyRadius>(budget.statistic));
}

GeometricHarveyShack geometric(const Task& task, const RadialPsd& psd) {
  return {task.mirror, task.aperture, psd_moments(psd).rms_slope_per_axis(), task.target.convention,
          rms_height_on(task.aperture, psd)};
}

}  // namespace

BudgetValues::BudgetValues(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                           const std::vector<Budget>& budgets, Theory theory, double confidence, int threads)
    : task_at_(task_at),
      unknowns_(unknowns),
      budgets_(budgets),
      theory_(theory),
      confidence_(confidence),
      threads_(threads) {
  const Task task = task_at(values_of(std::vector<double>(unknowns.size(), 0.0)));
  focal_length_ = task.mirror.focal_length;
  if (in_light()) pupil_.emplace(task.mirror, task.aperture, task.wavelength);
  std::vector<LightProperty> of_light;
  for (const Budget& budget : budgets) {
    if (is_statistic(budget)) statistics_.push_back(budget.statistic);
    if (budget.of_light) of_light.push_back(*budget.of_light);
  }
  if (!of_light.empty() && in_light()) light_.emplace(std::move(of_light), *pupil_);
  // With a confidence, all derivatives are differences.
  for (std::size_t u = 0; u < unknowns.size(); ++u)
    variables_.push_back(confidence > 0 ? std::nullopt : exact_variable(task_at, unknowns, u));
}

bool BudgetValues::in_light() const {
  return theory_ == Theory::kGhs &&
         (confidence_ > 0 || std::any_of(budgets_.begin(), budgets_.end(), needs_light));
}

bool BudgetValues::allowed(const std::vector<double>& logs, std::string* why) const {
  try {
    task_at_(values_of(logs));
    return true;
  } catch (const InputError& error) {
    *why = error.pointer() + ": allowed is " + error.allowed();
    return false;
  }
}

Eigen::VectorXd BudgetValues::in_order(const Eigen::VectorXd& statistics, const Eigen::VectorXd& light,
                                       const RadialPsd& psd) const {
  Eigen::VectorXd values(Eigen::Index(budgets_.size()));
  Eigen::Index statistic = 0, property = 0;
  for (std::size_t k = 0; k < budgets_.size(); ++k) {
    const Budget& budget = budgets_[k];
    const double value = budget.of_surface ? of_surface(*budget.of_surface, psd)
                         : budget.of_light ? light[property++]
                                           : statistics[statistic++];
    values[Eigen::Index(k)] = budgeted(budget, value, focal_length_);
  }
  if (values.array().isNaN().any()) throw ComputationError("the theory has no value there");
  return values;
}

// The theory is chosen as in make_targets. The surface has the same moments in both theories.
Eigen::ArrayXd BudgetValues::predict(const Task& task, double height_factor) const {
  ++evaluations_;
  const RadialPsd specified(*task.psd);
  const RadialPsd psd = height_factor == 1 ? specified : specified.scaled(height_factor);
  if (in_light()) {
    const GeneralisedHarveyShack mean(psd, *pupil_);
    Eigen::VectorXd found = mean.predict(statistics_);
    // Applies to statistics only, see solve_specification.
    if (confidence_ > 0 && height_factor == 1)
      found = held_by(confidence_, {psd, *pupil_, mean, budgets_}, found);
    return in_order(found, light_ ? (*light_)(mean) : Eigen::VectorXd(), psd);
  }
  Eigen::VectorXd found(Eigen::Index(statistics_.size()));
  if (!statistics_.empty()) {
    const GeometricHarveyShack theory = geometric(task, psd);
    for (std::size_t k = 0; k < statistics_.size(); ++k) found[Eigen::Index(k)] = theory(statistics_[k]);
  }
  return in_order(found, {}, psd);
}

Eigen::ArrayXd BudgetValues::at(const std::vector<double>& logs) const {
  return predict(task_at_(values_of(logs)), 1);
}

PsdJacobian BudgetValues::geometric_jacobian(const Task& task,
                                             const std::vector<PsdVariable>& variables) const {
  const std::vector<Statistic>& wanted = statistics_;
  PsdJacobian result;
  result.parameters = variables;
  result.values.resize(Eigen::Index(wanted.size()));
  result.parameter_values.resize(Eigen::Index(variables.size()));
  for (std::size_t u = 0; u < variables.size(); ++u)
    result.parameter_values[Eigen::Index(u)] = value_of(*task.psd, variables[u]);
  if (wanted.empty()) {  // only quantities of the surface, which need no rays
    result.derivatives.resize(0, result.parameter_values.size());
    return result;
  }
  const RadialPsd psd(*task.psd);
  const GeometricHarveyShack theory = geometric(task, psd);
  const double slope_variance = psd_moments(psd).slope_variance;
  result.derivatives.resize(result.values.size(), result.parameter_values.size());
  for (Eigen::Index u = 0; u < result.parameter_values.size(); ++u) {
    const PsdVariable& variable = variables[std::size_t(u)];
    const PsdDerivative derivative(*task.psd, variable);
    const double of_slope = 2 * kPi * kPi * derivative.moment(2) / slope_variance;  // d ln(slope)/dp
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const auto i = Eigen::Index(k);
      const double value = result.values[i] = theory(wanted[k]);
      if (const auto* radius = std::get_if<EncircledEnergyRadius>(&wanted[k]))
        result.derivatives(i, u) = of_slope * theory.radius_over_slope(value, radius->dz);
      else if (std::holds_alternative<RmsHeight>(wanted[k]))
        result.derivatives(i, u) = value * height_variance_change_on(task.aperture, psd, derivative) /
                                   (2 * std::pow(rms_height_on(task.aperture, psd), 2));
      else
        result.derivatives(i, u) = of_slope * value;
    }
  }
  return result;
}

BudgetValues::Exact BudgetValues::exact(const Task& task, const std::vector<PsdVariable>& variables) const {
  const RadialPsd psd(*task.psd);
  const PsdJacobian found = in_light() ? psd_jacobian(*task.psd, variables, statistics_, *pupil_, threads_,
                                                      light_ ? &*light_ : nullptr)
                                       : geometric_jacobian(task, variables);
  const auto own = Eigen::Index(statistics_.size());
  Exact result;
  result.values = in_order(found.values.head(own), found.values.tail(found.values.size() - own), psd);
  const Eigen::MatrixXd logarithmic = found.logarithmic();
  result.logarithmic.resize(result.values.size(), logarithmic.cols());
  for (Eigen::Index u = 0; u < logarithmic.cols(); ++u) {
    const PsdDerivative derivative(*task.psd, variables[std::size_t(u)]);
    Eigen::Index statistic = 0, property = own;
    for (std::size_t k = 0; k < budgets_.size(); ++k) {
      const Budget& budget = budgets_[k];
      double change = 0;
      if (budget.of_surface)
        change = of_surface_change(*budget.of_surface, psd, derivative) * found.parameter_values[u];
      else
        change = logarithmic(budget.of_light ? property++ : statistic++, u);
      result.logarithmic(Eigen::Index(k), u) = budget.is_squared ? 2 * change : change;
    }
  }
  return result;
}

BudgetValues::WithSlopes BudgetValues::with_slopes(const std::vector<double>& logs) const {
  const Task task = task_at_(values_of(logs));
  std::vector<PsdVariable> variables;
  for (const std::optional<PsdVariable>& variable : variables_)
    if (variable) variables.push_back(*variable);
  WithSlopes result;
  Eigen::MatrixXd known_slopes;
  if (variables.empty()) {
    result.values = predict(task, 1);
  } else {
    ++evaluations_;
    Exact found = exact(task, variables);
    known_slopes = std::move(found.logarithmic);
    result.values = found.values;
  }
  result.slopes.resize(result.values.size(), Eigen::Index(logs.size()));
  Eigen::Index known = 0;
  for (std::size_t u = 0; u < logs.size(); ++u) {
    if (variables_[u])
      result.slopes.col(Eigen::Index(u)) = known_slopes.col(known++).array();
    else
      result.slopes.col(Eigen::Index(u)) = difference(logs, u, result.values);
  }
  return result;
}

// One-sided difference, with half of the digits, at the end of the allowed range.
Eigen::ArrayXd BudgetValues::difference(const std::vector<double>& logs, std::size_t unknown,
                                        const Eigen::ArrayXd& here) const {
  const auto moved = [&](double by, double* step) -> Eigen::ArrayXd {
    std::vector<double> there = logs;
    there[unknown] += by;
    try {
      Eigen::ArrayXd moved_values = at(there);
      *step = by;
      return moved_values;
    } catch (const std::exception&) {
      *step = 0;
      return here;
    }
  };
  double up = 0, down = 0;
  const Eigen::ArrayXd above = moved(kDifference, &up), below = moved(-kDifference, &down);
  if (!(up > down)) return Eigen::ArrayXd::Constant(here.size(), kNaN);
  return (above / below).log() / (up - down);
}

double BudgetValues::worst_excess(const std::vector<double>& logs, Eigen::VectorXd* gradient) const {
  const WithSlopes here = with_slopes(logs);
  Eigen::Index binding = 0;
  const double worst = excess(here.values).maxCoeff(&binding);
  *gradient = here.slopes.row(binding).transpose() * (budgets_[std::size_t(binding)].at_most ? 1 : -1);
  return worst;
}

Eigen::ArrayXd BudgetValues::of_perfect_mirror() const {
  return predict(task_at_(values_of(std::vector<double>(unknowns_.size(), 0.0))), kNoRoughness);
}

double BudgetValues::core_share(const std::vector<double>& logs) const {
  if (theory_ != Theory::kGhs) return kNaN;
  const Task task = task_at_(values_of(logs));
  const GhsPupil pupil = pupil_ ? *pupil_ : GhsPupil(task.mirror, task.aperture, task.wavelength);
  return GeneralisedHarveyShack(RadialPsd(*task.psd), pupil).core_share();
}

Eigen::ArrayXd BudgetValues::excess(const Eigen::ArrayXd& values) const {
  Eigen::ArrayXd result(values.size());
  for (std::size_t k = 0; k < budgets_.size(); ++k) {
    const double ratio = std::log(values[Eigen::Index(k)] / budgets_[k].limit);
    result[Eigen::Index(k)] = std::clamp(budgets_[k].at_most ? ratio : -ratio, -kFarOff, kFarOff);
  }
  return result;
}

std::vector<BudgetState> BudgetValues::states(const Eigen::ArrayXd& values) const {
  std::vector<BudgetState> states;
  for (std::size_t k = 0; k < budgets_.size(); ++k) {
    const double value = values[Eigen::Index(k)], above = value / budgets_[k].limit - 1;
    states.push_back({value, budgets_[k].at_most ? -above : above, {}});
  }
  return states;
}

SolvePoint BudgetValues::point(const std::vector<double>& logs, bool whole) const {
  return point(logs, whole ? with_slopes(logs) : WithSlopes{at(logs), {}});
}

SolvePoint BudgetValues::point(const std::vector<double>& logs, const WithSlopes& here) const {
  SolvePoint point;
  point.at = values_of(logs);
  point.budgets = states(here.values);
  Eigen::Index binding = 0;
  excess(here.values).maxCoeff(&binding);
  point.binding = std::size_t(binding);
  for (Eigen::Index u = 0; u < here.slopes.cols(); ++u)
    for (std::size_t k = 0; k < budgets_.size(); ++k)
      point.budgets[k].sensitivity.push_back(here.slopes(Eigen::Index(k), u));
  return point;
}

}  // namespace aberfit::internal
