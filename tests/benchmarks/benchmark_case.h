#pragma once
#include <benchmark/benchmark.h>

#include <functional>
#include <string>

#include "benchmark_numbers.h"

/// Benchmark rows with their times and errors. A row is named "case/setting". print_table.py reads its
/// counters: `error` and `allowed`, `rate:UNIT` (work per second), `ratio:OTHER` (time over that of another
/// way, both timed alternately in the same run).
namespace aberfit::benchmarks {

/// One row: the timed part, called once per repetition.
using Timed = std::function<void(benchmark::State&)>;

/// Registers a row. `prepare` builds the timed part when the row first runs, so that a filter skips the
/// others. Its result is kept for the repetitions of the row and dropped when another row starts.
void add_case(const std::string& name, const std::function<Timed()>& prepare);

/// Each benchmark program defines this; it calls add_case for its rows. `smoke`: every row runs once and only
/// its error counts, so long cases should be smaller.
void register_cases(bool smoke);

/// States the error of the row's result and the allowed one. A larger error, or a NaN, makes the program
/// fail.
void report_error(benchmark::State& state, double error, double allowed);

/// States the work done by one iteration, shown as rate; `unit` is, for example, "rays".
void report_rate(benchmark::State& state, const std::string& unit, double work);

/// States the time of the row by a cost model [s].
void report_prediction(benchmark::State& state, double seconds);

/// Runs `ours` and `other` in turns, `other` until it has taken 0.3 s. The row's time is that of `ours`;
/// ratio: median time of `ours` over median time of `other`.
void time_against(benchmark::State& state, const std::function<void()>& ours,
                  const std::string& name_of_other, const std::function<void()>& other);

/// Runs `ours` alone.
void time_alone(benchmark::State& state, const std::function<void()>& ours);

}  // namespace aberfit::benchmarks
