#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/commands/run.h"

namespace aberfit {

/// R from which the paper's "R much larger than 1" is taken to hold.
inline constexpr double kPaperRatioForRays = 10;

/// The paper's verdict in a word: "rays", "waves" (R < 1), or "unclear" in between.
std::string paper_verdict(double ratio);

/// R = 2 sigma D/(1.22 lambda l_c) over the ranges, with kappa, g and both verdicts per cell. The surface of
/// a cell has a Gaussian autocorrelation of that correlation length, l_c = int C/C(0) dr, on a parabola of
/// `focal_length` [m] - on which neither R nor the verdict depends while angles are small.
nlohmann::ordered_json paper_table(const PaperTable& ranges, double focal_length, std::string* table);

}  // namespace aberfit
