#pragma once
#include <string>
#include <vector>

#include "aberfit/method/tost.h"
#include "aberfit/report/page.h"

namespace aberfit::internal {

/// The verdict as a word; "DIFFERENT" is in capitals, so that it is noticed.
std::string verdict_word(Verdict verdict);
Page::Tone tone_of(Verdict verdict);

/// Per cent with sign: "+1.234"; "-" if not finite.
std::string signed_percent(double fraction);

/// The metric whose interval uses most of its margin; null without metrics.
const EquivalenceMetric* worst_of(const std::vector<EquivalenceMetric>& metrics);

/// True if a statistic of this name belongs to the plane z = f.
bool is_at_focus(const std::string& name);

}  // namespace aberfit::internal
