#pragma once
#include <string_view>

namespace aberfit::internal {

/// First words of the text formats of instruments.
inline constexpr std::string_view kZygoXyzTitle = "Zygo XYZ Data File";
inline constexpr std::string_view kZygoAsciiTitle = "Zygo ASCII Data File";
inline constexpr std::string_view kWykoTextTitle = "Wyko ASCII Data File Format";

}  // namespace aberfit::internal
