#pragma once

namespace aberfit::internal {

// These notes, for files and pages, explain the use of terms and scatter of a split roughness.
inline constexpr const char* kUse =
    "Give the surface the terms (coefficients.csv or an export) and, as its scatter model, the scatter "
    "function (scatter.csv): together they are this mirror.";
inline constexpr const char* kBeware =
    "Not the whole PSD: a scatter model of all of it on a surface that has the terms counts their roughness "
    "twice.";
inline constexpr const char* kUseWithoutTerms =
    "Give a smooth surface the scatter function (scatter.csv) as its scatter model: that is this mirror.";
inline constexpr const char* kResidualNote =
    "What the terms leave of the map is not added to the sum: the scatter stands for it, as specified.";

}  // namespace aberfit::internal
