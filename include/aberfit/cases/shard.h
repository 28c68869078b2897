#pragma once
#include <cstddef>
#include <functional>
#include <string>

namespace aberfit {

/// The cases of one of several independent runs: every `count`-th case from `index` on.
struct Shard {
  int index = 0, count = 1;
  bool holds(std::size_t case_index) const { return int(case_index % std::size_t(count)) == index; }
};

/// Value of an environment variable, empty if it is not set.
using Environment = std::function<std::string(const std::string& name)>;

/// text: "2/8" is the second of eight; "array/8" is one of eight, chosen by the job array. Empty: from the
/// job array if it gives both numbers, else all cases. Array variables: SLURM_ARRAY_TASK_ID with _MIN, _STEP,
/// _COUNT; SGE_TASK_ID with _FIRST, _LAST, _STEPSIZE; PBS_ARRAY_INDEX and PBS_ARRAYID, which have no count.
/// An id counts modulo the number of shards, so arrays may begin with 0 or 1. Throws InputError.
Shard read_shard(const std::string& text, const Environment& environment);

std::string environment_variable(const std::string& name);

}  // namespace aberfit
