#pragma once
#include <nlohmann/json_fwd.hpp>

#include "aberfit/chart/chart.h"
#include "aberfit/chart/check.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/method/verify.h"
#include "aberfit/report/page.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result.h"
#include "aberfit/report/sweep_report.h"
#include "aberfit/specify/ceilings.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/specify/solve.h"

namespace aberfit {

// Each kind of result becomes the JSON document of result.json, and a page for people. Numbers of a document
// are in SI units, named by its keys; numbers that do not exist are null. results_schema gives the meaning of
// each key. study: the resolved study.

nlohmann::ordered_json to_json(const ResultDocument& result, const nlohmann::ordered_json& study);
nlohmann::ordered_json to_json(const CheckReport& report, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const MapCheckReport& report, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const TraceReport& report, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const VerifyReport& report, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const Specification& spec, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const Ceilings& ceilings, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const PsdOfFocus& result, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const SweepReport& report, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
nlohmann::ordered_json to_json(const Chart& chart, const nlohmann::ordered_json& study,
                               const Provenance& provenance = {});
/// request: every option as a `psd` block of model `measured`; roughness: the fitted model as a `roughness`
/// block of a study.
nlohmann::ordered_json to_json(const PsdReport& report, const nlohmann::ordered_json& request,
                               const nlohmann::ordered_json& roughness);

/// JSON Schema (draft 2020-12) of all these documents, one alternative per kind. Every key has its meaning as
/// "description" and its SI unit as "unit".
nlohmann::ordered_json results_schema();

/// all: shows every statistic, not only those in focus and the worst of the rest.
Page page_of(const ResultDocument& result, bool all);
Page page_of(const CheckReport& report);
Page page_of(const MapCheckReport& report);
Page page_of(const TraceReport& report);
Page page_of(const VerifyReport& report);
Page page_of(const Specification& spec);
Page page_of(const Ceilings& ceilings);
Page page_of(const PsdOfFocus& result);
Page page_of(const SweepReport& report);
Page page_of(const Chart& chart);
Page page_of(const PsdReport& report, const nlohmann::ordered_json& roughness);

}  // namespace aberfit
