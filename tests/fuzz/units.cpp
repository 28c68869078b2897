// Texts with units.
#include "aberfit/core/units.h"

#include <cmath>

#include "harness.h"
#include "targets.h"

namespace aberfit::test {
namespace {

constexpr Dimension kAllDimensions[] = {Dimension::kLength,   Dimension::kAngle, Dimension::kSpatialFrequency,
                                        Dimension::kFraction, Dimension::kPsd1d, Dimension::kPsd2d,
                                        Dimension::kNumber};

void read_units(std::string_view text) {
  for (const Dimension dimension : kAllDimensions) {
    try {
      const double value = parse_quantity(text, dimension);
      require(std::isfinite(value), "a quantity is finite");
      format_quantity(value, dimension);
    } catch (const UnitError&) {
    }
    try {
      const double factor = unit_factor(text, dimension);
      require(factor > 0 && std::isfinite(factor), "the factor of a unit is positive and finite");
    } catch (const UnitError&) {
    }
  }
}

std::vector<std::string> unit_seeds() {
  return {"632.8 nm",   "10 cycles/mm",  "2.5 /m",      "3.2 arcsec",         "1 %",
          "-1.5e-3 in", "12 ppm",        "nm^2 mm",     "um^2/(lp/mm)^2",     "1e-21 m^4",
          "7",          "3 nm\u00b2 mm", "4 \u00b5rad", "1/(nm^-2 (mm)^2)^2", "0.5 um*um/mm^-1",
          "+1e+2 km",   "0.0 m",         "2 mas"};
}

}  // namespace

std::vector<FuzzTarget> unit_targets() { return {{"units", read_units, unit_seeds, 256}}; }

}  // namespace aberfit::test
