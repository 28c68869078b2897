#include "budget_values.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/height_on_aperture.h"

namespace aberfit::internal {
namespace {

constexpr double kDifference = 1e-3;   // of ln(unknown), for sensitivities
constexpr double kNoRoughness = 1e-9;  // of the heights: scatters 1e-18 of the light

bool is_energy(const Budget& budget) {
  return std::holds_alternative<EncircledEnergyRadius>(budget.statistic);
}

GeometricHarveyShack geometric(const Task& task, const RadialPsd& psd) {
  return {task.mirror, task.aperture, psd_moments(psd).rms_slope_per_axis(), task.target.convention,
          rms_height_on(task.aperture, psd)};
}

}  // namespace

BudgetValues::BudgetValues(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                           const std::vector<Budget>& budgets, Theory theory)
    : task_at_(task_at), unknowns_(unknowns), budgets_(budgets), theory_(theory) {
  focal_length_ = task_at(values_of(std::vector<double>(unknowns.size(), 0.0))).mirror.focal_length;
}

std::vector<double> BudgetValues::values_of(const std::vector<double>& logs) const {
  std::vector<double> values;
  for (std::size_t k = 0; k < unknowns_.size(); ++k)
    values.push_back(logs[k] == 0 ? unknowns_[k].start : unknowns_[k].start * std::exp(logs[k]));
  return values;
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

// As make_targets does it; moments of the surface are the same by either theory and need no light.
Eigen::ArrayXd BudgetValues::predict(const Task& task, double height_factor) const {
  ++evaluations_;
  const RadialPsd specified(*task.psd);
  const RadialPsd psd = height_factor == 1 ? specified : specified.scaled(height_factor);
  std::vector<Statistic> statistics;
  for (const Budget& budget : budgets_) statistics.push_back(budget.statistic);
  Eigen::VectorXd found(Eigen::Index(statistics.size()));
  if (theory_ == Theory::kGhs && std::any_of(budgets_.begin(), budgets_.end(), is_energy)) {
    found = GeneralisedHarveyShack(psd, task.mirror, task.aperture, task.wavelength).predict(statistics);
  } else {
    const GeometricHarveyShack theory = geometric(task, psd);
    for (std::size_t k = 0; k < statistics.size(); ++k) found[Eigen::Index(k)] = theory(statistics[k]);
  }
  Eigen::ArrayXd values(found.size());
  for (std::size_t k = 0; k < budgets_.size(); ++k)
    values[Eigen::Index(k)] = budgeted(budgets_[k], found[Eigen::Index(k)], task.mirror.focal_length);
  if (values.isNaN().any()) throw ComputationError("the theory has no value there");
  return values;
}

Eigen::ArrayXd BudgetValues::at(const std::vector<double>& logs) const {
  return predict(task_at_(values_of(logs)), 1);
}

Eigen::ArrayXd BudgetValues::of_perfect_mirror() const {
  return predict(task_at_(values_of(std::vector<double>(unknowns_.size(), 0.0))), kNoRoughness);
}

double BudgetValues::core_share(const std::vector<double>& logs) const {
  if (theory_ != Theory::kGhs) return kNaN;
  const Task task = task_at_(values_of(logs));
  return GeneralisedHarveyShack(RadialPsd(*task.psd), task.mirror, task.aperture, task.wavelength)
      .core_share();
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
  SolvePoint point;
  point.at = values_of(logs);
  const Eigen::ArrayXd values = at(logs);
  point.budgets = states(values);
  Eigen::Index binding = 0;
  excess(values).maxCoeff(&binding);
  point.binding = std::size_t(binding);
  for (std::size_t u = 0; whole && u < logs.size(); ++u) {
    // One-sided, with half of the digits, at the end of what is allowed.
    const auto moved = [&](double by, double* step) -> Eigen::ArrayXd {
      std::vector<double> there = logs;
      there[u] += by;
      try {
        const Eigen::ArrayXd moved_values = at(there);
        *step = by;
        return moved_values;
      } catch (const std::exception&) {
        *step = 0;
        return values;
      }
    };
    double up = 0, down = 0;
    const Eigen::ArrayXd above = moved(kDifference, &up), below = moved(-kDifference, &down);
    for (std::size_t k = 0; k < budgets_.size(); ++k) {
      const auto i = Eigen::Index(k);
      point.budgets[k].sensitivity.push_back(up > down ? std::log(above[i] / below[i]) / (up - down) : kNaN);
    }
  }
  return point;
}

}  // namespace aberfit::internal
