#include "aberfit/report/psd_report.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "json_number.h"

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
    list.push_back(std::move(one));
  }
  return list;
}

Json bins_json(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const std::string unit = of_profiles(report) ? "_m3" : "_m4";
  Json list = Json::array();
  for (Eigen::Index b = 0; b < e.frequency.size(); ++b)
    list.push_back({{"frequency_per_m", e.frequency[b]},
                    {"low_per_m", e.low[b]},
                    {"high_per_m", e.high[b]},
                    {"psd" + unit, json_number(e.psd[b])},
                    {"lower" + unit, json_number(e.lower[b])},
                    {"upper" + unit, json_number(e.upper[b])},
                    {"ordinates", json_number(e.count[b])},
                    {"dof", json_number(e.dof[b])},
                    {"model" + unit,
                     b < report.fit.expected.size() ? json_number(report.fit.expected[b]) : Json(nullptr)}});
  return list;
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

}  // namespace

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
            {"resolution_per_m", json_number(e.resolution)},
            {"nyquist_per_m", json_number(e.nyquist)},
            {"bins", bins_json(report)},
            {"lines", lines_json(e)}}},
          {"model", model_json(report.fit)},
          {"roughness", roughness},
          {"warnings", json_warnings(report.warnings)},
          {"provenance", to_json(report.provenance)}};
}

std::string psd_csv(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const bool profiles = of_profiles(report);
  std::string text = fmt::format(
      "# {} PSD of the surface, {}; frequency in cycles/m\n"
      "# For `\"model\": \"table\"`: \"kind\": \"{}\", \"frequency_unit\": \"/m\", \"psd_unit\": \"{}\"\n"
      "frequency_per_m,psd_{},lower,upper,dof,model\n",
      profiles ? "One-sided profile" : "Two-sided, radially averaged two-dimensional",
      fmt::format("{:.4g} % intervals", 100 * e.options.confidence), profiles ? "1d" : "2d",
      profiles ? "m^3" : "m^4", profiles ? "m3" : "m4");
  for (Eigen::Index b = 0; b < e.frequency.size(); ++b) {
    const double model = b < report.fit.expected.size() ? report.fit.expected[b] : NAN;
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{:.9g},{:.9g},{:.4g},{:.9g}\n", e.frequency[b],
                   e.psd[b], e.lower[b], e.upper[b], e.dof[b], model);
  }
  return text;
}

}  // namespace aberfit
