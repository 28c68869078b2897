#pragma once
#include <string>
#include <vector>

namespace aberfit::internal {

/// The shortest ends of JSON pointers that can be told apart: "/roughness/psd/rms" and "/mirror/focal_length"
/// give "rms" and "focal_length", "/roughness/psd/parts/0/rms" and ".../1/rms" give "0/rms" and "1/rms".
std::vector<std::string> short_labels(const std::vector<std::string>& pointers);

}  // namespace aberfit::internal
