#include "aberfit/cases/shard.h"

#include <fmt/format.h>

#include <cstdlib>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"

namespace aberfit {
namespace {

constexpr int kMostShards = 1000000;

struct ArrayTask {
  long id = 0;
  long count = 0;  // 0: unknown
  bool has_gaps = false;
};

std::optional<long> number_in(const Environment& environment, const std::string& name) {
  return parse_number<long>(environment(name));
}

// Task numbers of an array: first, first + step, ...
struct TaskNumbers {
  long first, step;
  // An array without a step may begin anywhere.
  long place(long id) const { return step > 1 ? (id - first) / step : id; }
  long count(long last) const { return (last - first) / step + 1; }
};

// The task that the scheduler gives; SGE writes "undefined" outside of arrays.
std::optional<ArrayTask> array_task(const Environment& environment) {
  if (const auto id = number_in(environment, "SLURM_ARRAY_TASK_ID")) {
    const TaskNumbers numbers{number_in(environment, "SLURM_ARRAY_TASK_MIN").value_or(0),
                              std::max(1l, number_in(environment, "SLURM_ARRAY_TASK_STEP").value_or(1))};
    const long count = number_in(environment, "SLURM_ARRAY_TASK_COUNT").value_or(0);
    const auto last = number_in(environment, "SLURM_ARRAY_TASK_MAX");
    // For a list, --array=1,3,7, the position of this number is unknown.
    return ArrayTask{numbers.place(*id), count, count > 1 && last && numbers.count(*last) != count};
  }
  for (const char* name : {"PBS_ARRAY_INDEX", "PBS_ARRAYID"})
    if (const auto id = number_in(environment, name)) return ArrayTask{*id, 0};
  if (const auto id = number_in(environment, "SGE_TASK_ID")) {
    const TaskNumbers numbers{number_in(environment, "SGE_TASK_FIRST").value_or(1),
                              std::max(1l, number_in(environment, "SGE_TASK_STEPSIZE").value_or(1))};
    const auto last = number_in(environment, "SGE_TASK_LAST");
    return ArrayTask{numbers.place(*id), last ? numbers.count(*last) : 0};
  }
  return std::nullopt;
}

[[noreturn]] void refuse_shard(const std::string& found) {
  throw InputError("command line", "", found,
                   "--shard i/n with i from 1 to n, or --shard array/n inside a job array of n tasks");
}

}  // namespace

Shard read_shard(const std::string& text, const Environment& environment) {
  const std::optional<ArrayTask> task = array_task(environment);
  if (text.empty()) {
    if (!task || task->count < 2 || task->count > kMostShards || task->id < 0) return {};
    if (task->has_gaps) refuse_shard("a job array with gaps in its numbers");
    return {int(task->id % task->count), int(task->count)};
  }
  const std::string found = fmt::format("--shard \"{}\"", text);
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) refuse_shard(found);
  const std::optional<int> count = parse_number<int>(text.substr(slash + 1));
  if (!count || *count < 1 || *count > kMostShards) refuse_shard(found);
  if (text.substr(0, slash) == "array") {
    if (!task || task->id < 0) refuse_shard(found + " outside of a job array of SLURM, PBS or SGE");
    return {int(task->id % *count), *count};
  }
  const std::optional<int> index = parse_number<int>(text.substr(0, slash));
  if (!index || *index < 1 || *index > *count) refuse_shard(found);
  return {*index - 1, *count};
}

std::string environment_variable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value ? value : "";
}

}  // namespace aberfit
