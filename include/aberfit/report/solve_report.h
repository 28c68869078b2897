#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/report/result.h"
#include "aberfit/specify/solve.h"

namespace aberfit {

/// result.json of kind "solve"; study: the resolved study.
nlohmann::ordered_json to_json(const Specification& spec, const nlohmann::ordered_json& study,
                               const Provenance& provenance);

/// The table people read on the terminal, at most 100 columns: solutions, what binds, margins, sensitivities.
std::string summary_table(const Specification& spec);

/// contour.csv: both unknowns, then every budget's value and margin, SI units in the header, one line a
/// point; what binds in the last column.
std::string contour_csv(const Specification& spec);

/// Picture plots/contour.png of two unknowns on log-log axes, as write_plots; nothing without a contour.
std::vector<std::string> write_solve_plots(const Specification& spec, const std::string& directory,
                                           Warnings* warnings);

}  // namespace aberfit
