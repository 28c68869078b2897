#pragma once
#include <cstddef>
#include <functional>
#include <string>

namespace aberfit {

/// The cases of one of several runs that know nothing of each other: every `count`-th from `index` on.
struct Shard {
  int index = 0, count = 1;
  bool holds(std::size_t case_index) const { return int(case_index % std::size_t(count)) == index; }
};

/// Value of an environment variable, empty where it is not set.
using Environment = std::function<std::string(const std::string& name)>;

/// text: "2/8", the second of eight; "array/8", of eight the one that the job array says; empty: what the job
/// array says where it says both, else all. Array variables: SLURM_ARRAY_TASK_ID with _MIN, _STEP, _COUNT;
/// SGE_TASK_ID with _FIRST, _LAST, _STEPSIZE; PBS_ARRAY_INDEX, PBS_ARRAYID, which have no count. An id counts
/// modulo the number of shards, so arrays may begin with 0 or 1. Throws InputError.
Shard read_shard(const std::string& text, const Environment& environment);

/// Of the process.
std::string environment_variable(const std::string& name);

}  // namespace aberfit
