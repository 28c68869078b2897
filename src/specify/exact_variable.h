#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/specify/solve.h"

namespace aberfit::internal {

/// Returns the parameter of the PSD model that equals an unknown of a study, for exact derivatives. Empty
/// unless a step of both gives the same PSD, because a study may use the same word for another quantity.
std::optional<PsdVariable> exact_variable(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                          std::size_t unknown);

/// Returns start times exp(log) of each unknown.
std::vector<double> values_at(const std::vector<SolveUnknown>& unknowns, const std::vector<double>& logs);

/// Step of ln(unknown) in differences.
inline constexpr double kDifference = 1e-3;

}  // namespace aberfit::internal
