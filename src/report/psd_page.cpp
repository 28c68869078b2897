// This file makes the page of a measured PSD.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/core/units.h"
#include "aberfit/report/documents.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

std::string frequency(double value) { return format_quantity(value, Dimension::kSpatialFrequency); }

struct Described {
  std::string operator()(const Profile& profile) const {
    const Eigen::Index n = profile.size();
    return fmt::format("{} profile, {} samples ({} valid) over {}, pitch {}{}",
                       profile.quantity == ProfileQuantity::kSlope ? "slope" : "height", n,
                       valid_count(profile), metres_text(n > 0 ? profile.x[n - 1] - profile.x[0] : 0),
                       metres_text(median_pitch(profile)), profile.label.empty() ? "" : "; " + profile.label);
  }
  std::string operator()(const HeightMap& map) const {
    return fmt::format("map, {} x {} points ({} valid), pitch {}{}", map.columns(), map.rows(),
                       valid_count(map), pitches_text(map.pitch_x, map.pitch_y),
                       map.label.empty() ? "" : "; " + map.label);
  }
};

std::string estimator_line(const PsdEstimate& e) {
  static const char* const kShapes[] = {"nothing removed", "polynomial of degree {} removed",
                                        "best-fit ellipse removed", "Zernikes to n = {} removed"};
  std::string shape = kShapes[std::size_t(e.options.detrend.shape)];
  if (const auto at = shape.find("{}"); at != std::string::npos)
    shape.replace(at, 2, std::to_string(e.options.detrend.degree));
  return fmt::format("{}, {} window, {} bins from {} to {}", shape, to_string(e.options.window),
                     e.frequency.size(), frequency(e.low[0]), frequency(e.high[e.high.size() - 1]));
}

std::string slope_text(double value) { return format_quantity(value, Dimension::kAngle); }

// The slopes along both axes of a map, whose mean is the RMS slope.
std::string slopes_of_axes(const PsdEstimate& e) {
  if (!std::isfinite(e.rms_slope_x) || !std::isfinite(e.rms_slope_y)) return "";
  return fmt::format(" per axis ({} along x, {} along y)", slope_text(e.rms_slope_x),
                     slope_text(e.rms_slope_y));
}

// RMS values over all valid samples and frequencies. Shows both conventions of the RMS slope if they differ.
std::string record_text(const PsdEstimate& e) {
  constexpr double kNoticed = 0.01;
  std::string text = fmt::format("RMS height {}, RMS slope {}{} of the detrended surface",
                                 metres_text(e.rms_height), slope_text(e.rms_slope), slopes_of_axes(e));
  if (std::abs(e.rms_slope_as_slopes / e.rms_slope - 1) > kNoticed)
    text += fmt::format(" ({} when the slopes themselves are detrended)", slope_text(e.rms_slope_as_slopes));
  return text;
}

std::string value_with_unit(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "-";
  if (unit == "m") return metres_text(value);
  if (unit == "/m" || unit == "1/m") return frequency(value);
  return fmt::format("{:.4g}{}{}", value, unit.empty() || unit == "1" ? "" : " ", unit == "1" ? "" : unit);
}

void add_parameters(Page* page, const PsdReport& report) {
  Page::Table table{
      "",
      {"parameter", "value", fmt::format("{:.4g} % interval", 100 * report.estimate.options.confidence), ""},
      "lrrl"};
  for (const PsdParameter& p : report.fit.parameters)
    table.add({p.name, value_with_unit(p.value, p.unit),
               fmt::format("{} .. {}", value_with_unit(p.lower, p.unit), value_with_unit(p.upper, p.unit)),
               p.identified ? "" : "not identified"});
  page->parts.push_back(std::move(table));
}

// Adds model and data side by side, in the band of the fit and in the requested bands.
void add_bands(Page* page, const PsdReport& report) {
  const BandRms data = report.in_band(false), model = report.in_band(true);
  if (data.height > 0 && model.height > 0)
    page->say("In band",
              fmt::format("RMS height {} of the model, {} of the bins (ratio {:.3f}); RMS slope {}, {} "
                          "(ratio {:.3f})",
                          metres_text(model.height), metres_text(data.height), model.height / data.height,
                          slope_text(model.slope), slope_text(data.slope), model.slope / data.slope));
  for (const BandContent& c : report.bands) {
    const std::string range = frequency(c.band.f_min) + " to " + frequency(c.band.f_max);
    page->say("Band",
              c.to == 0
                  ? fmt::format("{}, {}: no bins", c.band.name, range)
                  : fmt::format("{}, {}: RMS height {} of the bins, {} of the model; RMS slope {}, {}",
                                c.band.name, range, metres_text(c.data.height), metres_text(c.model.height),
                                slope_text(c.data.slope), slope_text(c.model.slope)));
  }
}

std::string square_nanometres(double value) { return fmt::format("{:.4g} nm^2", 1e18 * value); }

// Adds the structure function at a few separations with logarithmic steps.
void add_differences(Page* page, const PsdReport& report) {
  constexpr Eigen::Index kRows = 6;
  for (std::size_t i = 0; i < report.differences.size(); ++i) {
    const HeightDifferences& d = report.differences[i];
    const Eigen::Index n = d.separation.size(), rows = std::min(n, kRows);
    if (n == 0) continue;
    const Eigen::ArrayXd model = model_height_differences(report.fit, report.estimate.kind, d.separation);
    Page::Table table{fmt::format("{}Structure function D(s) = <(h(x+s) - h(x))^2> of the detrended surface; "
                                  "the model holds only frequencies from {} to {}, the surface all",
                                  report.differences.size() > 1 ? report.files.at(i) + ": " : "",
                                  frequency(report.fit.f_min), frequency(report.fit.f_max)),
                      {"s", "D", "D of the model", "RMS difference"},
                      "rrrr"};
    for (Eigen::Index row = 0; row < rows; ++row) {
      const Eigen::Index k =
          rows > 1 ? Eigen::Index(std::lround(double(row * (n - 1)) / double(rows - 1))) : 0;
      table.add({metres_text(d.separation[k]), square_nanometres(d.mean_square[k]),
                 square_nanometres(model[k]), metres_text(std::sqrt(d.mean_square[k]))});
    }
    page->parts.push_back(std::move(table));
  }
}

// Adds the straight line in the form of drawings: one-dimensional, A/f^B over a band.
void add_drawing(Page* page, const DrawingLine& line) {
  if (!std::isfinite(line.exponent)) return;
  const std::string numbers =
      fmt::format("B = {:.3f} +- {:.3f} and A = {:.4g} m^(3-B), f in cycles/m, over {} to {}", line.exponent,
                  line.exponent_std, line.amplitude, frequency(line.f_min), frequency(line.f_max));
  if (line.describes) return page->say("Drawing", "profile PSD A/f^B (as ISO 10110-8) with " + numbers);
  page->say("Drawing", fmt::format("no straight line describes these bins; the nearest profile PSD A/f^B has "
                                   "{} and {:.2f} times the RMS height of the bins",
                                   numbers, line.factor));
}

void add_lines(Page* page, const PsdEstimate& estimate) {
  for (const SpectralLine& line : estimate.lines) {
    const std::string direction = std::isfinite(line.angle)
                                      ? fmt::format(", along {:.0f} deg", line.angle * 180 / std::numbers::pi)
                                      : "";
    page->say("Line",
              fmt::format("{} (period {}){}: RMS {}, {:.3g} times the continuum", frequency(line.frequency),
                          metres_text(1 / line.frequency), direction, metres_text(line.rms), line.strength));
  }
}

void add_block(Page* page, const std::string& title, const nlohmann::ordered_json& roughness) {
  page->parts.push_back(Page::Verbatim{title, "\"roughness\": " + roughness.dump()});
}

}  // namespace

Page page_of(const PsdReport& report, const nlohmann::ordered_json& roughness) {
  Page page;
  page.title = report.title;
  for (std::size_t i = 0; i < report.data.size(); ++i)
    page.say("Data", report.files.at(i) + ": " + std::visit(Described{}, report.data[i]) +
                         clear_text(report.clear.at(i)));
  const BandRms found = report.in_band(true);
  page.answers.push_back(
      {"What was found",
       fmt::format("A {} PSD from {} to {}, with RMS height {} and RMS slope {} in that band.",
                   to_string(report.fit.family), frequency(report.fit.f_min), frequency(report.fit.f_max),
                   metres_text(found.height), slope_text(found.slope))});
  page.answers.push_back(
      {"How certain", fmt::format("Intervals are at {:.4g} %; the p-value of the residuals is {:.2g}.",
                                  100 * report.estimate.options.confidence, report.fit.goodness)});
  page.answers.push_back({"What it rests on",
                          "The sample is taken as part of a stationary surface. Beyond the band of the fit "
                          "nothing was measured."});
  page.answers.push_back(
      {"What would change it",
       "Another detrending or window changes the lowest bins, another instrument the highest."});
  page.answers.push_back({"What to do next",
                          "Paste the block `roughness` (also in roughness.json) into a study; `aberfit fit` "
                          "then finds the terms of such a mirror."});
  page.say("PSD", estimator_line(report.estimate));
  page.say("Record", record_text(report.estimate));
  add_lines(&page, report.estimate);
  const PsdModelFit& fit = report.fit;
  page.say("Model", fmt::format("{} over {} to {}: {} ({}); p-value of the residuals {:.3g}",
                                to_string(fit.family), frequency(fit.f_min), frequency(fit.f_max),
                                to_string(fit.status), fit.message, fit.goodness));
  add_parameters(&page, report);
  add_bands(&page, report);
  add_drawing(&page, report.line);
  add_differences(&page, report);
  add_block(&page, "For a study:", roughness);
  if (std::isfinite(report.as_measured.exponent))
    add_block(&page, "For exactly this surface, with the RMS height and slope of its bins:",
              line_block(report.as_measured));
  if (std::isfinite(report.line.exponent))
    add_block(&page, "The line of the drawing:", line_block(report.line));
  page.warnings = report.warnings;
  return page;
}

}  // namespace aberfit
