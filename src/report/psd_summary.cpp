#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/core/units.h"
#include "aberfit/report/psd_report.h"
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

// Of a map: what its mean slope is the mean of.
std::string slopes_of_axes(const PsdEstimate& e) {
  if (!std::isfinite(e.rms_slope_x) || !std::isfinite(e.rms_slope_y)) return "";
  return fmt::format(" per axis ({} along x, {} along y)", slope_text(e.rms_slope_x),
                     slope_text(e.rms_slope_y));
}

// Of every valid sample, whatever its frequencies. Two conventions of a slope's RMS where they differ.
std::string record_line(const PsdEstimate& e) {
  constexpr double kNoticed = 0.01;
  std::string text = fmt::format("RMS height {}, RMS slope {}{} of the detrended surface",
                                 metres_text(e.rms_height), slope_text(e.rms_slope), slopes_of_axes(e));
  if (std::abs(e.rms_slope_as_slopes / e.rms_slope - 1) > kNoticed)
    text += fmt::format(" ({} with the slopes themselves detrended)", slope_text(e.rms_slope_as_slopes));
  return paragraph("Record", text);
}

std::string value_with_unit(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "-";
  if (unit == "m") return metres_text(value);
  if (unit == "/m" || unit == "1/m") return frequency(value);
  return fmt::format("{:.4g}{}{}", value, unit.empty() || unit == "1" ? "" : " ", unit == "1" ? "" : unit);
}

std::string parameter_rows(const PsdReport& report) {
  std::string text = fmt::format("\n  {:<16} {:>16} {:>34}\n", "parameter", "value",
                                 fmt::format("{:.4g} % interval", 100 * report.estimate.options.confidence));
  for (const PsdParameter& p : report.fit.parameters) {
    const std::string interval =
        fmt::format("{} .. {}", value_with_unit(p.lower, p.unit), value_with_unit(p.upper, p.unit));
    text += fmt::format("  {:<16} {:>16} {:>34}{}\n", p.name, value_with_unit(p.value, p.unit), interval,
                        p.identified ? "" : "   not identified");
  }
  return text;
}

// Model and data in the band of the fit, side by side.
std::string band_line(const PsdReport& report) {
  const BandRms data = report.in_band(false), model = report.in_band(true);
  if (!(data.height > 0) || !(model.height > 0)) return "";
  return paragraph(
      "In band", fmt::format("RMS height {} of the model, {} of the bins (ratio {:.3f}); RMS slope {}, {} "
                             "(ratio {:.3f})",
                             metres_text(model.height), metres_text(data.height), model.height / data.height,
                             slope_text(model.slope), slope_text(data.slope), model.slope / data.slope));
}

std::string named_band_rows(const std::vector<BandContent>& bands) {
  std::string text;
  for (const BandContent& c : bands) {
    const std::string range = frequency(c.band.f_min) + " to " + frequency(c.band.f_max);
    text += paragraph(
        "Band", c.to == 0
                    ? fmt::format("{}, {}: no bins", c.band.name, range)
                    : fmt::format("{}, {}: RMS height {} of the bins, {} of the model; RMS slope {}, {}",
                                  c.band.name, range, metres_text(c.data.height), metres_text(c.model.height),
                                  slope_text(c.data.slope), slope_text(c.model.slope)));
  }
  return text;
}

std::string square_nanometres(double value) { return fmt::format("{:.4g} nm^2", 1e18 * value); }

// The structure function at a few separations, even in the logarithm.
std::string difference_rows(const PsdReport& report) {
  constexpr Eigen::Index kRows = 6;
  std::string text;
  for (std::size_t i = 0; i < report.differences.size(); ++i) {
    const HeightDifferences& d = report.differences[i];
    const Eigen::Index n = d.separation.size(), rows = std::min(n, kRows);
    if (n == 0) continue;
    const Eigen::ArrayXd model = model_height_differences(report.fit, report.estimate.kind, d.separation);
    text += fmt::format(
        "\n{}Structure function D(s) = <(h(x+s) - h(x))^2> of the detrended surface;\nof the model from {} "
        "to {} "
        "alone, of the surface all frequencies\n",
        report.differences.size() > 1 ? report.files.at(i) + ": " : "", frequency(report.fit.f_min),
        frequency(report.fit.f_max));
    text += fmt::format("  {:>12} {:>18} {:>18} {:>18}\n", "s", "D", "D of the model", "RMS difference");
    for (Eigen::Index row = 0; row < rows; ++row) {
      const Eigen::Index k =
          rows > 1 ? Eigen::Index(std::lround(double(row * (n - 1)) / double(rows - 1))) : 0;
      text += fmt::format("  {:>12} {:>18} {:>18} {:>18}\n", metres_text(d.separation[k]),
                          square_nanometres(d.mean_square[k]), square_nanometres(model[k]),
                          metres_text(std::sqrt(d.mean_square[k])));
    }
  }
  return text;
}

// The straight line in the form that drawings carry: one-dimensional, A/f^B over a band.
std::string drawing_text(const DrawingLine& line) {
  if (!std::isfinite(line.exponent)) return "";
  const std::string numbers =
      fmt::format("B = {:.3f} +- {:.3f} and A = {:.4g} m^(3-B), f in cycles/m, over {} to {}", line.exponent,
                  line.exponent_std, line.amplitude, frequency(line.f_min), frequency(line.f_max));
  if (line.describes) return paragraph("Drawing", "profile PSD A/f^B (as ISO 10110-8) with " + numbers);
  return paragraph(
      "Drawing",
      fmt::format("no straight line describes these bins; the nearest profile PSD A/f^B has {}, and "
                  "{:.2f} times their RMS height",
                  numbers, line.factor));
}

std::string lines_rows(const PsdEstimate& estimate) {
  std::string text;
  for (const SpectralLine& line : estimate.lines) {
    const std::string direction = std::isfinite(line.angle)
                                      ? fmt::format(", along {:.0f} deg", line.angle * 180 / std::numbers::pi)
                                      : "";
    text += paragraph("Line", fmt::format("{} (period {}){}: RMS {}, {:.3g} times the continuum",
                                          frequency(line.frequency), metres_text(1 / line.frequency),
                                          direction, metres_text(line.rms), line.strength));
  }
  return text;
}

}  // namespace

std::string summary_table(const PsdReport& report, const nlohmann::ordered_json& roughness) {
  std::string text = report.title.empty() ? "" : report.title + "\n\n";
  for (std::size_t i = 0; i < report.data.size(); ++i)
    text += paragraph("Data", report.files.at(i) + ": " + std::visit(Described{}, report.data[i]) +
                                  clear_text(report.clear.at(i)));
  text += paragraph("PSD", estimator_line(report.estimate));
  text += record_line(report.estimate) + lines_rows(report.estimate);
  const PsdModelFit& fit = report.fit;
  text += paragraph("Model", fmt::format("{} over {} to {}: {} ({}); p-value of the residuals {:.3g}",
                                         to_string(fit.family), frequency(fit.f_min), frequency(fit.f_max),
                                         to_string(fit.status), fit.message, fit.goodness));
  text += parameter_rows(report) + "\n" + band_line(report) + named_band_rows(report.bands) +
          drawing_text(report.line) + difference_rows(report);
  text += "\nFor a study:\n\"roughness\": " + roughness.dump() + "\n";
  if (std::isfinite(report.as_measured.exponent))
    text += "For this very surface, with the RMS height and slope of its bins:\n\"roughness\": " +
            line_block(report.as_measured).dump() + "\n";
  if (std::isfinite(report.line.exponent))
    text += "The line of the drawing:\n\"roughness\": " + line_block(report.line).dump() + "\n";
  for (const Warning& warning : report.warnings)
    text += fmt::format("\n{}", paragraph("Warning", warning.code + ": " + warning.message));
  return text;
}

}  // namespace aberfit
