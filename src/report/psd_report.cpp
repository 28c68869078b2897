#include "aberfit/report/psd_report.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

bool of_profiles(const PsdReport& report) { return report.estimate.kind == PsdTableKind::k1dOneSided; }

struct MeasurementJson {
  Json operator()(const Profile& profile) const {
    const Eigen::Index n = profile.size();
    return {{"kind", "profile"},
            {"quantity", profile.quantity == ProfileQuantity::kSlope ? "slope" : "height"},
            {"label", profile.label},
            {"samples", n},
            {"valid", valid_count(profile)},
            {"length_m", json_number(n > 0 ? profile.x[n - 1] - profile.x[0] : 0)},
            {"pitch_m", json_number(median_pitch(profile))}};
  }
  Json operator()(const HeightMap& map) const {
    return {{"kind", "map"},
            {"label", map.label},
            {"columns", map.columns()},
            {"rows", map.rows()},
            {"valid", valid_count(map)},
            {"pitch_x_m", json_number(map.pitch_x)},
            {"pitch_y_m", json_number(map.pitch_y)}};
  }
};

Json measurements_json(const PsdReport& report) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.data.size(); ++i) {
    Json one = {{"file", report.files.at(i)}};
    one.update(std::visit(MeasurementJson{}, report.data[i]));
    one["clear"] = clear_json(report.clear.at(i));
    list.push_back(std::move(one));
  }
  return list;
}

// Every bin: as estimated, and, where that can be told, of the surface.
Json bins_json(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const std::string unit = of_profiles(report) ? "_m3" : "_m4";
  Json list = Json::array();
  for (Eigen::Index b = 0; b < e.frequency.size(); ++b)
    list.push_back({{"frequency_per_m", e.frequency[b]},
                    {"low_per_m", e.low[b]},
                    {"high_per_m", e.high[b]},
                    {"psd" + unit, nullptr},
                    {"lower" + unit, nullptr},
                    {"upper" + unit, nullptr},
                    {"model" + unit, nullptr},
                    {"estimated" + unit, json_number(e.psd[b])},
                    {"ordinates", json_number(e.count[b])},
                    {"dof", json_number(e.dof[b])}});
  const SurfacePsd& s = report.surface;
  for (Eigen::Index i = 0; i < s.psd.size(); ++i) {
    Json& bin = list[std::size_t(s.bin[std::size_t(i)])];
    bin["psd" + unit] = json_number(s.psd[i]);
    bin["lower" + unit] = json_number(s.lower[i]);
    bin["upper" + unit] = json_number(s.upper[i]);
    bin["model" + unit] = json_number(s.model[i]);
  }
  return list;
}

Json rms_json(const BandRms& rms) {
  return {{"rms_height_m", json_number(rms.height)}, {"rms_slope", json_number(rms.slope)}};
}

// The model and the data, the same bins of both.
Json in_band_json(const PsdReport& report) {
  return {{"data", rms_json(report.in_band(false))}, {"model", rms_json(report.in_band(true))}};
}

Json band_json(const BandContent& content) {
  const bool there = content.to > 0;
  Json json = Json::object();
  if (!content.band.name.empty()) json["name"] = content.band.name;
  json.update({{"f_min_per_m", content.band.f_min},
               {"f_max_per_m", content.band.f_max},
               {"from_per_m", there ? Json(content.from) : Json()},
               {"to_per_m", there ? Json(content.to) : Json()},
               {"data", there ? rms_json(content.data) : Json()},
               {"model", there ? rms_json(content.model) : Json()}});
  return json;
}

Json bands_json(const std::vector<BandContent>& bands) {
  Json list = Json::array();
  for (const BandContent& content : bands) list.push_back(band_json(content));
  return list;
}

// One per measurement.
Json differences_json(const PsdReport& report) {
  Json list = Json::array();
  for (const HeightDifferences& d : report.differences) {
    const Eigen::ArrayXd model = model_height_differences(report.fit, report.estimate.kind, d.separation);
    list.push_back({{"separation_m", json_numbers(d.separation)},
                    {"mean_square_m2", json_numbers(d.mean_square)},
                    {"pairs", json_numbers(d.pairs)},
                    {"model_m2", json_numbers(model)}});
  }
  return list;
}

Json line_json(const DrawingLine& line) {
  if (!std::isfinite(line.exponent)) return nullptr;
  return {{"exponent", line.exponent},
          {"exponent_std", json_number(line.exponent_std)},
          {"interval", Json::array({json_number(line.lower), json_number(line.upper)})},
          {"roughness", line_block(line)},
          {"amplitude", json_number(line.amplitude)},
          {"log_amplitude_std", json_number(line.log_amplitude_std)},
          {"f_min_per_m", line.f_min},
          {"f_max_per_m", line.f_max},
          {"rms_height_over_data", json_number(line.factor)},
          {"describes", line.describes}};
}

Json lines_json(const PsdEstimate& estimate) {
  Json list = Json::array();
  for (const SpectralLine& line : estimate.lines)
    list.push_back({{"frequency_per_m", line.frequency},
                    {"angle_rad", json_number(line.angle)},
                    {"rms_height_m", json_number(line.rms)},
                    {"strength", json_number(line.strength)},
                    {"false_alarm", json_number(line.false_alarm)}});
  return list;
}

Json model_json(const PsdModelFit& fit) {
  Json parameters = Json::array(), candidates = Json::array(), covariance = Json::array();
  for (const PsdParameter& p : fit.parameters)
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"value", json_number(p.value)},
                          {"std", json_number(p.std)},
                          {"interval", Json::array({json_number(p.lower), json_number(p.upper)})},
                          {"identified", p.identified}});
  for (const PsdCandidate& c : fit.candidates)
    candidates.push_back({{"family", to_string(c.family)},
                          {"parameters", c.parameters},
                          {"log_likelihood", json_number(c.log_likelihood)},
                          {"criterion", json_number(c.criterion)}});
  for (Eigen::Index i = 0; i < fit.covariance.rows(); ++i)
    covariance.push_back(json_numbers(fit.covariance.row(i)));
  return {{"status", to_string(fit.status)},
          {"message", fit.message},
          {"family", to_string(fit.family)},
          {"f_min_per_m", json_number(fit.f_min)},
          {"f_max_per_m", json_number(fit.f_max)},
          {"parameters", parameters},
          {"log_covariance", covariance},
          {"log_likelihood", json_number(fit.log_likelihood)},
          {"criterion", json_number(fit.criterion)},
          {"goodness", json_number(fit.goodness)},
          {"model_error", json_number(fit.model_error)},
          {"candidates", candidates}};
}

// As RFC 4180 has it: in quotes where it holds a comma, a quote or the end of a line.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

Json line_block(const DrawingLine& line) {
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

Json to_json(const PsdReport& report, const Json& request, const Json& roughness) {
  const PsdEstimate& e = report.estimate;
  return {{"aberfit", 1},
          {"kind", "psd"},
          {"request", request},
          {"measurements", measurements_json(report)},
          {"estimate",
           {{"kind", of_profiles(report) ? "1d-one-sided" : "2d-two-sided"},
            {"rms_height_m", json_number(e.rms_height)},
            {"rms_slope", json_number(e.rms_slope)},
            {"rms_slope_x", json_number(e.rms_slope_x)},
            {"rms_slope_y", json_number(e.rms_slope_y)},
            {"rms_slope_as_slopes", json_number(e.rms_slope_as_slopes)},
            {"resolution_per_m", json_number(e.resolution)},
            {"nyquist_per_m", json_number(e.nyquist)},
            {"trusted_from_per_m", json_number(e.trusted_from > 0 ? e.trusted_from : NAN)},
            {"trusted_to_per_m", json_number(e.trusted_to)},
            {"bins", bins_json(report)},
            {"lines", lines_json(e)}}},
          {"model", model_json(report.fit)},
          {"in_band", in_band_json(report)},
          {"bands", bands_json(report.bands)},
          {"octaves", bands_json(octaves(report.surface, report.estimate.kind))},
          {"structure_function", differences_json(report)},
          {"drawing_line", line_json(report.line)},
          {"roughness", roughness},
          {"roughness_as_measured",
           std::isfinite(report.as_measured.exponent) ? line_block(report.as_measured) : Json()},
          {"warnings", json_warnings(report.warnings)},
          {"provenance", to_json(report.provenance)}};
}

std::string bands_csv(const PsdReport& report) {
  std::string text =
      "# RMS height and slope by band: those asked for, then octaves; of the bins from .. to in each, of "
      "data and model; empty without bins\n# Slopes of profiles are along them, those of maps per axis\n"
      "name,f_min_per_m,f_max_per_m,from_per_m,to_per_m,rms_height_m,rms_slope_rad,model_rms_height_m,"
      "model_rms_slope_rad\n";
  const auto add = [&](const BandContent& c, const std::string& name) {
    text += fmt::format("{},{:.9g},{:.9g}", csv_field(name), c.band.f_min, c.band.f_max);
    for (const double value : {c.from, c.to, c.data.height, c.data.slope, c.model.height, c.model.slope})
      text += c.to > 0 ? fmt::format(",{:.9g}", value) : ",";  // no bins, no numbers
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
      "# {} PSD of the surface, {}; frequency in cycles/m\n"
      "# What the estimator does to the surface is divided out{}\n"
      "# For `\"model\": \"table\"`: \"kind\": \"{}\", \"frequency_unit\": \"/m\", \"psd_unit\": \"{}\"\n"
      "frequency_per_m,psd_{},lower,upper,dof,model\n",
      profiles ? "One-sided profile" : "Two-sided, radially averaged two-dimensional",
      fmt::format("{:.4g} % intervals", 100 * report.estimate.options.confidence),
      left_out == 0
          ? ""
          : fmt::format(
                "; left out: {} where that is more than a factor 2, where shape leaks in, or beyond the "
                "instrument",
                plural(left_out, "bin")),
      profiles ? "1d" : "2d", profiles ? "m^3" : "m^4", profiles ? "m3" : "m4");
  for (Eigen::Index b = 0; b < s.psd.size(); ++b)
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{:.9g},{:.9g},{:.4g},{:.9g}\n", s.frequency[b],
                   s.psd[b], s.lower[b], s.upper[b], s.dof[b], s.model[b]);
  return text;
}

}  // namespace aberfit
