#include "describe.h"

namespace aberfit::internal {
namespace {

// A micrometre written as a plain number ("0.1" for 0.1 um) would be 0.1 m: heights of roughness are never
// that large.
constexpr Range kRoughnessHeight{0, 1e-2, true, false};
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

void describe_rms(Visitor& v, double& rms) {
  v.quantity({"rms", "RMS surface height inside the band [m]", kRequired, "\"100 nm\""}, rms, kLength,
             kRoughnessHeight);
}

void describe_f_min(Visitor& v, double& f_min, Need need) {
  v.quantity({"f_min", "lower edge of the band [cycles/m]", need, "\"2.5 /m\""}, f_min, kFrequency,
             Range::non_negative());
}

void describe_unbounded_f_max(Visitor& v, double& f_max) {
  v.quantity_or({"f_max", "upper edge of the band [cycles/m]; absent: none", kOptional, "\"10 /mm\""}, f_max,
                kUnbounded, kFrequency, Range::positive());
}

void describe(Visitor& v, UniformPsd& m) {
  describe_rms(v, m.rms);
  describe_f_min(v, m.f_min, kRequired);
  v.quantity({"f_max", "upper edge of the band [cycles/m]", kRequired, "\"39.92 /m\""}, m.f_max, kFrequency,
             Range::positive());
  require_band(v, m.f_min, m.f_max);
}

void describe(Visitor& v, KCorrelationPsd& m) {
  describe_rms(v, m.rms);
  v.quantity({"B", "correlation parameter [m]; the knee is at f = 1/B", kRequired, "\"50 mm\""},
             m.correlation, kLength, Range::positive());
  v.quantity({"exponent", "2-D exponent c of (1 + (B f)^2)^(-c/2)", kRequired, "3.5"}, m.exponent, kNumber,
             Range{0, 20, true, false});
  describe_f_min(v, m.f_min, kOptional);
  describe_unbounded_f_max(v, m.f_max);
  require_band(v, m.f_min, m.f_max);
}

void describe(Visitor& v, PowerLawPsd& m) {
  v.quantity({"rms", "RMS surface height inside the band [m]; this or amplitude", kOptional, "\"20 nm\""},
             m.rms, kLength, kRoughnessHeight);
  v.quantity({"amplitude", "two-sided 2-D PSD at 1 cycle/m [m^4]; this or rms", kOptional, "\"1 nm^2 mm^2\""},
             m.amplitude, kPsd2d, Range::positive());
  v.check(m.rms.has_value() != m.amplitude.has_value(), m.rms ? "amplitude" : "rms",
          m.rms ? "rms and amplitude" : "neither rms nor amplitude", "exactly one of rms and amplitude");
  v.quantity({"exponent", "b of the 2-D PSD amplitude f^-b", kRequired, "3"}, m.exponent, kNumber,
             Range{-20, 20});
  describe_f_min(v, m.f_min, kRequired);
  describe_unbounded_f_max(v, m.f_max);
  require_band(v, m.f_min, m.f_max);
}

void describe(Visitor& v, GaussianPsd& m) {
  describe_rms(v, m.rms);
  v.quantity({"correlation_length", "l of the ACF rms^2 exp(-(r/l)^2) [m]", kRequired, "\"20 mm\""},
             m.correlation_length, kLength, Range::positive());
}

void describe(Visitor& v, PsdTableFile& m) {
  v.text({"file", "table of frequency and PSD, one pair a line; relative to the study file", kRequired,
          "\"m3_psd.csv\""},
         m.file, false);
  v.word({"kind", "\"2d\": two-sided two-dimensional PSD; \"1d\": one-sided PSD of a profile"}, m.kind,
         {"2d", "1d"});
  const Dimension dimension = m.kind == "1d" ? kPsd1d : kPsd2d;
  if (v.reading()) m.psd_unit = m.kind == "1d" ? "m^3" : "m^4";  // SI unless the file says otherwise
  v.text({"frequency_unit", "unit of the frequency column", kOptional, "\"1/mm\""}, m.frequency_unit, false);
  check_unit(v, "frequency_unit", m.frequency_unit, kFrequency);
  v.text({"psd_unit", "unit of the PSD column; SI when absent: m^4 for 2d, m^3 for 1d", kOptional,
          "\"nm^2 mm^2\""},
         m.psd_unit, false);
  check_unit(v, "psd_unit", m.psd_unit, dimension);
  v.word({"of", "what was measured; heights of a wavefront are twice the surface's"}, m.of,
         {"surface", "wavefront"});
  v.quantity({"scale", "factor on the heights, to put a measured shape on another mirror"}, m.scale, kNumber,
             Range::positive());
  v.quantity({"f_min", "cut the table below [cycles/m]", kOptional, "\"2.5 /m\""}, m.f_min, kFrequency,
             Range::non_negative());
  v.quantity({"f_max", "cut the table above [cycles/m]", kOptional, "\"1 /mm\""}, m.f_max, kFrequency,
             Range::positive());
  if (m.f_min && m.f_max) require_band(v, *m.f_min, *m.f_max);
}

void describe(Visitor& v, MeasuredPsd& m) { describe_measured_psd(v, m); }

void describe(Visitor& v, RoughnessSum& m) {
  v.list(
      {"parts", "PSD models that are added", kRequired}, m.parts.size(), 1,
      [&](std::size_t count) { m.parts.resize(count); },
      [&](Visitor& part, std::size_t i) { describe_psd_block(part, m.parts[i]); }, "psd");
}

}  // namespace

void require_band(Visitor& v, double f_min, double f_max) {
  v.check(f_min < f_max, "f_max", format_quantity(f_max, kFrequency),
          "a spatial frequency above f_min = " + format_quantity(f_min, kFrequency));
}

void describe_psd_block(Visitor& v, RoughnessModel& node) {
  v.kind({"model", "which PSD; the keys beside it belong to the model", kRequired}, node.model,
         {{"uniform", UniformPsd{}},
          {"k-correlation", KCorrelationPsd{}},
          {"power-law", PowerLawPsd{.rms = {}, .amplitude = {}, .f_max = kUnbounded}},
          {"gaussian", GaussianPsd{}},
          {"table", PsdTableFile{}},
          {"measured", MeasuredPsd{}},
          {"sum", RoughnessSum{}}});
  std::visit([&](auto& model) { describe(v, model); }, node.model);
}

void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness) {
  v.optional_object({"roughness", "surface roughness; needed unless every statistic has a value"}, roughness,
                    [](Visitor& r, RoughnessModel& node) {
                      r.object(
                          {"psd", "isotropic two-dimensional, two-sided PSD of surface height", kRequired},
                          nullptr, [&](Visitor& psd) { describe_psd_block(psd, node); }, "psd");
                    });
}

}  // namespace aberfit::internal
