#pragma once
#include "aberfit/cases/run_cases.h"
#include "aberfit/report/sweep_report.h"

namespace aberfit {

/// The records of a plan's cases, in the order of the plan; records of other cases in the folder are ignored.
/// A record that does not contain the study's base is found by the id of its case.
SweepReport gather_cases(const StudyCases& cases, const CasePlan& plan, const KnownCases& known);

/// Cases of the plan in this shard that have no record.
std::vector<std::size_t> cases_left(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                                    const Shard& shard);

}  // namespace aberfit
