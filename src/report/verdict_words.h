#pragma once
#include <string>
#include <vector>

#include "aberfit/method/tost.h"
#include "aberfit/report/page.h"

namespace aberfit::internal {

/// "DIFFERENT" in capitals, so that it is seen; the others as they are.
std::string verdict_word(Verdict verdict);
Page::Tone tone_of(Verdict verdict);

/// "+1.234": percent with its sign; "-" where it is not finite.
std::string signed_percent(double fraction);

/// The metric whose interval uses most of its margin; null of none.
const EquivalenceMetric* worst_of(const std::vector<EquivalenceMetric>& metrics);

/// Whether a statistic of that name is one of the plane z = f.
bool is_at_focus(const std::string& name);

}  // namespace aberfit::internal
