#include "aberfit/cases/run_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <new>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/text.h"
#include "aberfit/study/field_errors.h"

namespace aberfit {
namespace {

std::string key_of(const std::string& base, const CaseValues& at) {
  std::string key = base;
  for (const auto& [pointer, value] : at) key += "\n" + pointer + "=" + value;
  return key;
}

// Non-empty text of the current exception, without the study's name; rethrows one that ends the run.
std::string text_of_current_error() {
  try {
    throw;
  } catch (const Interrupted&) {
    throw;
  } catch (const InputError& error) {
    return fmt::format("{}: {}; allowed: {}", error.pointer(), error.found(), error.allowed());
  } catch (const std::bad_alloc&) {
    return "not enough memory";
  } catch (const std::exception& error) {
    return *error.what() ? error.what() : "an error without a message";
  }
}

// Ids that this process has started or finished.
class Claims {
 public:
  bool take(const std::string& id) {
    const std::lock_guard lock(mutex_);
    return ids_.insert(id).second;
  }

 private:
  std::mutex mutex_;
  std::unordered_set<std::string> ids_;
};

// Runs one case; false if it is known already.
bool run_one(const StudyCases& cases, const CaseWork& work, const KnownCases& known, Claims* claims,
             CaseRecord* record) {
  const auto begin = std::chrono::steady_clock::now();
  std::optional<Study> of_case;
  try {
    of_case = cases.at(record->at);
    record->id = cases.id(*of_case);
  } catch (...) {
    record->error = text_of_current_error();
    record->id = cases.id_of_unreadable(record->at);
  }
  if (known.find_id(record->id) || !claims->take(record->id)) return false;
  try {
    if (record->error.empty())
      static_cast<CaseOutcome&>(*record) = with_fields_of(*of_case, [&] { return work(*of_case); });
  } catch (...) {
    record->error = text_of_current_error();
  }
  record->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return true;
}

}  // namespace

KnownCases::KnownCases(std::vector<CaseRecord> records) : records_(std::move(records)) {
  for (std::size_t k = 0; k < records_.size(); ++k) {
    // A result has priority over a failure.
    const auto keep = [&](std::size_t* known) {
      if (!records_[*known].error.empty() && records_[k].error.empty()) *known = k;
    };
    keep(&by_id_.emplace(records_[k].id, k).first->second);
    if (!records_[k].base.empty())
      keep(&by_values_.emplace(key_of(records_[k].base, records_[k].at), k).first->second);
  }
}

const CaseRecord* KnownCases::find(const std::string& base, const CaseValues& at) const {
  if (base.empty()) return nullptr;
  const auto found = by_values_.find(key_of(base, at));
  return found == by_values_.end() ? nullptr : &records_[found->second];
}

const CaseRecord* KnownCases::find_id(const std::string& id) const {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : &records_[found->second];
}

CaseCounts run_cases(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                     const CaseWork& work, CaseQueue* queue, CaseJournal* journal,
                     const RunContext& context) {
  Claims claims;
  std::atomic<std::size_t> done = 0, failed = 0;
  std::atomic<bool> end = false;
  parallel_for(std::size_t(std::max(context.threads, 1)), context.threads, [&](std::size_t) {
    while (!end && !context.stopped()) {
      const std::optional<std::size_t> index = queue->next();
      if (!index) return;
      CaseRecord record;
      record.base = cases.base();
      record.index = *index;
      record.at = plan.at(*index);
      try {
        if (!run_one(cases, work, known, &claims, &record)) continue;
        journal->add(record);
      } catch (const Interrupted&) {
        return;
      } catch (...) {
        end = true;  // the records cannot be written, so all threads stop
        throw;
      }
      ++(record.error.empty() ? done : failed);
      if (context.progress) context.progress("");
    }
  });
  journal->sync();
  return {done, failed};
}

void check_pointers(const StudyCases& cases, const CasePlan& plan) {
  constexpr std::size_t kTried = 20;
  const CaseValues first = plan.at(0);
  for (std::size_t k = 0; k < first.size(); ++k) {
    std::vector<std::string> values = plan.values(std::min(k, plan.axes() - 1));
    if (k >= plan.axes() || values.empty()) values = {first[k].second};
    values.resize(std::min(values.size(), kTried));
    std::exception_ptr problem;
    for (const std::string& value : values) {
      try {
        cases.at({{first[k].first, value}});
        problem = nullptr;
        break;
      } catch (const InputError&) {
        if (!problem) problem = std::current_exception();
      }
    }
    // Values may depend on each other; a first case that can be read is proof as well.
    if (!problem) continue;
    try {
      cases.at(first);
      return;
    } catch (const InputError&) {
      std::rethrow_exception(problem);
    }
  }
}

std::string progress_text(std::size_t done, std::size_t all, std::size_t failed, double seconds) {
  std::string text = fmt::format("{} of {} cases", grouped(double(done)), grouped(double(all)));
  if (done > 0 && seconds > 0) {
    const double rate = double(done) / seconds, left = double(all - std::min(all, done)) / rate;
    text +=
        rate >= 1 ? fmt::format(", {:.3g} per second", rate) : fmt::format(", {:.3g} s per case", 1 / rate);
    text += left < 100    ? fmt::format(", {:.0f} s left", left)
            : left < 6000 ? fmt::format(", {:.0f} min left", left / 60)
                          : fmt::format(", {:.1f} h left", left / 3600);
  }
  if (failed > 0) text += fmt::format(", {} failed", grouped(double(failed)));
  return text;
}

}  // namespace aberfit
