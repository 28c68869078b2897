#pragma once
#include <string>
#include <vector>

namespace aberfit::internal {

/// The shortest distinct ends of JSON pointers: "/roughness/psd/rms" and "/mirror/focal_length" give "rms"
/// and "focal_length", "/roughness/psd/parts/0/rms" and ".../1/rms" give "0/rms" and "1/rms".
std::vector<std::string> short_labels(const std::vector<std::string>& pointers);

}  // namespace aberfit::internal
