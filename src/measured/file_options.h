#pragma once
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"

// What an option may add to a file: only what the file does not say itself. Messages have the names of the
// study keys and the words of the command line.

namespace aberfit::internal {

/// Relative differences up to which an option says the same as the file: pitches and units are written with
/// six digits or more, wavelengths often with three.
inline constexpr double kSamePitch = 1e-6, kSameUnit = 1e-6, kSameWavelength = 1e-3;

[[noreturn]] inline void refuse_option(const std::string& path, const std::string& option,
                                       const std::string& found, const std::string& file_says) {
  throw InputError(path, fmt::format("option '{}'", option), found,
                   file_says + ", which the file says; leave the option out");
}

/// Throws InputError naming `option` unless the option, where given, is finite and not zero (above zero when
/// `positive`).
inline void check_option(const MeasuredSource& source, const std::optional<double>& value, const char* option,
                         bool positive) {
  if (!value || (std::isfinite(*value) && *value != 0 && (!positive || *value > 0))) return;
  throw InputError(source.path, fmt::format("option '{}'", option), fmt::format("{:g}", *value),
                   positive ? "a finite number above zero" : "a finite number other than zero");
}

/// The length the file says [m], else the option's; refused when they differ by more than `tolerance`.
inline std::optional<double> agreed_length(const std::string& path, const std::string& option,
                                           const std::optional<double>& given,
                                           const std::optional<double>& said, double tolerance) {
  if (!said) return given;
  if (given && !(std::abs(*given / *said - 1) <= tolerance))
    refuse_option(path, option, format_quantity(*given, Dimension::kLength),
                  format_quantity(*said, Dimension::kLength));
  return said;
}

/// The factor of the unit the file says, else the option's; refused when they differ. `unit` is the file's.
inline double agreed_factor(const std::string& path, const std::string& option,
                            const std::optional<double>& given, double said, const std::string& unit) {
  if (given && !(std::abs(*given / said - 1) <= kSameUnit))
    refuse_option(path, option, fmt::format("a unit of {:g} in SI", *given),
                  fmt::format("'{}' ({:g} in SI)", unit, said));
  return said;
}

/// agreed_factor of the option value_unit, which may be waves.
inline double agreed_value_factor(const MeasuredSource& source, double said, const std::string& unit) {
  if (source.value_in_waves)
    refuse_option(source.path, "value_unit", "waves", fmt::format("'{}' ({:g} in SI)", unit, said));
  return agreed_factor(source.path, "value_unit", source.value_factor, said, unit);
}

/// The factor by the options, for a file that does not say it at `pointer`.
inline double given_value_factor(const MeasuredSource& source, const std::string& pointer,
                                 const std::string& found, const std::string& allowed) {
  if (source.value_factor) return *source.value_factor;
  if (!source.value_in_waves) throw MissingFact("value_unit", source.path, pointer, found, allowed);
  if (!source.wavelength)
    throw MissingFact("wavelength", source.path, pointer, "heights in waves and no wavelength",
                      "a length, or option 'wavelength'");
  return *source.wavelength;
}

/// True for a wavefront: what the file says; refused when the option `of` says the other.
inline bool agreed_wavefront(const std::string& path, const std::optional<bool>& given, bool said) {
  const auto name = [](bool wavefront) { return wavefront ? "wavefront" : "surface"; };
  if (given && *given != said) refuse_option(path, "of", name(*given), name(said));
  return said;
}

/// What heights are multiplied by to be those of the surface: light reflected at normal incidence goes over
/// every height twice.
inline double surface_per_height(bool wavefront) { return wavefront ? 0.5 : 1.0; }

}  // namespace aberfit::internal
