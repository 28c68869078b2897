#include "aberfit/method/judged_set.h"

#include <algorithm>
#include <set>

namespace aberfit {

double margin_of(const Target& target, const EquivalenceSpec& asked) {
  const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic);
  if (!asked.stray_light || !ee || !target.curve_slope) return asked.margin;
  return std::min(asked.margin, *asked.stray_light * (1 - ee->fraction) / aim_of(target).scale);
}

JudgedSet::JudgedSet(const std::vector<Target>& fitted, const std::vector<Target>& held_out)
    : targets_(fitted), fitted_(fitted.size()) {
  targets_.insert(targets_.end(), held_out.begin(), held_out.end());
  statistics_ = statistics_of(targets_);
  for (std::size_t k = 0; k < targets_.size(); ++k) {
    const Target aim = aim_of(targets_[k]);
    if (aim.statistic.index() == targets_[k].statistic.index()) {
      judged_at_.push_back(Eigen::Index(k));
    } else {
      judged_at_.push_back(Eigen::Index(statistics_.size()));
      statistics_.push_back(aim.statistic);
    }
  }
}

Eigen::VectorXd JudgedSet::shown(const Eigen::VectorXd& values) const {
  return values.head(Eigen::Index(targets_.size()));
}

Eigen::VectorXd JudgedSet::judged(const Eigen::VectorXd& values) const {
  Eigen::VectorXd result(Eigen::Index(targets_.size()));
  for (Eigen::Index k = 0; k < result.size(); ++k) result[k] = values[judged_at_[std::size_t(k)]];
  return result;
}

std::vector<Eigen::Index> JudgedSet::places_of(const std::vector<std::size_t>& targets) const {
  std::set<Eigen::Index> places;
  for (const std::size_t target : targets) places.insert({Eigen::Index(target), judged_at_[target]});
  return {places.begin(), places.end()};
}

std::vector<std::size_t> JudgedSet::open_targets(const FreshStatistics& fresh,
                                                 const std::vector<EquivalenceMetric>& metrics) const {
  const auto known = [this](const Eigen::VectorXd& of) {
    return (shown(of).array().isFinite() && judged(of).array().isFinite()).eval();
  };
  const auto value = known(fresh.value), error = known(fresh.standard_error);
  std::vector<std::size_t> open;
  for (std::size_t k = 0; k < targets_.size(); ++k) {
    const auto at = Eigen::Index(k);
    if (!value[at] || !error[at] || metrics[k].verdict == Verdict::kUndecided) open.push_back(k);
  }
  return open;
}

void JudgedSet::add_to_judged(const Eigen::VectorXd& more, Eigen::VectorXd* values) const {
  for (Eigen::Index k = 0; k < more.size(); ++k) (*values)[judged_at_[std::size_t(k)]] += more[k];
}

std::vector<EquivalenceMetric> JudgedSet::judge(const FreshStatistics& fresh,
                                                const EquivalenceSpec& asked) const {
  std::vector<EquivalenceMetric> metrics;
  const Eigen::VectorXd aims = judged(fresh.value), errors = judged(fresh.standard_error);
  for (std::size_t k = 0; k < targets_.size(); ++k) {
    const auto at = Eigen::Index(k);
    const double sampling = fresh.errors_are_bounds ? 0.0 : errors[at];
    metrics.push_back(judge_target(targets_[k], k >= fitted_, fresh.value[at], aims[at], sampling,
                                   margin_of(targets_[k], asked), asked.confidence,
                                   fresh.degrees_of_freedom));
    if (fresh.errors_are_bounds)
      metrics.back() = with_model_error(metrics.back(), errors[at] / aim_of(targets_[k]).relative_to());
  }
  return metrics;
}

}  // namespace aberfit
