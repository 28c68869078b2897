#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/report/result.h"
#include "aberfit/specify/psd_of_focus.h"

namespace aberfit {

/// result.json of kind "psd-of-focus"; study: the resolved study.
nlohmann::ordered_json to_json(const PsdOfFocus& result, const nlohmann::ordered_json& study,
                               const Provenance& provenance);

/// The table people read on the terminal, at most 100 columns: numbers with their intervals, correlations,
/// how well the light is described.
std::string summary_table(const PsdOfFocus& result);

/// focus.csv: radius, measured and fitted light, noise and one mirror's own spread, residual over both; SI
/// units in the header, one line a circle or ring.
std::string focus_csv(const PsdOfFocus& result);

/// Picture plots/focus.png: measured light with its noise and that of the fitted roughness, and below it what
/// is left in standard deviations.
std::vector<std::string> write_focus_plots(const PsdOfFocus& result, const std::string& directory,
                                           Warnings* warnings);

}  // namespace aberfit
