#pragma once
#include "aberfit/cases/run_cases.h"
#include "aberfit/report/sweep_report.h"

namespace aberfit {

/// The records of a plan's cases, in the order of the plan; those of other cases in the same folder are
/// passed over. A case whose record does not know the study's base is read for its id.
SweepReport gather_cases(const StudyCases& cases, const CasePlan& plan, const KnownCases& known);

/// Cases of the plan that are not known, of the shard.
std::vector<std::size_t> cases_left(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                                    const Shard& shard);

}  // namespace aberfit
