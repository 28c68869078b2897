#pragma once
#include <string>

#include "aberfit/core/units.h"
#include "aberfit/core/warning.h"
#include "aberfit/measured/clear_aperture.h"

namespace aberfit::internal {

inline constexpr std::size_t kColumns = 100;  ///< widest line of a table for people
inline constexpr std::size_t kIndent = 10;    ///< indent of the text after "Scene", "Fit", ...

/// Words of `text` on lines of at most `width` columns. The first line begins with `label`, the others have
/// `indent` blanks.
std::string paragraph(const std::string& label, const std::string& text, std::size_t indent = kIndent,
                      std::size_t width = kColumns);

/// Words of `text` on lines of at most `width` columns, not counting the indent of all lines but the first.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

/// "1 ray", "2 rays".
std::string plural(long count, const std::string& thing);

/// "; clear aperture: ...; 12 samples left out"; empty if the whole measurement is used.
std::string clear_text(const ClearRegion& clear);
/// Value with four significant digits, so that the numbers of a row align: 100.0 nm beside 100.2 nm. A value
/// that does not exist gives "-".
std::string four_digits(double value, Dimension dimension);

/// A length in a suitable unit.
std::string metres_text(double metres);

/// The pitches of a map: "1 mm along x and y", "1 mm along x, 0.25 mm along y".
std::string pitches_text(double pitch_x, double pitch_y);

}  // namespace aberfit::internal
