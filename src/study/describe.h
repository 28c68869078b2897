#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

// The only description of the study format, version 1. It shows a visitor every key and its place in the
// study.
namespace aberfit::internal {

/// The whole file. Called on the root object.
void describe_study(Visitor& v, Study& study);
/// The `roughness` block.
void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness);
/// The keys of its `psd` object.
void describe_psd_block(Visitor& v, RoughnessModel& node);
/// The keys of `psd.model: "measured"`; also the options of `aberfit psd FILE`.
void describe_measured_psd(Visitor& v, MeasuredPsd& measured);
/// The `target` block: statistics and PSD bins, or a map.
void describe_target(Visitor& v, TargetSpec& target, std::optional<MapTarget>& map, double focal_length);
/// The keys of target.map.
void describe_map_target(Visitor& v, MapTarget& target);

/// A length in the plane of the focus, or an angle on the sky. An angle stays a text, because only f turns it
/// into a length.
void describe_extent_in_focus(Visitor& v, const Field& field,
                              std::optional<std::variant<std::string, double>>& value);
/// The keys of solve.focus.
void describe_focus(Visitor& v, FocusSpec& focus);
/// The `solve` block.
void describe_solve(Visitor& v, SolveSpec& solve);
/// The `vary` block.
void describe_vary(Visitor& v, VarySpec& vary);

/// Reports `key` unless `unit` belongs to the dimension. more: what else the message says is allowed.
void check_unit(Visitor& v, const char* key, const std::string& unit, Dimension dimension,
                const std::string& more = "");
/// Reports `f_max` unless it is above `f_min`.
void require_band(Visitor& v, double f_min, double f_max);

using enum Need;
using enum Dimension;
inline constexpr Dimension kFrequency = kSpatialFrequency;

}  // namespace aberfit::internal
