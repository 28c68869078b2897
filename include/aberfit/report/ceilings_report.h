#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/report/result.h"
#include "aberfit/specify/ceilings.h"

namespace aberfit {

/// result.json of kind "ceilings"; study: the resolved study. What no height violates is null.
nlohmann::ordered_json to_json(const Ceilings& ceilings, const nlohmann::ordered_json& study,
                               const Provenance& provenance);

/// The tables people read on the terminal, at most 100 columns.
std::string summary_table(const Ceilings& ceilings);

/// ceilings.csv: an octave a line, SI units in the header; empty fields where no height violates a budget.
std::string ceilings_csv(const Ceilings& ceilings);

/// Picture plots/ceilings.png, profile PSD over frequency on log-log axes, as write_plots.
std::vector<std::string> write_ceilings_plots(const Ceilings& ceilings, const std::string& directory,
                                              Warnings* warnings);

}  // namespace aberfit
