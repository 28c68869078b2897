#include "aberfit/roughness/psd_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/roughness/psd_in_band.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

constexpr const char* kAllowed =
    "rows of two or more numbers (frequency, PSD), both positive, frequencies ascending; '#' comments; one "
    "header row";

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

  const double scale = options.psd_factor * options.height_factor * options.height_factor *
                       (options.of == PsdTableOf::kWavefront ? 0.25 : 1.0);
  PsdTableResult result;
  TablePsd table;
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    table.frequency.push_back(frequency[i] * options.frequency_factor);
    table.psd.push_back(psd[i] * scale);
  }
  if (options.kind == PsdTableKind::k1dOneSided) {
    result.tail_exponent = fitted_tail_exponent(table.frequency, table.psd);
    if (!(result.tail_exponent > 0))
      throw InputError(
          source, "",
          fmt::format("a profile PSD that rises as f^{:g} over its last octave", -result.tail_exponent),
          "a profile PSD that falls at its end: the surface PSD needs its integral beyond");
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
                     fmt::format("a band that meets the table, {:g} .. {:g} /m", table.frequency.front(),
                                 table.frequency.back()));
  result.psd = std::get<TablePsd>(*psd_in_band(table, f_min, f_max));
  const RadialPsd whole(table);
  // Summed outside the band: one minus the share inside would lose the small ones.
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
  std::string_view line;
  while (file.next(&line)) {
    const std::vector<std::string_view> fields = words(before_comment(line), ",; \t\r");
    if (fields.empty()) continue;
    const std::optional<double> first = parse_number<double>(fields[0]);
    const std::optional<double> second = fields.size() > 1 ? parse_number<double>(fields[1]) : std::nullopt;
    if (!first && !header_seen && lines.empty()) {
      header_seen = true;
      continue;
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
  return psd_from_table(frequency, psd, options, path, lines);
}

}  // namespace aberfit
