// Shards from the variables of schedulers, against examples in their manuals; every case is in one shard.
#include "aberfit/cases/shard.h"

#include <gtest/gtest.h>

#include <map>

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

Environment environment(const std::map<std::string, std::string>& variables) {
  return [variables](const std::string& name) {
    const auto found = variables.find(name);
    return found == variables.end() ? std::string() : found->second;
  };
}

void expect_shard(const std::string& text, const std::map<std::string, std::string>& variables, int index,
                  int count) {
  const Shard shard = read_shard(text, environment(variables));
  EXPECT_EQ(shard.index, index) << text;
  EXPECT_EQ(shard.count, count) << text;
}

TEST(Shard, IsWhatIsAskedOrWhatTheSchedulerSays) {
  expect_shard("", {}, 0, 1);
  expect_shard("1/4", {}, 0, 4);
  expect_shard("4/4", {{"SLURM_ARRAY_TASK_ID", "1"}, {"SLURM_ARRAY_TASK_COUNT", "9"}}, 3, 4);
  expect_shard("", {{"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_COUNT", "8"}}, 7, 8);
  expect_shard("array/8", {{"SLURM_ARRAY_TASK_ID", "8"}}, 0, 8);
  expect_shard("array/8", {{"PBS_ARRAY_INDEX", "3"}}, 3, 8);
  expect_shard("array/8", {{"PBS_ARRAYID", "3"}}, 3, 8);
  expect_shard("", {{"PBS_ARRAY_INDEX", "3"}}, 0, 1);  // PBS does not give the count
  expect_shard("", {{"SGE_TASK_ID", "undefined"}}, 0, 1);
  expect_shard(
      "", {{"SGE_TASK_ID", "5"}, {"SGE_TASK_FIRST", "1"}, {"SGE_TASK_LAST", "9"}, {"SGE_TASK_STEPSIZE", "2"}},
      2, 5);
  // A list of numbers, --array=1,3,5,7: two tasks would take the same shard, and none another.
  EXPECT_THROW(read_shard("", environment({{"SLURM_ARRAY_TASK_ID", "3"},
                                           {"SLURM_ARRAY_TASK_MIN", "1"},
                                           {"SLURM_ARRAY_TASK_MAX", "7"},
                                           {"SLURM_ARRAY_TASK_COUNT", "4"}})),
               InputError);
  for (const char* wrong : {"0/4", "5/4", "1", "1/0", "a/4", "array/4", "1/4x", "-1/4"})
    EXPECT_THROW(read_shard(wrong, environment({})), InputError) << wrong;
}

TEST(Shard, TasksOfAnArrayHaveEveryCaseOnce) {
  const auto tasks_with = [](const std::function<Shard(int)>& shard_of, int from, int to, int step) {
    for (std::size_t index = 0; index < 100; ++index) {
      int holders = 0;
      for (int id = from; id <= to; id += step) holders += shard_of(id).holds(index);
      EXPECT_EQ(holders, 1) << index;
    }
  };
  for (const int from : {0, 1}) {
    tasks_with(
        [&](int id) {
          return read_shard("", environment({{"SLURM_ARRAY_TASK_ID", std::to_string(id)},
                                             {"SLURM_ARRAY_TASK_MIN", std::to_string(from)},
                                             {"SLURM_ARRAY_TASK_COUNT", "6"}}));
        },
        from, from + 5, 1);
    tasks_with(
        [&](int id) {
          return read_shard("array/6", environment({{"PBS_ARRAY_INDEX", std::to_string(id)}}));
        },
        from, from + 5, 1);
    tasks_with(
        [&](int id) {
          return read_shard("", environment({{"SLURM_ARRAY_TASK_ID", std::to_string(id)},
                                             {"SLURM_ARRAY_TASK_MIN", std::to_string(from)},
                                             {"SLURM_ARRAY_TASK_STEP", "3"},
                                             {"SLURM_ARRAY_TASK_COUNT", "6"}}));
        },
        from, from + 15, 3);
    tasks_with(
        [&](int id) {
          return read_shard("", environment({{"SGE_TASK_ID", std::to_string(id)},
                                             {"SGE_TASK_FIRST", std::to_string(from)},
                                             {"SGE_TASK_LAST", std::to_string(from + 11)},
                                             {"SGE_TASK_STEPSIZE", "2"}}));
        },
        from, from + 11, 2);
  }
}

}  // namespace
}  // namespace aberfit
