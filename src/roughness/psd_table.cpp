#include "aberfit/roughness/psd_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/roughness/psd_in_band.h"
#include "aberfit/roughness/psd_integrals.h"
#include "psd_table_units.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr const char* kAllowed =
    "rows of two or more numbers (frequency, PSD), both positive, frequencies ascending; '#' comments; one "
    "header row";

// The factor of a column from its header or its option, which must agree. `what`, `key`: for messages.
std::optional<double> agreed(const std::string& path, const std::string& unit, Dimension dimension,
                             const std::optional<double>& given, const char* key) {
  constexpr double kSame = 1e-6;
  const std::optional<double> said = factor_of(unit, dimension);
  if (said && given && !(std::abs(*given / *said - 1) <= kSame))
    throw InputError(
        path, "", fmt::format("the unit {} in its header, but another one as \"{}\"", in_quotes(unit), key),
        "only one of them; leave the key out");
  return said ? said : given;
}

// The options with the units from the header.
PsdTableOptions with_units(const std::string& path, const HeaderUnits& units, PsdTableOptions options) {
  const bool profile = options.kind == PsdTableKind::k1dOneSided;
  const Dimension dimension = profile ? Dimension::kPsd1d : Dimension::kPsd2d;
  if (!units.psd.empty() && !factor_of(units.psd, dimension))
    throw InputError(path, "", fmt::format("the unit {} in its header", in_quotes(units.psd)),
                     fmt::format("\"kind\": \"{}\" for a PSD in that unit; a \"{}\" PSD has {}",
                                 profile ? "2d" : "1d", profile ? "1d" : "2d", allowed_units(dimension)));
  options.frequency_factor =
      agreed(path, units.frequency, Dimension::kSpatialFrequency, options.frequency_factor, "frequency_unit");
  options.psd_factor = agreed(path, units.psd, dimension, options.psd_factor, "psd_unit");
  const bool frequency = options.frequency_factor.has_value(), psd = options.psd_factor.has_value();
  if (!frequency || !psd)
    throw InputError(
        path, "",
        fmt::format("no unit of {}", psd         ? "the frequencies"
                                     : frequency ? "the PSD"
                                                 : "the frequencies and of the PSD"),
        fmt::format("{}{}{}, or a header row such as \"f [1/mm], PSD [{}]\"",
                    frequency ? "" : "\"frequency_unit\": \"1/mm\"", frequency || psd ? "" : " and ",
                    psd       ? ""
                    : profile ? "\"psd_unit\": \"nm^2 mm\""
                              : "\"psd_unit\": \"nm^2 mm^2\"",
                    profile ? "nm^2 mm" : "nm^2 mm^2"));
  return options;
}

}  // namespace

PsdTableResult psd_from_table(const std::vector<double>& frequency, const std::vector<double>& psd,
                              const PsdTableOptions& options, const std::string& source,
                              const std::vector<int>& lines) {
  const auto where = [&](std::size_t i) {
    return lines.empty() ? fmt::format("point {}", i + 1) : fmt::format("line {}", lines[i]);
  };
  if (frequency.size() < 2 || frequency.size() != psd.size())
    throw InputError(source, "", fmt::format("{} rows of numbers", std::min(frequency.size(), psd.size())),
                     "at least 2 rows of frequency and PSD");
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    if (!(frequency[i] > 0) || !std::isfinite(frequency[i]))
      throw InputError(source, "", fmt::format("{}: frequency {:g}", where(i), frequency[i]), kAllowed);
    if (!(psd[i] > 0) || !std::isfinite(psd[i]))
      throw InputError(source, "", fmt::format("{}: PSD {:g}", where(i), psd[i]), kAllowed);
    if (i > 0 && !(frequency[i] > frequency[i - 1]))
      throw InputError(source, "",
                       fmt::format("{}: frequency {:g} after {:g}", where(i), frequency[i], frequency[i - 1]),
                       kAllowed);
  }

  const double scale = options.psd_factor.value_or(1) * options.height_factor * options.height_factor *
                       (options.of == PsdTableOf::kWavefront ? 0.25 : 1.0);
  PsdTableResult result;
  TablePsd table;
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    table.frequency.push_back(frequency[i] * options.frequency_factor.value_or(1));
    table.psd.push_back(psd[i] * scale);
  }
  if (options.kind == PsdTableKind::k1dOneSided) {
    result.tail_exponent = fitted_tail_exponent(table.frequency, table.psd);
    if (!(result.tail_exponent > 0))
      throw InputError(
          source, "",
          fmt::format("a profile PSD that rises as f^{:g} over its last octave", -result.tail_exponent),
          "a profile PSD that falls at its end, because the surface PSD is an integral over what lies "
          "beyond");
    TablePsd surface;
    const std::vector<double> psd_2d = abel_1d_to_2d(table.frequency, table.psd, result.tail_exponent);
    for (std::size_t i = 0; i < psd_2d.size(); ++i) {
      if (!(psd_2d[i] > 0)) {
        ++result.not_positive;
        continue;
      }
      surface.frequency.push_back(table.frequency[i]);
      surface.psd.push_back(psd_2d[i]);
    }
    if (surface.frequency.size() < 2)
      throw InputError(source, "", "a profile PSD that rises almost everywhere",
                       "a profile PSD of an isotropic surface, which never rises");
    table = std::move(surface);
  }
  const std::string problem = psd_problem(table);
  if (!problem.empty()) throw InputError(source, "", "after conversion to SI: " + problem, kAllowed);

  const double f_min = options.f_min.value_or(0), f_max = options.f_max.value_or(table.frequency.back());
  if (!(f_min < f_max) || f_max <= table.frequency.front() || f_min >= table.frequency.back())
    throw InputError(source, "", fmt::format("band {:g} .. {:g} /m", f_min, f_max),
                     fmt::format("a band that overlaps the table, {:g} .. {:g} /m", table.frequency.front(),
                                 table.frequency.back()));
  result.psd = std::get<TablePsd>(*psd_in_band(table, f_min, f_max));
  const RadialPsd whole(table);
  // We sum outside the band, because one minus the fraction inside would lose digits for small values.
  const auto left_out = [&](double power) {
    const double outside =
        radial_moment(whole, power, 0, f_min) + radial_moment(whole, power, f_max, table.frequency.back());
    return outside / radial_moment(whole, power);
  };
  result.variance_left_out = left_out(0);
  result.slope_variance_left_out = left_out(2);
  return result;
}

PsdTableResult read_psd_table(const std::string& path, const PsdTableOptions& options) {
  TextLines file(path);
  std::vector<double> frequency, psd;
  std::vector<int> lines;
  bool header_seen = false;
  HeaderUnits units;
  // Units come from a header row, a row of units below it, or the last comment before the numbers.
  const auto take_units = [&](std::string_view row) {
    const HeaderUnits said = units_of_header(row);
    if (!said.frequency.empty()) units.frequency = said.frequency;
    if (!said.psd.empty()) units.psd = said.psd;
    return !said.frequency.empty() || !said.psd.empty();
  };
  std::string_view line;
  while (file.next(&line)) {
    const std::string_view numbers = before_comment(line);
    const std::vector<std::string_view> fields = words(numbers, ",; \t\r\"");
    if (fields.empty()) {
      if (lines.empty() && !header_seen) take_units(line.substr(std::min(numbers.size() + 1, line.size())));
      continue;
    }
    if (const auto comma = decimal_comma(numbers))
      throw InputError(path, "",
                       fmt::format("line {}: {}, a decimal comma", file.number(), in_quotes(*comma)),
                       kDecimalPoint);
    const std::optional<double> first = parse_number<double>(fields[0]);
    const std::optional<double> second = fields.size() > 1 ? parse_number<double>(fields[1]) : std::nullopt;
    if (!first && lines.empty()) {
      const bool has_units = take_units(numbers);
      if (!header_seen || has_units) {
        header_seen = true;
        continue;
      }
    }
    if (!first || !second)
      throw InputError(path, "", fmt::format("line {}: \"{}\"", file.number(), line.substr(0, 60)), kAllowed);
    for (std::size_t i = 0; i < 2; ++i)
      if (!std::isfinite(i == 0 ? *first : *second))
        throw InputError(path, "", fmt::format("line {}: {}", file.number(), in_quotes(fields[i])), kAllowed);
    frequency.push_back(*first);
    psd.push_back(*second);
    lines.push_back(int(file.number()));
  }
  if (lines.empty() && !header_seen && file.number() == 0)
    throw InputError(path, "", "an empty file", kAllowed);
  // Errors in the numbers are reported first; units only scale them.
  psd_from_table(frequency, psd, {.kind = PsdTableKind::k2dTwoSided}, path, lines);
  return psd_from_table(frequency, psd, with_units(path, units, options), path, lines);
}

}  // namespace aberfit
