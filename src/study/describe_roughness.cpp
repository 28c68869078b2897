#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "aberfit/roughness/k_correlation.h"
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
  v.quantity_or({"f_max", "upper edge of the band [cycles/m]; absent: no limit", kOptional, "\"10 /mm\""},
                f_max, kUnbounded, kFrequency, Range::positive());
}

void describe(Visitor& v, UniformPsd& m) {
  describe_rms(v, m.rms);
  describe_f_min(v, m.f_min, kRequired);
  v.quantity({"f_max", "upper edge of the band [cycles/m]", kRequired, "\"39.92 /m\""}, m.f_max, kFrequency,
             Range::positive());
  require_band(v, m.f_min, m.f_max);
}

// A study gives B, or the length l = B/(2 pi) that other authors use: the autocorrelation is proportional to
// (r/l)^nu K_nu(r/l), nu = exponent/2 - 1 (Church, Takacs and Leonard 1989).
void describe_correlation(Visitor& v, double& correlation) {
  constexpr double kPerLength = 2 * std::numbers::pi;
  std::optional<double> b, length;
  if (!v.reading() && correlation > 0) b = correlation;
  v.quantity({"B", "correlation parameter [m], with the knee at f = 1/B; this or correlation_length",
              kOptional, "\"50 mm\""},
             b, kLength, Range::positive());
  v.quantity({"correlation_length",
              "l = B/(2 pi) [m], where the autocorrelation is 1/e at exponent 3: exp(-r/l); instead of B",
              kOptional, "\"8 mm\""},
             length, kLength, Range::positive());
  v.check(b.has_value() != length.has_value(), length ? "correlation_length" : "B",
          length ? "a correlation_length beside B" : "neither B nor correlation_length",
          "exactly one of them: B, or correlation_length = B/(2 pi)");
  if (b) correlation = *b;
  if (length) correlation = kPerLength * *length;
}

void describe(Visitor& v, KCorrelationPsd& m) {
  std::optional<double> rms, amplitude;
  if (!v.reading() && m.rms > 0) rms = m.rms;
  v.quantity({"rms", "RMS surface height inside the band [m]; this or amplitude", kOptional, "\"20 nm\""},
             rms, kLength, kRoughnessHeight);
  v.quantity({"amplitude",
              "two-sided 2-D PSD [m^4] at 1 cycle/m of the power law far above the knee, amplitude "
              "f^-exponent; instead of rms. Von Karman's law has B = L0, its outer scale",
              kOptional, "\"1 nm^2 mm^2\""},
             amplitude, kPsd2d, Range::positive());
  v.check(rms.has_value() != amplitude.has_value(), rms ? "amplitude" : "rms",
          rms ? "an amplitude beside rms" : "neither rms nor amplitude", "exactly one of rms and amplitude");
  describe_correlation(v, m.correlation);
  v.quantity({"exponent", "2-D exponent c of (1 + (B f)^2)^(-c/2)", kRequired, "3.5"}, m.exponent, kNumber,
             Range{0, 20, true, false});
  describe_f_min(v, m.f_min, kOptional);
  describe_unbounded_f_max(v, m.f_max);
  require_band(v, m.f_min, m.f_max);
  if (rms) m.rms = *rms;
  if (!amplitude) return;
  v.check(m.exponent > 2 || std::isfinite(m.f_max), "f_max", "no upper end for a PSD that falls so slowly",
          "an upper end, or an exponent above 2");
  m = k_correlation_model({*amplitude * std::pow(m.correlation, m.exponent), m.correlation, m.exponent},
                          m.f_min, m.f_max);
}

// A line in a drawing, the PSD A/f^B of profiles.
struct DrawnLine {
  double level = 0, at = 1, exponent = 0;
};

void describe(Visitor& v, DrawnLine& line) {
  v.quantity({"A", "one-sided PSD of a profile at f = f_unit [m^3]", kRequired, "\"0.01 nm^2 mm\""},
             line.level, kPsd1d, Range::positive());
  std::string unit;
  v.text({"f_unit", "unit of f", kRequired, "\"1/mm\""}, unit, false);
  check_unit(v, "f_unit", unit, kFrequency);
  if (v.reading()) line.at = unit_factor(unit, kFrequency);
  v.quantity({"B", "1-D exponent of A/f^B; the exponent of the surface is larger by one", kRequired, "2"},
             line.exponent, kNumber, Range{0.05, 15});
}

// Sets the surface whose profiles have this line at all frequencies. Abel's relation gives it (PHYSICS 3).
void take_line(const DrawnLine& line, PowerLawPsd& m) {
  const KCorrelation2d surface = k_correlation_1d_to_2d(
      {line.level * std::pow(line.at, line.exponent), 1, line.exponent});  // far above its knee at 1 cycle/m
  m.amplitude = surface.amplitude;
  m.exponent = surface.exponent;
}

void describe(Visitor& v, PowerLawPsd& m) {
  v.quantity({"rms", "RMS surface height inside the band [m]; this, amplitude or profile_psd", kOptional,
              "\"20 nm\""},
             m.rms, kLength, kRoughnessHeight);
  v.quantity({"amplitude", "two-sided 2-D PSD at 1 cycle/m [m^4]; this, rms or profile_psd", kOptional,
              "\"1 nm^2 mm^2\""},
             m.amplitude, kPsd2d, Range::positive());
  std::optional<DrawnLine> line;
  v.optional_object({"profile_psd",
                     "one-sided profile PSD A/f^B of a drawing (ISO 10110-8), instead of rms, amplitude and "
                     "exponent; f_min and f_max are its band"},
                    line, describe);
  const int given = (m.rms ? 1 : 0) + (m.amplitude ? 1 : 0) + (line ? 1 : 0);
  v.check(given == 1,
          line    ? "profile_psd"
          : m.rms ? "amplitude"
                  : "rms",
          given == 0 ? "none of rms, amplitude and profile_psd" : fmt::format("{} of them", given),
          "exactly one of rms, amplitude and profile_psd");
  std::optional<double> exponent;
  if (!v.reading() && (m.rms || m.amplitude)) exponent = m.exponent;
  v.quantity({"exponent", "b of the 2-D PSD amplitude f^-b; not together with profile_psd, which has its own",
              kOptional, "3"},
             exponent, kNumber, Range{-20, 20});
  v.check(exponent.has_value() != line.has_value(), "exponent",
          line ? "both exponent and profile_psd" : "no exponent",
          line ? "profile_psd alone; its B gives the exponent" : "the 2-D exponent b of amplitude f^-b");
  if (exponent) m.exponent = *exponent;
  if (line && v.reading()) take_line(*line, m);
  describe_f_min(v, m.f_min, kRequired);
  describe_unbounded_f_max(v, m.f_max);
  require_band(v, m.f_min, m.f_max);
}

void describe(Visitor& v, GaussianPsd& m) {
  describe_rms(v, m.rms);
  v.quantity(
      {"correlation_length", "l of the autocorrelation rms^2 exp(-(r/l)^2) [m]", kRequired, "\"20 mm\""},
      m.correlation_length, kLength, Range::positive());
}

void describe(Visitor& v, PsdTableFile& m) {
  v.text({"file", "table of frequency and PSD, one pair per line; relative to the study file", kRequired,
          "\"m3_psd.csv\""},
         m.file, false);
  v.word({"kind", "\"2d\": two-sided two-dimensional PSD; \"1d\": one-sided PSD of a profile"}, m.kind,
         {"2d", "1d"});
  const Dimension dimension = m.kind == "1d" ? kPsd1d : kPsd2d;
  v.text({"frequency_unit", "unit of the frequency column, where the header of the file does not say",
          kOptional, "\"1/mm\""},
         m.frequency_unit, true);
  if (!m.frequency_unit.empty()) check_unit(v, "frequency_unit", m.frequency_unit, kFrequency);
  v.text({"psd_unit", "unit of the PSD column, where the header of the file does not say", kOptional,
          "\"nm^2 mm^2\""},
         m.psd_unit, true);
  if (!m.psd_unit.empty()) check_unit(v, "psd_unit", m.psd_unit, dimension);
  v.word({"of", "measured quantity; heights of a wavefront are twice those of the surface"}, m.of,
         {"surface", "wavefront"});
  v.quantity({"scale", "factor on the heights, to use a measured shape for another mirror"}, m.scale, kNumber,
             Range::positive());
  v.quantity({"f_min", "lower end of the part of the table that is used [cycles/m]", kOptional, "\"2.5 /m\""},
             m.f_min, kFrequency, Range::non_negative());
  v.quantity({"f_max", "upper end of the part of the table that is used [cycles/m]", kOptional, "\"1 /mm\""},
             m.f_max, kFrequency, Range::positive());
  if (m.f_min && m.f_max) require_band(v, *m.f_min, *m.f_max);
}

void describe(Visitor& v, MeasuredPsd& m) { describe_measured_psd(v, m); }

void describe(Visitor& v, RoughnessSum& m) {
  v.list(
      {"parts", "PSD models that are added", kRequired}, m.parts.size(), 1,
      [&](std::size_t count) { m.parts.resize(count); },
      [&](Visitor& part, std::size_t i) { describe_psd_block(part, m.parts[i]); }, "psd");
}

// Every node with its word.
template <class... Nodes>
std::vector<std::pair<std::string, std::variant<Nodes...>>> kinds_of(const std::variant<Nodes...>&) {
  return {{Nodes::kModel, Nodes{}}...};
}

}  // namespace

void require_band(Visitor& v, double f_min, double f_max) {
  v.check(f_min < f_max, "f_max", format_quantity(f_max, kFrequency),
          "a spatial frequency above f_min = " + format_quantity(f_min, kFrequency));
}

void describe_psd_block(Visitor& v, RoughnessModel& node) {
  v.kind({"model", "model of the PSD; the keys beside it belong to the model", kRequired}, node.model,
         kinds_of(node.model));
  std::visit([&](auto& model) { describe(v, model); }, node.model);
  v.text({"name", "name of this roughness, for example as a part of a sum", kOptional, "\"polishing\""},
         node.name, true);
}

void describe_roughness(Visitor& v, std::optional<RoughnessModel>& roughness) {
  v.optional_object({"roughness", "surface roughness; needed unless every statistic has a value", kUsual,
                     R"({"psd": {"model": "uniform", "rms": "20 nm", "f_min": "2.5 /m", "f_max": "40 /m"}})"},
                    roughness, [](Visitor& r, RoughnessModel& node) {
                      r.object(
                          {"psd", "isotropic two-dimensional, two-sided PSD of surface height", kRequired},
                          nullptr, [&](Visitor& psd) { describe_psd_block(psd, node); }, "psd");
                    });
}

}  // namespace aberfit::internal
