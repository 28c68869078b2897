#include "aberfit/report/psd_report.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "csv_field.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

bool of_profiles(const PsdReport& report) { return report.estimate.kind == PsdTableKind::k1dOneSided; }

}  // namespace

nlohmann::ordered_json line_block(const DrawingLine& line) {
  return {{"psd",
           {{"model", "power-law"},
            {"profile_psd",
             {{"A", fmt::format("{} m^3", line.amplitude)}, {"f_unit", "/m"}, {"B", line.exponent}}},
            {"f_min", line.f_min},
            {"f_max", line.f_max}}}};
}

BandRms PsdReport::in_band(bool of_model) const {
  return rms_in_band(surface, estimate.kind, of_model, fit.f_min, fit.f_max);
}

std::string bands_csv(const PsdReport& report) {
  std::string text =
      "# RMS height and slope of data and model in each band: requested bands, then octaves; the bins reach "
      "from .. to; empty without bins\n# Slopes are along a profile, or per axis of a "
      "map\nname,f_min_per_m,f_max_per_m,from_per_m,to_per_m,rms_height_m,rms_slope_rad,model_rms_height_m,"
      "model_rms_slope_rad\n";
  const auto add = [&](const BandContent& c, const std::string& name) {
    text += fmt::format("{},{:.9g},{:.9g}", csv_field(name), c.band.f_min, c.band.f_max);
    for (const double value : {c.from, c.to, c.data.height, c.data.slope, c.model.height, c.model.slope})
      text += c.to > 0 ? fmt::format(",{:.9g}", value) : ",";  // no bins
    text += '\n';
  };
  for (const BandContent& content : report.bands) add(content, content.band.name);
  for (const BandContent& octave : octaves(report.surface, report.estimate.kind)) add(octave, "octave");
  return text;
}

std::string psd_csv(const PsdReport& report) {
  const SurfacePsd& s = report.surface;
  const bool profiles = of_profiles(report);
  const long left_out = long(report.estimate.psd.size() - s.psd.size());
  std::string text = fmt::format(
      "# {} PSD of the surface, {}; frequency in cycles/m\n# The PSD is divided by the response of the "
      "estimator{}\n# For `\"model\": \"table\"`: \"kind\": \"{}\", \"frequency_unit\": \"/m\", "
      "\"psd_unit\": \"{}\"\nfrequency_per_m,psd_{},lower,upper,dof,model\n",
      profiles ? "One-sided profile" : "Two-sided, radially averaged two-dimensional",
      fmt::format("{:.4g} % intervals", 100 * report.estimate.options.confidence),
      left_out == 0 ? ""
                    : fmt::format("; left out: {} where the response is more than a factor 2, where shape "
                                  "leaks in, or beyond the instrument",
                                  plural(left_out, "bin")),
      profiles ? "1d" : "2d", profiles ? "m^3" : "m^4", profiles ? "m3" : "m4");
  for (Eigen::Index b = 0; b < s.psd.size(); ++b)
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{:.9g},{:.9g},{:.4g},{:.9g}\n", s.frequency[b],
                   s.psd[b], s.lower[b], s.upper[b], s.dof[b], s.model[b]);
  return text;
}

}  // namespace aberfit
