#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace aberfit {

/// Physical dimension of a quantity in a study file; its SI unit is in brackets.
enum class Dimension {
  kLength,            ///< [m]
  kAngle,             ///< [rad]
  kSpatialFrequency,  ///< [cycles/m]; a cycle counts 1, not 2 pi
  kFraction,          ///< [1], also given in %
  kPsd1d,             ///< [m^3]
  kPsd2d,             ///< [m^4]
  kNumber,            ///< [1], a plain number; no unit string is allowed
  kTime,              ///< [s]; only on the command line
};

/// Thrown by parse_quantity; what() gives the text and the allowed units.
class UnitError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// SI value of a text such as "632.8 nm", "10 cycles/mm", "2.5 /m", "3.2 arcsec", "1 %". Lengths and angles
/// may be words, in any case and number ("20 Angstroms", "0.6328 micron", "2 inches"); no-break spaces count
/// as blanks. Throws UnitError for a missing, unknown or wrong unit, trailing text and non-finite numbers.
double parse_quantity(std::string_view text, Dimension dimension);

/// Factor that converts a number in `unit` to SI (table column headers, psd_unit). Throws UnitError.
double unit_factor(std::string_view unit, Dimension dimension);

/// The unit of that dimension in the name of a column, in a form for `unit_factor`: "mm" for "dz (mm)" or
/// "dz_mm", "/mm" for "f_per_mm", "nm^2 mm^2" for "psd_nm2_mm2". Empty if there is none.
std::string unit_of_column(std::string_view name, Dimension dimension);

/// Human text with a sensible prefix, e.g. 1.2e-4 m -> "120 um". For tables and messages, not for files.
std::string format_quantity(double value, Dimension dimension);
/// A fraction in percent, two significant digits and no exponent above one: "0.12 %", "270 %", "1.3e-07 %".
std::string format_percent(double share);

/// The units of a dimension for a message, e.g. "nm, um, mm, cm, m, in".
std::string allowed_units(Dimension dimension);

}  // namespace aberfit
