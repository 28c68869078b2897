#include "exact_variable.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

// The correlation length of a k-correlation is B/(2 pi), which has the same logarithmic derivative.
PsdVariable variable_at(const PsdModel& model, const std::string& pointer) {
  const std::string length = "/correlation_length";
  try {
    return psd_variable(model, pointer);
  } catch (const std::invalid_argument&) {
    if (!pointer.ends_with(length)) throw;
    return psd_variable(model, pointer.substr(0, pointer.size() - length.size()) + "/B");
  }
}

}  // namespace

std::vector<double> values_at(const std::vector<SolveUnknown>& unknowns, const std::vector<double>& logs) {
  std::vector<double> values;
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    values.push_back(logs[k] == 0 ? unknowns[k].start : unknowns[k].start * std::exp(logs[k]));
  return values;
}

std::optional<PsdVariable> exact_variable(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                          std::size_t unknown) {
  constexpr double kSamePsd = 1e-9;  // relative, of S
  const std::string root = "/roughness/psd", &pointer = unknowns[unknown].pointer;
  if (pointer.rfind(root, 0) != 0) return std::nullopt;
  std::vector<double> logs(unknowns.size(), 0.0);
  const Task here = task_at(values_at(unknowns, logs));
  try {
    const PsdVariable variable = variable_at(*here.psd, pointer.substr(root.size()));
    logs[unknown] = kDifference;
    const RadialPsd meant(*task_at(values_at(unknowns, logs)).psd),
        moved(with_value(*here.psd, variable, value_of(*here.psd, variable) * std::exp(kDifference)));
    const double low = std::max(meant.f_min(), 1e-3), high = std::min(meant.f_max(), 1e9);
    for (int k = 0; k < 40; ++k) {
      const double f = low * std::pow(high / low, (k + 0.5) / 40), s = meant(f);
      if (!(std::abs(moved(f) - s) <= kSamePsd * s)) return std::nullopt;
    }
    return variable;
  } catch (const std::invalid_argument&) {
  } catch (const InputError&) {  // at the end of the allowed range
  }
  return std::nullopt;
}

}  // namespace aberfit::internal
