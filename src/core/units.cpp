#include "aberfit/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/text.h"

namespace aberfit {
namespace {

// A unit is factor * 10^exponent10 SI units. The power of ten is separate so that "632.8 nm" becomes the
// double nearest to 632.8e-9, as in a program: the exponent is added to the text before conversion.
struct Unit {
  double factor = 1;
  int exponent10 = 0;
};

struct NamedUnit {
  std::string_view name;
  Unit unit;
};

constexpr NamedUnit kLengths[] = {{"pm", {1, -12}},
                                  {"nm", {1, -9}},
                                  {"um", {1, -6}},
                                  {"\u00b5m", {1, -6}},
                                  {"\u03bcm", {1, -6}},
                                  {"mm", {1, -3}},
                                  {"cm", {1, -2}},
                                  {"m", {1, 0}},
                                  {"km", {1, 3}},
                                  {"in", {254, -4}},
                                  // The letter A with ring as one character, as two, and the unit sign.
                                  {"\u00c5", {1, -10}},
                                  {"A\u030a", {1, -10}},
                                  {"\u212b", {1, -10}}};
// Words may be in any case, singular or plural; symbols may not.
constexpr NamedUnit kLengthWords[] = {{"angstrom", {1, -10}},
                                      {"\u00e5ngstr\u00f6m", {1, -10}},
                                      {"\u00c5ngstr\u00f6m", {1, -10}},
                                      {"micron", {1, -6}},
                                      {"inch", {254, -4}},
                                      {"inche", {254, -4}},
                                      {"meter", {1, 0}},
                                      {"metre", {1, 0}},
                                      {"picometer", {1, -12}},
                                      {"nanometer", {1, -9}},
                                      {"micrometer", {1, -6}},
                                      {"millimeter", {1, -3}},
                                      {"centimeter", {1, -2}},
                                      {"kilometer", {1, 3}},
                                      {"picometre", {1, -12}},
                                      {"nanometre", {1, -9}},
                                      {"micrometre", {1, -6}},
                                      {"millimetre", {1, -3}},
                                      {"centimetre", {1, -2}},
                                      {"kilometre", {1, 3}}};
constexpr double kDegree = kPi / 180.0;
constexpr NamedUnit kAngles[] = {{"rad", {1, 0}},
                                 {"mrad", {1, -3}},
                                 {"urad", {1, -6}},
                                 {"\u00b5rad", {1, -6}},
                                 {"\u03bcrad", {1, -6}},
                                 {"nrad", {1, -9}},
                                 {"deg", {kDegree, 0}},
                                 {"arcmin", {kDegree / 60, 0}},
                                 {"arcsec", {kDegree / 3600, 0}},
                                 {"mas", {kDegree / 3600, -3}}};
constexpr NamedUnit kAngleWords[] = {{"radian", {1, 0}},
                                     {"milliradian", {1, -3}},
                                     {"microradian", {1, -6}},
                                     {"nanoradian", {1, -9}},
                                     {"degree", {kDegree, 0}},
                                     {"arcminute", {kDegree / 60, 0}},
                                     {"arcsecond", {kDegree / 3600, 0}}};
constexpr NamedUnit kTimes[] = {{"s", {1, 0}}, {"min", {60, 0}}, {"h", {3600, 0}}};
constexpr NamedUnit kFractions[] = {{"%", {1, -2}}, {"ppm", {1, -6}}};
// A cycle counts 1: these words have no factor (and no 2 pi).
constexpr std::string_view kCycles[] = {"cycles", "cycle", "cy", "lp", "1"};

std::optional<Unit> find(std::span<const NamedUnit> units, std::string_view name) {
  for (const NamedUnit& unit : units)
    if (unit.name == name) return unit.unit;
  return std::nullopt;
}

std::optional<Unit> find_word(std::span<const NamedUnit> words, std::string_view name) {
  std::string word = lower_case(name);
  if (word.ends_with('s')) word.pop_back();
  return find(words, word);
}

std::optional<Unit> find_length(std::string_view name) {
  const std::optional<Unit> symbol = find(kLengths, name);
  return symbol ? symbol : find_word(kLengthWords, name);
}

std::optional<Unit> find_angle(std::string_view name) {
  const std::optional<Unit> symbol = find(kAngles, name);
  return symbol ? symbol : find_word(kAngleWords, name);
}

// number * 10^shift, rounded once: the shift goes into the text. Digits must suit std::from_chars.
double scaled_number(std::string_view digits, int shift) {
  const std::size_t e = digits.find_first_of("eE");
  int exponent = 0;
  constexpr int kMost = 1'000'000'000;  // a zero may have any exponent, and the sum must not overflow
  if (e != std::string_view::npos) {
    std::size_t begin = e + 1;
    if (begin < digits.size() && digits[begin] == '+') ++begin;
    std::from_chars(digits.data() + begin, digits.data() + digits.size(), exponent);
  }
  const std::string text =
      fmt::format("{}e{}", digits.substr(0, e), std::clamp(exponent, -kMost, kMost) + shift);
  double value = kNaN;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// Products and quotients of powers of lengths and cycles, such as "nm^2 mm^2", "um^2/(cycles/mm)^2", "1/m":
//   expression = [factor] { [*] factor | / factor },  factor = (name | "(" expression ")") [^ integer]
class UnitExpression {
 public:
  explicit UnitExpression(std::string_view text) : text_(text) {}

  // The unit, if the text is an expression of metres to this power and its factor fits into a double.
  std::optional<Unit> of_length_power(int power) {
    Term term;
    if (!expression(&term, 0) || position_ != text_.size() || term.length_power != power) return std::nullopt;
    const double si = term.unit.factor * scaled_number("1", term.unit.exponent10);
    if (!(si > 0 && std::isfinite(si))) return std::nullopt;
    return term.unit;
  }

 private:
  struct Term {
    Unit unit;
    int length_power = 0;
  };

  // Returns false, before an int overflows, for a product beyond every real unit.
  static bool multiply(Term* product, const Term& term, int power) {
    product->unit.factor *= std::pow(term.unit.factor, power);
    product->unit.exponent10 += power * term.unit.exponent10;
    product->length_power += power * term.length_power;
    constexpr int kMost = 100'000;
    return std::abs(product->unit.exponent10) <= kMost && std::abs(product->length_power) <= kMost;
  }

  bool take(std::string_view symbol) {
    while (position_ < text_.size() && text_[position_] == ' ') ++position_;
    if (!text_.substr(position_).starts_with(symbol)) return false;
    position_ += symbol.size();
    return true;
  }

  bool expression(Term* product, int depth) {
    if (depth > 4) return false;
    Term term;
    if (take("/")) {
      if (!factor(&term, depth) || !multiply(product, term, -1)) return false;
    } else {
      if (!factor(&term, depth) || !multiply(product, term, 1)) return false;
    }
    for (;;) {
      while (position_ < text_.size() && text_[position_] == ' ') ++position_;
      if (position_ == text_.size() || text_[position_] == ')') return true;
      const int sign = take("/") ? -1 : 1;
      if (sign == 1) take("*");
      term = Term{};
      if (!factor(&term, depth) || !multiply(product, term, sign)) return false;
    }
  }

  bool factor(Term* result, int depth) {
    Term base;
    if (take("(")) {
      if (!expression(&base, depth + 1) || !take(")")) return false;
    } else if (!name(&base)) {
      return false;
    }
    int power = 1;
    if (take("^")) {
      const char* end = text_.data() + text_.size();
      const auto parsed = std::from_chars(text_.data() + position_, end, power);
      if (parsed.ec != std::errc{} || power < -4 || power > 4) return false;
      position_ = std::size_t(parsed.ptr - text_.data());
    } else if (take("\u00b2")) {
      power = 2;
    } else if (take("\u00b3")) {
      power = 3;
    } else if (take("\u2074")) {
      power = 4;
    }
    return multiply(result, base, power);
  }

  bool name(Term* term) {
    while (position_ < text_.size() && text_[position_] == ' ') ++position_;
    std::size_t end = position_;
    const auto ends_name = [&] {
      const std::string_view rest = text_.substr(end);
      for (const std::string_view stop : {" ", "/", "*", "^", "(", ")", "\u00b2", "\u00b3", "\u2074"})
        if (rest.starts_with(stop)) return true;
      return false;
    };
    while (end < text_.size() && !ends_name()) ++end;
    const std::string_view word = text_.substr(position_, end - position_);
    position_ = end;
    for (const std::string_view cycle : kCycles)
      if (word == cycle) return true;
    const std::optional<Unit> length = find_length(word);
    if (!length) return false;
    *term = {*length, 1};
    return true;
  }

  std::string_view text_;
  std::size_t position_ = 0;
};

std::optional<Unit> find_unit(std::string_view name, Dimension dimension) {
  switch (dimension) {
    case Dimension::kLength:
      return find_length(name);
    case Dimension::kAngle:
      return find_angle(name);
    case Dimension::kFraction:
      return find(kFractions, name);
    case Dimension::kSpatialFrequency:
      return UnitExpression(name).of_length_power(-1);
    case Dimension::kPsd1d:
      return UnitExpression(name).of_length_power(3);
    case Dimension::kPsd2d:
      return UnitExpression(name).of_length_power(4);
    case Dimension::kTime:
      return find(kTimes, name);
    case Dimension::kNumber:
      break;
  }
  return std::nullopt;
}

// The order is that of Dimension.
constexpr const char* kDimensionNames[] = {"a length",
                                           "an angle",
                                           "a spatial frequency",
                                           "a fraction",
                                           "a 1-D power spectral density",
                                           "a 2-D power spectral density",
                                           "a number",
                                           "a time"};
constexpr const char* kAllowedUnits[] = {"pm, nm, um, mm, cm, m, km, in, angstrom",
                                         "rad, mrad, urad, nrad, deg, arcmin, arcsec, mas",
                                         "/m, /mm, /um, cycles/m, cycles/mm, lp/mm (a cycle is 1, not 2 pi)",
                                         "%, ppm, or a plain number without quotes",
                                         "m^3, um^3, nm^3, nm^2 mm, um^2 mm, nm^2/(cycles/mm)",
                                         "m^4, mm^4, um^4, nm^4, nm^2 mm^2, um^2 mm^2, nm^2/(cycles/mm)^2",
                                         "a plain number without unit",
                                         "s, min, h"};

const char* dimension_name(Dimension dimension) { return kDimensionNames[std::size_t(dimension)]; }

struct Prefix {
  const char* name;
  double scale;  // SI units in one prefixed unit
};

// Uses the largest prefix whose rounded number is at least 1, or the smallest prefix.
std::string with_prefix(double value, std::span<const Prefix> ascending) {
  const double shown = std::abs(scaled_number(fmt::format("{:.3e}", value), 0));
  const Prefix* best = &ascending.front();
  for (const Prefix& prefix : ascending)
    if (shown >= prefix.scale * (1 - 1e-9)) best = &prefix;
  return fmt::format("{:.4g} {}", value / best->scale, best->name);
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Turns "nm2_mm2", "per_mm", "mm-1" into units with signs: "nm^2 mm^2", "/mm", "mm^-1".
std::string with_signs(std::string_view text) {
  std::string unit;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : ' ';
    if (text.substr(i).starts_with("\u00b7") || text.substr(i).starts_with("\u22c5")) {
      unit += ' ';
      i += text.substr(i).starts_with("\u00b7") ? 1 : 2;
    } else if (text.substr(i).starts_with("per_") || text.substr(i).starts_with("per ")) {
      unit += '/';
      i += 3;
    } else {
      unit += c == '_' ? ' ' : c;
      if (is_letter(c) && (is_digit(next) || (next == '-' && i + 2 < text.size() && is_digit(text[i + 2]))))
        unit += '^';
    }
  }
  return std::string(trimmed(unit));
}

}  // namespace

std::string unit_of_column(std::string_view name, Dimension dimension) {
  std::vector<std::string_view> candidates;
  for (std::size_t open = name.find_first_of("[("); open != std::string_view::npos;
       open = name.find_first_of("[(", open + 1))
    if (const std::size_t close = name.rfind(name[open] == '[' ? ']' : ')');
        close != std::string_view::npos && close > open)
      candidates.push_back(name.substr(open + 1, close - open - 1));
  candidates.push_back(name);
  for (std::size_t sign = name.find_first_of("_/ "); sign != std::string_view::npos;
       sign = name.find_first_of("_/ ", sign + 1))
    candidates.push_back(name.substr(sign + 1));
  for (const std::string_view candidate : candidates) {
    std::string unit = with_signs(candidate);
    // In "PSD in um^3" the word is the preposition, not inches.
    if (unit.starts_with("in ")) unit = std::string(trimmed(std::string_view(unit).substr(3)));
    if (!unit.empty() && find_unit(unit, dimension)) return unit;
  }
  return {};
}

double parse_quantity(std::string_view text, Dimension dimension) {
  const std::string plain_text = with_plain_blanks(text);
  const std::string_view body = trimmed(plain_text);
  const auto fail = [&](std::string_view problem) {
    throw UnitError(fmt::format("\"{}\" {}; expected {} such as {}", text, problem, dimension_name(dimension),
                                allowed_units(dimension)));
  };
  double plain = 0;
  const auto [end, error] = std::from_chars(body.data(), body.data() + body.size(), plain);
  if (error == std::errc::invalid_argument) fail("does not begin with a number");
  if (error == std::errc::result_out_of_range || !std::isfinite(plain)) fail("is not a finite number");
  const std::string_view digits = body.substr(0, std::size_t(end - body.data()));
  const std::string_view name = trimmed(body.substr(digits.size()));
  if (dimension == Dimension::kNumber) {
    if (!name.empty()) fail(fmt::format("has the unit \"{}\" where none is allowed", name));
    return plain;
  }
  if (name.empty()) fail("has no unit");
  const std::optional<Unit> unit = find_unit(name, dimension);
  if (!unit) fail(fmt::format("has the unit \"{}\", which is not known here", name));
  const double value = unit->factor * scaled_number(digits, unit->exponent10);
  if (!std::isfinite(value)) fail("is not a finite number in SI units");
  return value;
}

double unit_factor(std::string_view unit, Dimension dimension) {
  const std::string plain_text = with_plain_blanks(unit);
  const std::string_view name = trimmed(plain_text);
  // A column of plain fractions or numbers has no unit, or "1".
  if ((dimension == Dimension::kFraction || dimension == Dimension::kNumber) && (name.empty() || name == "1"))
    return 1;
  const std::optional<Unit> found = find_unit(name, dimension);
  if (!found)
    throw UnitError(fmt::format("\"{}\" is not a unit of {}; known: {}", unit, dimension_name(dimension),
                                allowed_units(dimension)));
  return found->factor * scaled_number("1", found->exponent10);
}

std::string format_percent(double share) {
  const double percent = 100 * share;
  return std::abs(percent) < 99.5 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent);
}

std::string format_quantity(double value, Dimension dimension) {
  static constexpr Prefix kLengthPrefixes[] = {{"pm", 1e-12}, {"nm", 1e-9}, {"um", 1e-6},
                                               {"mm", 1e-3},  {"m", 1},     {"km", 1e3}};
  static constexpr Prefix kAnglePrefixes[] = {{"nrad", 1e-9}, {"urad", 1e-6}, {"mrad", 1e-3}, {"rad", 1}};
  static constexpr Prefix kFrequencyPrefixes[] = {{"/m", 1}, {"/mm", 1e3}, {"/um", 1e6}};
  if (std::isfinite(value) && value != 0) {
    if (dimension == Dimension::kLength) return with_prefix(value, kLengthPrefixes);
    if (dimension == Dimension::kAngle) return with_prefix(value, kAnglePrefixes);
    if (dimension == Dimension::kSpatialFrequency) return with_prefix(value, kFrequencyPrefixes);
  }
  // Entries are in the order of Dimension; PSDs have the usual units of optical metrology.
  static constexpr Prefix kShownIn[] = {{" m", 1},           {" rad", 1},           {" /m", 1}, {" %", 1e-2},
                                        {" nm^2 mm", 1e-21}, {" nm^2 mm^2", 1e-24}, {"", 1},    {" s", 1}};
  const Prefix& in = kShownIn[std::size_t(dimension)];
  return fmt::format("{:.4g}{}", value / in.scale, in.name);
}

std::string allowed_units(Dimension dimension) { return kAllowedUnits[std::size_t(dimension)]; }

}  // namespace aberfit
