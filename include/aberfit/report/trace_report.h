#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/method/trace_surface.h"

namespace aberfit {

/// What `aberfit trace --json` prints: theory, model, rays, statistics of the surface and their targets,
/// warnings. study: the resolved study. What does not exist is null.
nlohmann::ordered_json to_json(const TraceReport& report, const nlohmann::ordered_json& study);

/// The table people read on the terminal.
std::string summary_table(const TraceReport& report);

}  // namespace aberfit
