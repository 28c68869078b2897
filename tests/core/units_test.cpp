#include "aberfit/core/units.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <locale>
#include <numbers>
#include <string>
#include <vector>

namespace aberfit {
namespace {

struct Case {
  const char* text;
  Dimension dimension;
  double si;  // decimal literal: the double that a program would have
};

// Decimal units give exactly the double of the SI literal. 254 * 1e-4 rounds twice; see the next test.
TEST(ParseQuantity, DecimalUnitsGiveTheDoubleOfTheSiLiteral) {
  const std::vector<Case> cases = {
      {"632.8 nm", Dimension::kLength, 632.8e-9},
      {"632.8nm", Dimension::kLength, 632.8e-9},
      {"  0.4 m ", Dimension::kLength, 0.4},
      {"1 pm", Dimension::kLength, 1e-12},
      {"76.3 um", Dimension::kLength, 76.3e-6},
      {"76.3 \u00b5m", Dimension::kLength, 76.3e-6},  // micro sign
      {"76.3 \u03bcm", Dimension::kLength, 76.3e-6},  // Greek mu
      {"-1 mm", Dimension::kLength, -1e-3},
      {"1.5e1 cm", Dimension::kLength, 0.15},
      {"1.5E+1 cm", Dimension::kLength, 0.15},
      {"2 km", Dimension::kLength, 2000},
      {"36 urad", Dimension::kAngle, 36e-6},
      {"36 \u00b5rad", Dimension::kAngle, 36e-6},
      {"0.2 mrad", Dimension::kAngle, 0.2e-3},
      {"7 nrad", Dimension::kAngle, 7e-9},
      {"1 rad", Dimension::kAngle, 1},
      {"2.5 /m", Dimension::kSpatialFrequency, 2.5},
      {"2.5 1/m", Dimension::kSpatialFrequency, 2.5},
      {"2.5 cycles/m", Dimension::kSpatialFrequency, 2.5},
      {"10 cycles/mm", Dimension::kSpatialFrequency, 10e3},
      {"10 cycle/mm", Dimension::kSpatialFrequency, 10e3},
      {"10 /mm", Dimension::kSpatialFrequency, 10e3},
      {"10 lp/mm", Dimension::kSpatialFrequency, 10e3},
      {"10 mm^-1", Dimension::kSpatialFrequency, 10e3},
      {"0.1 /um", Dimension::kSpatialFrequency, 1e5},
      {"0.1 1/\u00b5m", Dimension::kSpatialFrequency, 1e5},
      {"3 /cm", Dimension::kSpatialFrequency, 300},
      {"1 %", Dimension::kFraction, 0.01},
      {"0.2%", Dimension::kFraction, 0.002},
      {"35 ppm", Dimension::kFraction, 35e-6},
      {"1 m^3", Dimension::kPsd1d, 1},
      {"2.5 nm^3", Dimension::kPsd1d, 2.5e-27},
      {"2.5 um^3", Dimension::kPsd1d, 2.5e-18},
      {"2.5 nm^2 mm", Dimension::kPsd1d, 2.5e-21},
      {"2.5 um^2 mm", Dimension::kPsd1d, 2.5e-15},
      {"2.5 nm^2/(cycle/mm)", Dimension::kPsd1d, 2.5e-21},
      {"2.5 nm\u00b2/(cycles/mm)", Dimension::kPsd1d, 2.5e-21},
      {"1 m^4", Dimension::kPsd2d, 1},
      {"2.5 nm^4", Dimension::kPsd2d, 2.5e-36},
      {"0.01 um^4", Dimension::kPsd2d, 0.01e-24},
      {"2.5 nm^2 mm^2", Dimension::kPsd2d, 2.5e-24},
      {"2.5 nm^2*mm^2", Dimension::kPsd2d, 2.5e-24},
      {"2.5 um^2 mm^2", Dimension::kPsd2d, 2.5e-18},
      {"2.5 mm^4", Dimension::kPsd2d, 2.5e-12},
      {"2.5 nm^2/(cycles/mm)^2", Dimension::kPsd2d, 2.5e-24},
      {"2.5 nm\u00b2/(cycles/mm)\u00b2", Dimension::kPsd2d, 2.5e-24},
      {"42", Dimension::kNumber, 42},
      {"0.5 s", Dimension::kTime, 0.5},
      {"60s", Dimension::kTime, 60},
      {"1.5 min", Dimension::kTime, 90},
      {"2 h", Dimension::kTime, 7200},
  };
  for (const Case& c : cases) EXPECT_EQ(parse_quantity(c.text, c.dimension), c.si) << c.text;
}

TEST(ParseQuantity, UnitsWrittenInFullAndAngstromsAreKnown) {
  const std::vector<Case> cases = {{"20 \u00c5", Dimension::kLength, 20e-10},
                                   {"20 \u212b", Dimension::kLength, 20e-10},
                                   {"20 A\u030a", Dimension::kLength, 20e-10},
                                   {"20 Angstrom", Dimension::kLength, 20e-10},
                                   {"20 angstroms", Dimension::kLength, 20e-10},
                                   {"20 \u00c5ngstr\u00f6m", Dimension::kLength, 20e-10},
                                   {"0.6328 micron", Dimension::kLength, 0.6328e-6},
                                   {"0.6328 Microns", Dimension::kLength, 0.6328e-6},
                                   {"2 millimetres", Dimension::kLength, 2e-3},
                                   {"633 Nanometers", Dimension::kLength, 633e-9},
                                   {"3 microradians", Dimension::kAngle, 3e-6},
                                   {"2.5 nm^2 micron", Dimension::kPsd1d, 2.5e-24},
                                   {"2.5 \u00c5^2 mm^2", Dimension::kPsd2d, 2.5e-26},
                                   {"10 cycles/millimeter", Dimension::kSpatialFrequency, 10e3},
                                   {"632.8\u00a0nm", Dimension::kLength, 632.8e-9},
                                   {"632.8\u202fnm", Dimension::kLength, 632.8e-9},
                                   {"\u00a0632.8 nm\u00a0", Dimension::kLength, 632.8e-9}};
  for (const Case& c : cases) EXPECT_EQ(parse_quantity(c.text, c.dimension), c.si) << c.text;
  for (const char* inch : {"2 inch", "2 Inches", "2 in"})
    EXPECT_NEAR(parse_quantity(inch, Dimension::kLength), 0.0508, 1e-17) << inch;
  // Symbols keep their case, and words must be complete.
  for (const char* wrong : {"1 MM", "1 Nm", "1 A", "1 micro", "1 meterss", "1 inc", "1 ss"})
    EXPECT_THROW(parse_quantity(wrong, Dimension::kLength), UnitError) << wrong;
}

TEST(ParseQuantity, OtherUnitsAreWithinTwoRoundings) {
  const double kTwoRoundings = 4e-16;
  const double arcsec = std::numbers::pi / 648000;
  const std::vector<Case> cases = {
      {"2 in", Dimension::kLength, 0.0508},         {"90 deg", Dimension::kAngle, std::numbers::pi / 2},
      {"1 arcmin", Dimension::kAngle, 60 * arcsec}, {"3.2 arcsec", Dimension::kAngle, 3.2 * arcsec},
      {"5 mas", Dimension::kAngle, 5e-3 * arcsec},  {"1 /in", Dimension::kSpatialFrequency, 1 / 0.0254},
  };
  for (const Case& c : cases)
    EXPECT_NEAR(parse_quantity(c.text, c.dimension) / c.si, 1, kTwoRoundings) << c.text;
}

TEST(ParseQuantity, RefusesAndSaysWhatIsAllowed) {
  struct Bad {
    const char* text;
    Dimension dimension;
    const char* fragment;
  };
  const std::vector<Bad> cases = {
      {"632.8", Dimension::kLength, "has no unit"},
      {"0.01", Dimension::kFraction, "has no unit"},
      {"", Dimension::kLength, "does not begin with a number"},
      {"nm", Dimension::kLength, "does not begin with a number"},
      {"+5 nm", Dimension::kLength, "does not begin with a number"},
      {"1,5 mm", Dimension::kLength, "\",5 mm\""},
      {"1 mm wide", Dimension::kLength, "\"mm wide\""},
      {"1 mm 2 mm", Dimension::kLength, "nm, um, mm"},
      {"5 furlong", Dimension::kLength, "nm, um, mm"},
      {"5 NM", Dimension::kLength, "\"NM\""},
      {"5 arcsec", Dimension::kLength, "a length"},
      {"5 m", Dimension::kAngle, "arcsec"},
      {"5 m^2", Dimension::kLength, "\"m^2\""},
      {"nan nm", Dimension::kLength, "not a finite number"},
      {"inf m", Dimension::kLength, "not a finite number"},
      {"1e999 m", Dimension::kLength, "not a finite number"},
      {"1e308 km", Dimension::kLength, "not a finite number"},
      {"0x10 m", Dimension::kLength, "\"x10 m\""},
      {"2 rad/m", Dimension::kSpatialFrequency, "a cycle is 1, not 2 pi"},
      {"2 m", Dimension::kSpatialFrequency, "/mm"},
      {"2 /m^2", Dimension::kSpatialFrequency, "/mm"},
      {"2 /", Dimension::kSpatialFrequency, "/mm"},
      {"2 (/m", Dimension::kSpatialFrequency, "/mm"},
      {"2 ((((((1/m))))))", Dimension::kSpatialFrequency, "/mm"},
      {"2 nm^2 mm", Dimension::kPsd2d, "2-D"},
      {"2 nm^4", Dimension::kPsd1d, "1-D"},
      {"2 nm^2/(cycles/mm", Dimension::kPsd1d, "1-D"},
      {"3 m", Dimension::kNumber, "none is allowed"},
      {"60", Dimension::kTime, "s, min, h"},
      {"60 m", Dimension::kTime, "s, min, h"},
      // Powers that do not fit into an int or a double.
      {"2 /mm^-2147483648", Dimension::kSpatialFrequency, "/mm"},
      {"2 mm^5", Dimension::kPsd2d, "2-D"},
      {"2 m^4 (((in^4)^4)^4)^4/(((m^4)^4)^4)^4", Dimension::kPsd2d, "2-D"},
      {"2 m^4 (((pm^4)^4)^4)^4/(((m^4)^4)^4)^4", Dimension::kPsd2d, "2-D"},
  };
  for (const Bad& c : cases) {
    try {
      const double value = parse_quantity(c.text, c.dimension);
      ADD_FAILURE() << c.text << " was read as " << value;
    } catch (const UnitError& error) {
      EXPECT_NE(std::string(error.what()).find(c.fragment), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find('"' + std::string(c.text) + '"'), std::string::npos)
          << error.what();
    }
  }
}

struct CommaDecimals : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

// Changes both the C++ locale (always) and the C locale (where a comma locale is installed).
TEST(ParseQuantity, IgnoresTheLocale) {
  const std::string c_before = std::setlocale(LC_ALL, nullptr);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaDecimals));
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"})
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  EXPECT_EQ(parse_quantity("632.8 nm", Dimension::kLength), 632.8e-9);
  EXPECT_EQ(format_quantity(1.25e-3, Dimension::kLength), "1.25 mm");
  std::locale::global(before);
  std::setlocale(LC_ALL, c_before.c_str());
}

TEST(ParseQuantity, AZeroMayHaveAnyExponent) {
  for (const char* text : {"0e2147483647 km", "0e-2147483648 nm", "-0.0e99999999999 km", "0e0 m"})
    EXPECT_EQ(parse_quantity(text, Dimension::kLength), 0) << text;
}

TEST(UnitFactor, IsAPositiveNumberOrRefused) {
  for (const char* unit : {"m^4 (((in^4)^4)^4)^4/(((m^4)^4)^4)^4", "m^4 (((pm^4)^4)^4)^4/(((m^4)^4)^4)^4",
                           "m^4 (((m^4)^4)^4)^4/(((pm^4)^4)^4)^4"})
    EXPECT_THROW(unit_factor(unit, Dimension::kPsd2d), UnitError) << unit;
  std::string product = "m^4";  // its power of ten does not fit into an int
  for (int i = 0; i < 200'000; ++i) product += "(((pm^4)^4)^4)^4";
  EXPECT_THROW(unit_factor(product, Dimension::kPsd2d), UnitError);
  EXPECT_EQ(unit_factor("m^4 ((km)^4)^4/((m)^4)^4", Dimension::kPsd2d), 1e48);
}

TEST(UnitFactor, ServesTableColumns) {
  EXPECT_EQ(unit_factor("1/mm", Dimension::kSpatialFrequency), 1e3);
  EXPECT_EQ(unit_factor("nm^2 mm^2", Dimension::kPsd2d), 1e-24);
  EXPECT_EQ(unit_factor("nm^2 mm", Dimension::kPsd1d), 1e-21);
  EXPECT_EQ(unit_factor("mm", Dimension::kLength), 1e-3);
  EXPECT_EQ(unit_factor("", Dimension::kFraction), 1);
  EXPECT_EQ(unit_factor("%", Dimension::kFraction), 1e-2);
  EXPECT_THROW(unit_factor("", Dimension::kLength), UnitError);
  EXPECT_THROW(unit_factor("rad/mm", Dimension::kSpatialFrequency), UnitError);
}

TEST(FormatQuantity, ChoosesAPrefixAndReadsBack) {
  EXPECT_EQ(format_quantity(1.2e-4, Dimension::kLength), "120 um");
  EXPECT_EQ(format_quantity(2.8, Dimension::kLength), "2.8 m");
  EXPECT_EQ(format_quantity(0.99999e-3, Dimension::kLength), "1 mm");  // not "1000 um"
  EXPECT_EQ(format_quantity(-3e-3, Dimension::kLength), "-3 mm");
  EXPECT_EQ(format_quantity(0, Dimension::kLength), "0 m");
  EXPECT_EQ(format_quantity(36e-6, Dimension::kAngle), "36 urad");
  EXPECT_EQ(format_quantity(39.92, Dimension::kSpatialFrequency), "39.92 /m");
  EXPECT_EQ(format_quantity(1e4, Dimension::kSpatialFrequency), "10 /mm");
  EXPECT_EQ(format_quantity(0.002, Dimension::kFraction), "0.2 %");
  EXPECT_EQ(format_quantity(2.5e-24, Dimension::kPsd2d), "2.5 nm^2 mm^2");
  EXPECT_EQ(format_quantity(2.5e-21, Dimension::kPsd1d), "2.5 nm^2 mm");
  EXPECT_EQ(format_quantity(std::nan(""), Dimension::kLength), "nan m");
  const double kShownDigits = 5e-4;  // four significant digits
  for (double value = 1.2345e-13; value < 1e6; value *= 7.3)
    EXPECT_NEAR(parse_quantity(format_quantity(value, Dimension::kLength), Dimension::kLength) / value, 1,
                kShownDigits);
}

TEST(Units, SharesAreInPercentWithoutExponents) {
  for (const auto& [share, text] : {std::pair<double, const char*>{0.0012, "0.12 %"},
                                    {0.994, "99 %"},
                                    {0.996, "100 %"},
                                    {-1.37, "-137 %"},
                                    {33, "3300 %"},
                                    {0, "0 %"}})
    EXPECT_EQ(format_percent(share), text);
}

TEST(UnitOfColumn, IsInBracketsOrBehindTheWord) {
  struct Name {
    const char* name;
    Dimension dimension;
    const char* unit;
  };
  for (const Name& c :
       {Name{"dz (mm)", Dimension::kLength, "mm"}, Name{"dz_mm", Dimension::kLength, "mm"},
        Name{"dz", Dimension::kLength, ""}, Name{"f_per_mm", Dimension::kSpatialFrequency, "/mm"},
        Name{"f [mm-1]", Dimension::kSpatialFrequency, "mm^-1"}, Name{"psd_2d_m4", Dimension::kPsd2d, "m^4"},
        Name{"psd_2d_m4", Dimension::kPsd1d, ""}, Name{"f in 1/m", Dimension::kSpatialFrequency, "1/m"},
        Name{"PSD in um^3", Dimension::kPsd1d, "um^3"}, Name{"PSD in um^3", Dimension::kPsd2d, ""},
        Name{"height in nm", Dimension::kLength, "nm"}, Name{"length (in)", Dimension::kLength, "in"},
        Name{"S (nm^2/(cycles/mm))", Dimension::kPsd1d, "nm^2/(cycles/mm)"}})
    EXPECT_EQ(unit_of_column(c.name, c.dimension), c.unit) << c.name;
}

}  // namespace
}  // namespace aberfit
