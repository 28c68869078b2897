#include <fmt/format.h>

#include "aberfit/core/text.h"
#include "describe.h"
#include "statistic_key.h"

namespace aberfit::internal {
namespace {

// Describes an encircled-energy radius, as a length or an angle on the sky. `per_radius` is 2 if the key is a
// diameter.
void describe_radius(Visitor& v, StatisticRequest& s, double focal_length, double per_radius) {
  std::optional<std::variant<std::string, double>> extent;
  if (s.value) extent = per_radius * *s.value;
  describe_extent_in_focus(
      v,
      {"value", "target value [m], or angle on the sky (\"0.6 arcsec\"); absent: from theory", kOptional,
       "\"76 um\""},
      extent);
  double error = per_radius * s.standard_error;
  v.quantity({"standard_error", "sampling error of the given value [m]"}, error, kLength,
             Range::non_negative());
  if (!v.reading()) return;
  s.standard_error = error / per_radius;
  s.value = std::nullopt;
  if (!extent) return;
  const auto* angle = std::get_if<std::string>(&*extent);
  if (angle) {
    const std::string_view typed = trimmed(*angle);
    s.asked.unit = typed.substr(typed.find_last_of(" .0123456789") + 1);
    s.asked.per_si = per_radius / (focal_length * unit_factor(s.asked.unit, kAngle));
  }
  s.value = (angle ? focal_length * parse_quantity(*angle, kAngle) : std::get<double>(*extent)) / per_radius;
}

void describe_plain_value(Visitor& v, StatisticRequest& s, Dimension dimension) {
  const bool angle = dimension == kAngle, share = dimension == kFraction;
  v.quantity({"value",
              share   ? "target value, a fraction; absent: from theory"
              : angle ? "target value [rad]; absent: from theory"
                      : "target value [m]; absent: from theory",
              kOptional,
              share   ? "\"80 %\""
              : angle ? "\"36 urad\""
                      : "\"76 um\""},
             s.value, dimension, share ? Range{0, 1, true, true} : Range::positive());
  v.quantity({"standard_error", "sampling error of the given value, in its unit"}, s.standard_error,
             dimension, Range::non_negative());
}

// Only encircled energies use focal_length and per_radius.
void describe_value(Visitor& v, StatisticRequest& s, double focal_length, double per_radius) {
  const Dimension dimension = kind_of_key(s.name).dimension;
  const bool share = dimension == kFraction;
  v.quantity(
      {"tolerance", share ? "absolute tolerance of the fit" : "tolerance of the fit, relative to the value",
       kOptional, "\"0.2 %\""},
      s.tolerance, kFraction, Range{0, 1, true, false});
  if (option_of_key(s.name).form == StudyOption::kPercent)
    describe_radius(v, s, focal_length, per_radius);
  else
    describe_plain_value(v, s, dimension);
  v.check(s.value.has_value() || s.standard_error == 0, "standard_error", "standard_error without value",
          "standard_error beside a value only");
}

void describe_planes(Visitor& v, StatisticRequest& s) {
  v.quantities({"planes", "planes dz from z = f [m]", kOptional, "[\"0 mm\", \"-1 mm\"]"}, s.planes, kLength,
               Range::any(), false);
  for (std::size_t i = 0; i < s.planes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      v.check(s.planes[i] != s.planes[j], "planes/" + std::to_string(i),
              format_quantity(s.planes[i], kLength) + " twice", "every plane once");
  v.check(!s.value || s.planes.size() == 1, "planes",
          std::to_string(s.planes.size()) + " planes for one value", "one plane where value is given");
}

// Describes the places where a statistic is asked for, such as radii. A given value needs exactly one place.
void describe_places(Visitor& v, const StudyOption& option, StatisticRequest& s) {
  v.quantities({option.key, option.text, kRequired, option.example}, s.places, option.dimension,
               Range::positive(), true);
  v.check(!s.value || s.places.size() == 1, option.key,
          fmt::format("{} {} for one value", s.places.size(), option.key),
          fmt::format("one {} where value is given", option.one));
}

void describe_ring(Visitor& v, StatisticRequest& s) {
  v.word_or_quantity(
      {"ring", "radius of the ring [m], or name of an encircled-energy radius at z = f (\"ee90\")", kOptional,
       "\"ee90\""},
      s.ring, kEncircledEnergyName, kLength, Range::positive());
}

void describe_profile(Visitor& v, StatisticRequest& s) {
  describe_ring(v, s);
  v.quantity({"tolerance", "tolerance of the fit, absolute fraction of the energy"}, s.tolerance, kFraction,
             Range{0, 1, true, false});
  v.text({"file",
          "CSV table of dz (in m unless its header says dz_mm or similar) and energy fraction, one pair per "
          "line; relative to the study file",
          kOptional, "\"ring_through.csv\""},
         s.file, true);
  // The resolved study names the file, not what was loaded from it.
  std::vector<double> dz, values;
  if (s.file.empty() && !v.reading()) dz = s.profile_dz, values = s.profile_value;
  v.quantities(
      {"dz", "planes of `values` [m], ascending; instead of file", kOptional, "[\"-1 mm\", \"0 mm\"]"}, dz,
      kLength, Range::any(), true);
  v.quantities({"values", "energy fraction inside the ring, one for each dz", kOptional, "[0.4, 0.9]"},
               values, kFraction, Range{0, 1}, false);
  if (!v.reading()) return;
  const bool in_line = !dz.empty() || !values.empty();
  v.check(s.file.empty() != !in_line, in_line ? "file" : "values",
          in_line ? "file beside dz and values" : "neither file nor values", "either file, or dz and values");
  v.check(dz.size() == values.size(), "values",
          std::to_string(values.size()) + " values for " + std::to_string(dz.size()) + " planes dz",
          "as many as dz");
  s.profile_dz = dz;
  s.profile_value = values;
}

void describe_statistic(Visitor& v, StatisticRequest& s, const std::string& key, double focal_length) {
  if (s.name == "ring_profile") return describe_profile(v, s);
  const StatisticKind& kind = kind_of_key(s.name);
  const StudyOption& option = option_of_key(s.name);
  if (option.form == StudyOption::kRing && key.find('@') == std::string::npos) describe_ring(v, s);
  if (option.form == StudyOption::kWidth)
    v.quantity({option.key, option.text, kOptional, option.example}, s.bandwidth, option.dimension,
               Range::positive());
  describe_value(v, s, focal_length, is_diameter(key) ? 2 : 1);
  if (option.form == StudyOption::kPlaces) describe_places(v, option, s);
  if (kind.plane == FocalPlane::kGiven) describe_planes(v, s);
}

void describe_psd_target(Visitor& v, PsdTarget& target) {
  v.quantity({"f_min", "lower edge of the bins [cycles/m]; absent: that of the band that the terms carry",
              kOptional, "\"5 /m\""},
             target.f_min, kFrequency, Range::positive());
  v.quantity({"f_max", "upper edge of the bins [cycles/m]; absent: that of the band that the terms carry",
              kOptional, "\"20 /m\""},
             target.f_max, kFrequency, Range::positive());
  v.check(!target.f_min || !target.f_max || *target.f_min < *target.f_max, "f_max",
          format_quantity(target.f_max.value_or(0), kFrequency), "a spatial frequency above f_min");
  v.integer({"bins_per_decade", "logarithmic bins"}, target.bins_per_decade, 1, 100);
  v.quantity({"tolerance", "tolerance of log PSD", kOptional, "\"5 %\""}, target.tolerance, kFraction,
             Range{0, 1, true, false});
  v.word({"method",
          "closed-form: for Zernikes over the whole disc; estimator: for any terms, on a grid with the "
          "estimator of a measurement"},
         target.method, {"closed-form", "estimator"});
}

}  // namespace

void describe_target(Visitor& v, TargetSpec& target, std::optional<MapTarget>& map, double focal_length) {
  v.object({"target", "targets of the fit"}, nullptr, [&](Visitor& t) {
    t.choice_or_auto({"theory",
                      "theory for targets without a value; auto: the model that the scene needs; geometric, "
                      "rays: Gaussian ray deflections; ghs: generalised Harvey-Shack, wave optics"},
                     target.theory, {Theory::kGeometric, Theory::kRays, Theory::kGhs});
    t.choice_of({"convention", "physical: a ray turns by twice the slope; paper: by the slope"},
                target.convention, {"physical", "paper"});
    std::vector<std::string> keys = keys_of(target.statistics);
    std::vector<StatisticRequest> requests = target.statistics;
    t.keyed({"statistics", "focal statistics to match; absent: the default set", kOptional,
             R"({"ee50": {"planes": ["0 mm", "-1 mm"]}, "ring_fwhm": {"ring": "ee90"}, "rms_height": {}})"},
            keys, statistic_keys(), [&](Visitor& s, std::size_t i) {
              requests.resize(keys.size());
              StatisticRequest fresh = request_of(keys[i]);
              if (s.reading() || requests[i].name != fresh.name) requests[i] = std::move(fresh);
              describe_statistic(s, requests[i], keys[i], focal_length);
            });
    t.optional_object({"psd",
                       "PSD bins of the surface of terms to match as well; their targets are the expected "
                       "bins of the roughness"},
                      target.psd, describe_psd_target);
    t.optional_object({"map",
                       "measured map to fit by least squares, instead of statistics; with a roughness (its "
                       "specification) it is judged by wave optics"},
                      map, describe_map_target);
    if (!t.reading()) return;
    t.check(!map || (keys.empty() && !target.psd), "map", "a map beside statistics or psd",
            "either a map, or statistics and psd");
    requests.resize(keys.size());
    target.statistics = requests;
    for (StatisticRequest& request : requests) request.asked = {};
    const std::vector<std::string> canonical = keys_of(requests);
    for (std::size_t i = 0; i < canonical.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        t.check(canonical[i] != canonical[j], "statistics/" + keys[i],
                "the statistic of \"" + keys[j] + "\" again", "every statistic once");
  });
}

}  // namespace aberfit::internal
