#include "verdict_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace aberfit::internal {

std::string verdict_word(Verdict verdict) {
  return verdict == Verdict::kDifferent ? "DIFFERENT" : to_string(verdict);
}

Page::Tone tone_of(Verdict verdict) {
  return verdict == Verdict::kEquivalent  ? Page::Tone::kGood
         : verdict == Verdict::kDifferent ? Page::Tone::kBad
                                          : Page::Tone::kOpen;
}

std::string signed_percent(double fraction) {
  const double value = 100.0 * fraction;
  if (!std::isfinite(value)) return "-";
  return std::abs(value) < 99.9995 ? fmt::format("{:+.3f}", value) : fmt::format("{:+.4g}", value);
}

const EquivalenceMetric* worst_of(const std::vector<EquivalenceMetric>& metrics) {
  const auto used = [](const EquivalenceMetric& m) {
    const double most = std::max(std::abs(m.interval[0]), std::abs(m.interval[1])) / m.margin;
    return std::isfinite(most) ? most : HUGE_VAL;
  };
  const EquivalenceMetric* worst = nullptr;
  for (const EquivalenceMetric& metric : metrics)
    if (!worst || used(metric) > used(*worst)) worst = &metric;
  return worst;
}

bool is_at_focus(const std::string& name) {
  const std::size_t plane = name.find('@');
  return plane == std::string::npos || name.compare(plane, 6, "@ring=") == 0 || name.starts_with("mtf@");
}

}  // namespace aberfit::internal
