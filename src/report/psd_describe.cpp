// This file describes a measured PSD: result.json of kind "psd".
#include <cmath>

#include "aberfit/report/psd_report.h"
#include "facts.h"

namespace aberfit::internal {

static void describe(Facts& facts, const BandRms& rms) {
  facts("rms_height_m", rms.height, "RMS height.");
  facts("rms_slope", rms.slope, "RMS slope, along a profile, per axis of a map.");
}

static void describe(Facts& facts, const BandContent& content) {
  const bool there = content.to > 0;
  const auto known = [there](auto value) { return there ? std::optional(value) : std::nullopt; };
  facts.where(!content.band.name.empty(), "name", content.band.name, "Name of the band.");
  facts("f_min_per_m", content.band.f_min, "Lower end of the band.");
  facts("f_max_per_m", content.band.f_max, "Upper end of the band.");
  facts("from_per_m", known(content.from), "Lower edge of the first bin in the band; null without bins.");
  facts("to_per_m", known(content.to), "Upper edge of the last bin in the band.");
  facts("data", known(content.data), "RMS of the bins.");
  facts("model", known(content.model), "RMS of the model in the same bins.");
}

static void describe(Facts& facts, const SpectralLine& line) {
  facts("frequency_per_m", line.frequency, "Frequency of the line.");
  facts("angle_rad", line.angle, "Its direction on a map.");
  facts("rms_height_m", line.rms, "RMS height of the line.");
  facts("strength", line.strength, "Power of the line over the background.");
  facts("false_alarm", line.false_alarm, "Probability that noise alone has such a line.");
}

static void describe(Facts& facts, const PsdParameter& p) {
  facts("name", p.name, "Name of the parameter.");
  facts("unit", p.unit, "Its unit.");
  facts("value", p.value, "Its value.");
  facts("std", p.std, "Its standard deviation.");
  facts("interval", std::array{p.lower, p.upper}, "Its confidence interval.");
  facts("identified", p.identified, "Whether the data determine it.");
}

static void describe(Facts& facts, const PsdCandidate& candidate) {
  facts("family", candidate.family, "Family of PSD models.");
  facts("parameters", candidate.parameters, "Number of its parameters.");
  facts("log_likelihood", candidate.log_likelihood, "Logarithm of its likelihood.");
  facts("criterion", candidate.criterion, "Information criterion; the model with the least value is taken.");
}

static void describe(Facts& facts, const PsdModelFit& fit) {
  std::vector<Eigen::VectorXd> covariance;
  for (Eigen::Index i = 0; i < fit.covariance.rows(); ++i) covariance.emplace_back(fit.covariance.row(i));
  facts("status", fit.status, "How the fit of the model ended.");
  facts("message", fit.message, "How the fit ended, in a sentence.");
  facts("family", fit.family, "The chosen model.");
  facts("f_min_per_m", fit.f_min, "Lower edge of the fitted band.");
  facts("f_max_per_m", fit.f_max, "Upper edge of the fitted band.");
  facts("parameters", fit.parameters, "Its parameters.");
  facts("log_covariance", covariance, "Covariance of the logarithms of the parameters.");
  facts("log_likelihood", fit.log_likelihood, "Logarithm of the likelihood.");
  facts("criterion", fit.criterion, "Information criterion of the model.");
  facts("goodness", fit.goodness, "Probability that data drawn from the model fit it no better (p-value).");
  facts("model_error", fit.model_error, "Relative error of the model beyond what chance explains.");
  facts("candidates", fit.candidates, "All models that were tried.");
}

namespace {

struct MeasurementFacts {
  std::string file;
  Measurement data;
  ClearRegion clear;
};

void describe(Facts& facts, const MeasurementFacts& one) {
  const auto* profile = std::get_if<Profile>(&one.data);
  const auto* map = std::get_if<HeightMap>(&one.data);
  const Profile p = profile ? *profile : Profile();
  const HeightMap m = map ? *map : HeightMap();
  const Eigen::Index n = p.size();
  facts("file", one.file, "The file.");
  facts("kind", profile ? "profile" : "map", "profile or map.");
  facts.where(profile, "quantity", p.quantity == ProfileQuantity::kSlope ? "slope" : "height",
              "height or slope.");
  facts("label", profile ? p.label : m.label, "Title or label in the file.");
  facts.where(profile, "samples", n, "Number of samples.");
  facts.where(map, "columns", m.columns(), "Number of columns.");
  facts.where(map, "rows", m.rows(), "Number of rows.");
  facts("valid", profile ? valid_count(p) : valid_count(m), "Number of samples that have a value.");
  facts.where(profile, "length_m", n > 0 ? p.x[n - 1] - p.x[0] : 0, "Length of the profile.");
  facts.where(profile, "pitch_m", n > 1 ? median_pitch(p) : 0, "Distance of its samples.");
  facts.where(map, "pitch_x_m", m.pitch_x, "Distance of the columns.");
  facts.where(map, "pitch_y_m", m.pitch_y, "Distance of the rows.");
  facts("clear", used_part(one.clear), "The part of the file that was used; null: the whole file.");
}

// A bin as estimated, and that of the surface if it is known.
struct BinFacts {
  bool of_profile = true;
  double frequency = 0, low = 0, high = 0;
  double psd = kNaN, lower = kNaN, upper = kNaN, model = kNaN;
  double estimated = 0, ordinates = 0, dof = 0;
};

void describe(Facts& facts, const BinFacts& bin) {
  facts("frequency_per_m", bin.frequency, "Frequency of the bin.");
  facts("low_per_m", bin.low, "Its lower edge.");
  facts("high_per_m", bin.high, "Its upper edge.");
  for (const bool of_profile : {true, false}) {
    const std::string unit = of_profile ? "_m3" : "_m4";
    const auto add = [&](const char* key, double value, const char* meaning) {
      facts.where(bin.of_profile == of_profile, (key + unit).c_str(), value, meaning);
    };
    add("psd", bin.psd, "PSD of the surface; null where the estimate does not determine it.");
    add("lower", bin.lower, "Lower end of its interval.");
    add("upper", bin.upper, "Upper end of its interval.");
    add("model", bin.model, "PSD of the fitted model.");
    add("estimated", bin.estimated, "PSD as estimated, before division by the estimator's response.");
  }
  facts("ordinates", bin.ordinates, "Number of periodogram ordinates in the bin.");
  facts("dof", bin.dof, "Degrees of freedom of the bin.");
}

std::vector<BinFacts> bins_of(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const SurfacePsd& s = report.surface;
  std::vector<BinFacts> bins(std::size_t(e.frequency.size()));
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const Eigen::Index k = Eigen::Index(b);
    bins[b] = {e.kind == PsdTableKind::k1dOneSided,
               e.frequency[k],
               e.low[k],
               e.high[k],
               kNaN,
               kNaN,
               kNaN,
               kNaN,
               e.psd[k],
               e.count[k],
               e.dof[k]};
  }
  for (Eigen::Index i = 0; i < s.psd.size(); ++i) {
    BinFacts& bin = bins[std::size_t(s.bin[std::size_t(i)])];
    bin.psd = s.psd[i], bin.lower = s.lower[i], bin.upper = s.upper[i], bin.model = s.model[i];
  }
  return bins;
}

struct DifferenceFacts {
  HeightDifferences of;
  Eigen::ArrayXd model;
};

void describe(Facts& facts, const DifferenceFacts& d) {
  facts("separation_m", d.of.separation, "Separations of two points.");
  facts("mean_square_m2", d.of.mean_square, "Mean square difference of their heights.");
  facts("pairs", d.of.pairs, "Number of pairs of points.");
  facts("model_m2", d.model, "The model's mean square difference.");
}

}  // namespace

static void describe(Facts& facts, const DrawingLine& line) {
  facts("exponent", line.exponent, "B of A/f^B.");
  facts("exponent_std", line.exponent_std, "Its standard deviation.");
  facts("interval", std::array{line.lower, line.upper}, "Its confidence interval.");
  facts("roughness", facts.view() == Facts::View::kSchema ? Json::object() : line_block(line),
        "A block to paste into a study.");
  facts("amplitude", line.amplitude, "A, a one-sided profile PSD at 1 cycle/m [m^3].");
  facts("log_amplitude_std", line.log_amplitude_std, "Standard deviation of its logarithm.");
  facts("f_min_per_m", line.f_min, "Lower end of the line.");
  facts("f_max_per_m", line.f_max, "Upper end of the line.");
  facts("rms_height_over_data", line.factor, "RMS height of the straight line over that of the bins.");
  facts("describes", line.describes, "Whether the line describes the data.");
}

static void describe_estimate(Facts& facts, const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  facts("kind", e.kind == PsdTableKind::k1dOneSided ? "1d-one-sided" : "2d-two-sided", "Kind of PSD.");
  facts("rms_height_m", e.rms_height, "RMS height of the detrended surface.");
  facts("rms_slope", e.rms_slope, "RMS slope of the detrended surface, per axis of a map.");
  facts("rms_slope_x", e.rms_slope_x, "RMS slope along x of a map.");
  facts("rms_slope_y", e.rms_slope_y, "RMS slope along y of a map.");
  facts("rms_slope_as_slopes", e.rms_slope_as_slopes, "RMS slope when the slopes themselves are detrended.");
  facts("resolution_per_m", e.resolution, "Width of the estimator's response.");
  facts("nyquist_per_m", e.nyquist, "Nyquist frequency.");
  facts("trusted_from_per_m", e.trusted_from > 0 ? e.trusted_from : kNaN,
        "Lowest frequency at which the estimate holds.");
  facts("trusted_to_per_m", e.trusted_to, "Highest frequency at which the estimate holds.");
  facts("bins", bins_of(report), "The estimate, bin by bin.");
  facts("lines", e.lines, "Spectral lines, which are left out of the bins.");
}

void describe(Facts& facts, const PsdFacts& of) {
  const bool made = of.report != nullptr;
  const PsdReport none, &report = made ? *of.report : none;
  const auto drawn = [](const DrawingLine& line) {
    return std::isfinite(line.exponent) ? std::optional(line) : std::nullopt;
  };
  std::vector<MeasurementFacts> measurements;
  for (std::size_t i = 0; i < report.data.size(); ++i)
    measurements.push_back({report.files.at(i), report.data[i], report.clear.at(i)});
  std::vector<DifferenceFacts> differences;
  for (const HeightDifferences& d : report.differences)
    differences.push_back({d, model_height_differences(report.fit, report.estimate.kind, d.separation)});
  describe_head(facts, "psd");
  facts("request", of.request, "Every option, as a `psd` block of model `measured`.");
  facts("measurements", measurements, "The files.");
  facts.object("estimate", "The PSD as estimated.",
               [&](Facts& inside) { describe_estimate(inside, report); });
  facts("model", report.fit, "The fitted model.");
  facts.object("in_band", "RMS height and slope in the band of the fit.", [&](Facts& inside) {
    inside("data", made ? report.in_band(false) : BandRms(), "RMS of the bins.");
    inside("model", made ? report.in_band(true) : BandRms(), "RMS of the model.");
  });
  facts("bands", report.bands, "The requested bands.");
  facts("octaves", made ? octaves(report.surface, report.estimate.kind) : std::vector<BandContent>(),
        "RMS height and slope octave by octave.");
  facts("structure_function", differences, "Structure function of each file.");
  facts("drawing_line", drawn(report.line), "The line of a drawing; null where there is none.");
  facts("roughness", of.roughness, "The fitted model, a block to paste into a study.");
  const auto as_measured = drawn(report.as_measured);
  facts(
      "roughness_as_measured", as_measured ? line_block(*as_measured) : Json(),
      "Straight line with the RMS height and slope of the bins, where those of the model differ; else null.");
  facts("warnings", report.warnings, "Warnings that the reader should know.");
  facts("provenance", report.provenance, "Program, inputs and seed that this result was made with.");
}

}  // namespace aberfit::internal
