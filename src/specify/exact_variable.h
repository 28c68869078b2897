#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/specify/solve.h"

namespace aberfit::internal {

/// The number of the PSD's model that an unknown of a study is, so that its derivatives are exact. A study
/// may mean another one by the same word: a step of the unknown has to be the same PSD as that step of the
/// number, else nothing.
std::optional<PsdVariable> exact_variable(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                          std::size_t unknown);

/// Each unknown's start times exp(log).
std::vector<double> values_at(const std::vector<SolveUnknown>& unknowns, const std::vector<double>& logs);

/// Step of ln(unknown) of differences.
inline constexpr double kDifference = 1e-3;

}  // namespace aberfit::internal
