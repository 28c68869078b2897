#pragma once

namespace aberfit::internal {

// These notes, for files and pages, explain the use of terms and scatter of a split roughness.
inline constexpr const char* kUse =
    "Give the surface the terms (coefficients.csv or an export) and the scatter function (scatter.csv) as "
    "its scatter model. Together they describe this mirror.";
inline constexpr const char* kBeware =
    "Do not use the whole PSD as scatter model of a surface that has the terms: it would count their "
    "roughness twice.";
inline constexpr const char* kUseWithoutTerms =
    "Give a smooth surface the scatter function (scatter.csv) as its scatter model. Together they describe "
    "this mirror.";
inline constexpr const char* kResidualNote =
    "The residual of the map is not added to the sum, because the specified scatter represents it.";

}  // namespace aberfit::internal
