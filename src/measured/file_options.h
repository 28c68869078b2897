#pragma once
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"

// Options supply facts that a file does not contain. Messages use study keys and words of the command line.

namespace aberfit::internal {

/// Largest relative differences at which an option agrees with the file. Pitches and units are written with
/// six digits or more, wavelengths often with three.
inline constexpr double kSamePitch = 1e-6, kSameUnit = 1e-6, kSameWavelength = 1e-3;

[[noreturn]] inline void refuse_option(const std::string& path, const std::string& option,
                                       const std::string& found, const std::string& file_says) {
  throw InputError(path, fmt::format("option '{}'", option), found,
                   file_says + ", which the file states; leave the option out");
}

/// Throws InputError that names `option` if its value is not finite, zero, or negative when `positive`.
inline void check_option(const MeasuredSource& source, const std::optional<double>& value, const char* option,
                         bool positive) {
  if (!value || (std::isfinite(*value) && *value != 0 && (!positive || *value > 0))) return;
  throw InputError(source.path, fmt::format("option '{}'", option), fmt::format("{:g}", *value),
                   positive ? "a finite number above zero" : "a finite number other than zero");
}

/// Returns the length in the file [m], otherwise the option. Throws InputError beyond a relative `tolerance`.
inline std::optional<double> agreed_length(const std::string& path, const std::string& option,
                                           const std::optional<double>& given,
                                           const std::optional<double>& said, double tolerance) {
  if (!said) return given;
  if (given && !(std::abs(*given / *said - 1) <= tolerance))
    refuse_option(path, option, format_quantity(*given, Dimension::kLength),
                  format_quantity(*said, Dimension::kLength));
  return said;
}

/// Returns the factor of the unit in the file, `unit`. Throws InputError if the option differs from it.
inline double agreed_factor(const std::string& path, const std::string& option,
                            const std::optional<double>& given, double said, const std::string& unit) {
  if (given && !(std::abs(*given / said - 1) <= kSameUnit))
    refuse_option(path, option, fmt::format("a unit of {:g} in SI", *given),
                  fmt::format("'{}' ({:g} in SI)", unit, said));
  return said;
}

/// agreed_factor for the option value_unit, which may also be waves.
inline double agreed_value_factor(const MeasuredSource& source, double said, const std::string& unit) {
  if (source.value_in_waves)
    refuse_option(source.path, "value_unit", "waves", fmt::format("'{}' ({:g} in SI)", unit, said));
  return agreed_factor(source.path, "value_unit", source.value_factor, said, unit);
}

/// Returns the factor that the options give, for a file that has none at `pointer`.
inline double given_value_factor(const MeasuredSource& source, const std::string& pointer,
                                 const std::string& found, const std::string& allowed) {
  if (source.value_factor) return *source.value_factor;
  if (!source.value_in_waves) throw MissingFact("value_unit", source.path, pointer, found, allowed);
  if (!source.wavelength)
    throw MissingFact("wavelength", source.path, pointer, "heights in waves without a wavelength",
                      "a length, or option 'wavelength'");
  return *source.wavelength;
}

/// Returns what the file states, true for a wavefront. Throws InputError if the option `of` contradicts it.
inline bool agreed_wavefront(const std::string& path, const std::optional<bool>& given, bool said) {
  const auto name = [](bool wavefront) { return wavefront ? "wavefront" : "surface"; };
  if (given && *given != said) refuse_option(path, "of", name(*given), name(said));
  return said;
}

/// Returns the factor from measured to surface heights: a reflected wavefront has twice the height.
inline double surface_per_height(bool wavefront) { return wavefront ? 0.5 : 1.0; }

}  // namespace aberfit::internal
