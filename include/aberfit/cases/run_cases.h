#pragma once
#include <functional>
#include <map>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "aberfit/cases/case_plan.h"
#include "aberfit/cases/journal.h"
#include "aberfit/cases/team.h"
#include "aberfit/method/run_context.h"

namespace aberfit {

/// The computation of one case, in one thread. It throws `Interrupted` if the case must be done another time;
/// any other exception makes it a failed case.
using CaseWork = std::function<CaseOutcome(const Study&)>;

/// Records of earlier runs.
class KnownCases {
 public:
  KnownCases() = default;
  explicit KnownCases(std::vector<CaseRecord> records);
  /// Record by base and values, without reading the case; null if it is unknown, or known only by its id.
  const CaseRecord* find(const std::string& base, const CaseValues& at) const;
  const CaseRecord* find_id(const std::string& id) const;
  bool empty() const { return records_.empty(); }

 private:
  std::vector<CaseRecord> records_;
  std::unordered_map<std::string, std::size_t> by_values_, by_id_;
};

struct CaseCounts {
  std::size_t done = 0, failed = 0;
};

/// Runs the cases of `queue` on context.threads threads, one thread per case, until none is left or the
/// context is interrupted, and records each. A case with a known id is skipped; a failed case is recorded
/// with the text of its error. Throws InputError if the records cannot be written.
CaseCounts run_cases(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                     const CaseWork& work, CaseQueue* queue, CaseJournal* journal, const RunContext& context);

/// Throws the reading error if no value of one of the plan's pointers can be read by itself. Then the pointer
/// or the kind of value is wrong, not a case.
void check_pointers(const StudyCases& cases, const CasePlan& plan);

/// "1,200 of 2,000 cases, 85 a second, 9 s left, 3 failed".
std::string progress_text(std::size_t done, std::size_t all, std::size_t failed, double seconds);

}  // namespace aberfit
