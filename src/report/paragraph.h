#pragma once
#include <string>

namespace aberfit {

inline constexpr std::size_t kColumns = 100;  ///< widest line of a table for people
inline constexpr std::size_t kIndent = 10;    ///< of what stands behind "Scene", "Fit", ...

/// Words of `text` on lines of at most kColumns; the first line begins with `label`, the others are indented
/// as deep as `indent`.
std::string paragraph(const std::string& label, const std::string& text, std::size_t indent = kIndent);

}  // namespace aberfit
