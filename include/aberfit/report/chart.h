#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/report/result.h"

namespace aberfit {

/// chart.csv: one line per row, all of its members and its family's descriptions, SI units in the header;
/// what does not exist is empty.
std::string chart_csv(const Chart& chart);

/// chart.json; what does not exist is null. study: the resolved study.
nlohmann::ordered_json to_json(const Chart& chart, const nlohmann::ordered_json& study,
                               const Provenance& provenance);

/// The table people read on the terminal, at most 100 columns: per family the setting of today, the cheapest
/// one that meets the tolerance, and what the first costs more.
std::string summary_table(const Chart& chart);

/// "rays, rays 65,536", "terms and scatter, f_c 12.5 /m": a row by its setting.
std::string setting_text(const ChartRow& row);

/// Pictures below `directory`/plots: one per family, error against time with the frontier, today's setting
/// and the cheapest within tolerance marked. As write_plots.
std::vector<std::string> write_chart_plots(const Chart& chart, const std::string& directory,
                                           Warnings* warnings);

}  // namespace aberfit
