#include <fmt/format.h>

#include <cmath>

#include "aberfit/roughness/psd.h"
#include "psd_models.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kHighestEnd = 1e30;  // largest f_max [cycles/m]; atoms correspond to 1e10

// Comparisons are negated so that NaN is a problem too.
std::string band_problem(double f_min, double f_max) {
  if (!(f_min >= 0) || !std::isfinite(f_min))
    return fmt::format("f_min is {:g} /m, it must be finite and not negative", f_min);
  if (!(f_max > f_min))
    return fmt::format("f_max ({:g} /m) must be greater than f_min ({:g} /m)", f_max, f_min);
  // From 1e77 on, powers of f_max overflow, so integrals would be wrong without notice.
  if (std::isfinite(f_max) && f_max > kHighestEnd)
    return fmt::format(
        "f_max is {:g} /m, it must be at most {:g} /m; leave it out for a band without upper end", f_max,
        kHighestEnd);
  return "";
}

template <class Model>
std::string problem(Model m) {
  double f_min = 0;
  for (const ModelNumber& number : rules(m).numbers(m))
    for (const double x : number.values) {
      if (number.role == PsdRole::kRms && !is_positive(x))
        return fmt::format("rms is {:g} m, it must be positive and finite", x);
      if (number.role == PsdRole::kLowest) f_min = x;
      if (number.role != PsdRole::kHighest) continue;
      if (std::string text = band_problem(f_min, x); !text.empty()) return text;
    }
  return rules(m).problem(m);
}

std::string problem(const SumPsd& m) {
  if (m.parts.empty()) return "a sum needs at least one part";
  for (std::size_t i = 0; i < m.parts.size(); ++i) {
    const std::string text = psd_problem(m.parts[i]);
    if (!text.empty()) return fmt::format("part {} of the sum: {}", i + 1, text);
  }
  return "";
}

}  // namespace

std::string psd_problem(const PsdModel& model) {
  return std::visit([](const auto& m) { return problem(m); }, model);
}

}  // namespace aberfit
