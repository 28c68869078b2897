// This file describes facts about a scene that several kinds of result share.
#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "facts.h"
#include "split_notes.h"

namespace aberfit::internal {

void describe(Facts& facts, const NamedNumbers& numbers) {
  std::vector<std::pair<std::string, double>> all;
  for (std::size_t k = 0; k < numbers.names.size() && Eigen::Index(k) < numbers.values.size(); ++k)
    all.emplace_back(numbers.names[k], numbers.values[Eigen::Index(k)]);
  facts.numbers(all, "Value of the statistic of that name, in the unit of the name.");
}

namespace {

struct ShownTarget {
  Target target;
};

void describe(Facts& facts, const ShownTarget& shown) {
  const AskedAs& asked = shown.target.asked;
  facts("name", asked.name, "Name of the statistic in the study; empty: the usual name.");
  facts("unit", asked.unit, "Unit in the study; empty: the SI unit.");
  facts("value", shown.target.value * asked.per_si, "Value under that name in that unit.");
}

}  // namespace

void describe(Facts& facts, const Target& target) {
  facts("value", target.value, "Target value, in the unit of the statistic's name.");
  facts("standard_error", target.standard_error, "Sampling error of the value; 0 for closed forms.");
  facts("tolerance", target.tolerance, "Allowed difference of the fitted surface from it.");
  facts.where(!target.asked.as_it_is(), "asked_as", ShownTarget{target}, "How the study specifies it.");
}

void describe(Facts& facts, const EquivalenceMetric& metric) {
  const bool in_light = !std::isnan(metric.tolerance_share), has_spread = metric.spread > 0;
  facts("name", metric.name, "The statistic.");
  facts("held_out", metric.held_out, "Whether it was judged but not fitted.");
  facts("target", metric.target, "Target value.");
  facts("model", metric.model, "Value of the fitted surface.");
  facts("relative_difference", metric.relative_difference, "model/target - 1.");
  facts("difference", metric.difference,
        "Judged difference. For an encircled-energy radius: nominal fraction minus the energy fraction "
        "inside the target's radius, over max(r dE/dr, 0.35). For others: relative_difference.");
  facts("standard_error", metric.standard_error, "Sampling error of the difference.");
  facts("degrees_of_freedom", metric.degrees_of_freedom,
        "Degrees of freedom of the standard error; null: it is exact.");
  facts("interval", metric.interval, "Confidence interval of the difference.");
  facts("margin", metric.margin, "Largest allowed distance of the interval's ends from 0.");
  facts("verdict", metric.verdict, "equivalent, different or undecided.");
  facts.where(metric.model_error > 0, "model_error", metric.model_error,
              "Bound of the model's own error; the interval includes it.");
  facts.where(has_spread, "spread", metric.spread,
              "Standard deviation of the difference among mirrors of the specification.");
  facts.where(has_spread, "difference_in_spreads", metric.difference / metric.spread,
              "The difference over this standard deviation.");
  facts.where(in_light, "share_difference", metric.share_difference,
              "Energy fraction inside the target's radius minus the nominal fraction.");
  facts.where(in_light, "tolerance_share", metric.tolerance_share, "Margin of share_difference.");
}

static void describe(Facts& facts, const Provenance::Input& input) {
  facts("file", input.file, "The file.");
  facts("sha256", input.sha256, "SHA-256 of its content.");
}

void describe(Facts& facts, const Provenance& provenance) {
  facts("version", provenance.version, "Version of aberfit.");
  facts("commit", provenance.commit, "Commit of its source.");
  facts("inputs", provenance.inputs, "The study and the data files that it names.");
  facts("seed", provenance.seed, "Seed of all random numbers.");
  facts("threads", provenance.threads, "Number of threads; results do not depend on it.");
  facts("libraries", provenance.libraries, "Versions of the libraries and of the compiler.");
}

static void describe(Facts& facts, const SpecifiedLight::Line& line) {
  facts("wavelength_m", line.wavelength, "Wavelength of the line.");
  facts("share", line.share, "Fraction of the total energy in the line.");
  facts("ee50_diameter_m", line.ee50_diameter, "Diameter that holds half of the energy of the line.");
  facts("ee80_diameter_m", line.ee80_diameter, "Diameter that holds 80 % of the energy of the line.");
}

static void describe(Facts& facts, const SpecifiedLight& light) {
  std::vector<std::pair<std::string, double>> values;
  for (const SpecifiedValue& one : light.values) {
    values.emplace_back(one.key + (one.is_width ? "_m" : ""), one.value);
    if (one.is_width) values.emplace_back(one.key + "_rad", one.value / light.focal_length);
  }
  facts("theory", light.theory, "ghs or geometric.");
  facts.numbers(values, "A property of the mean PSF, named as in budgets; widths also as angles on the sky.");
  facts.where(!light.lines.empty(), "lines", light.lines, "PSF of each wavelength of the band.");
}

static void describe(Facts& facts, const StatisticSpread& one) {
  facts("name", one.name, "The statistic.");
  facts("relative", one.relative, "Standard deviation of the judged difference among mirrors.");
  facts("tolerances", one.tolerances, "That standard deviation in tolerances.");
}

static void describe(Facts& facts, const MirrorSpread& spread) {
  const StatisticSpread* worst = spread.worst();
  facts("worst", worst ? worst->name : "", "Statistic in which mirrors differ most.");
  facts("statistics", spread.statistics, "Statistics whose spread is known.");
}

static void describe(Facts& facts, const ModelErrors& errors) {
  facts("ray_ee50", errors.ray_ee50, "Relative error of geometric rays in the ee50 radius.");
  facts("ray_ee90", errors.ray_ee90, "Relative error of geometric rays in the ee90 radius.");
}

namespace {

// The prediction of generalised Harvey-Shack.
struct GhsFacts {
  ModelRadii radii;
  double tis = 0;
};

void describe(Facts& facts, const GhsFacts& ghs) {
  facts("ee50_radius_m", ghs.radii.ee50, "Radius that holds half of the energy.");
  facts("ee80_radius_m", ghs.radii.ee80, "Radius that holds 80 % of the energy.");
  facts("ee90_radius_m", ghs.radii.ee90, "Radius that holds 90 % of the energy.");
  facts("core_share", 1 - ghs.tis, "Fraction of the energy that is not scattered.");
}

}  // namespace

void describe(Facts& facts, const SceneFacts& scene) {
  const SceneNumbers& n = scene.numbers;
  facts("rms_height_m", n.rms_height, "RMS height of the specification.");
  facts("rms_slope_per_axis", n.rms_slope_per_axis, "RMS slope along one axis.");
  facts("correlation_length_m", n.correlation_length, "Correlation length.");
  facts("n_eff", n.n_eff, "Number of modes that carry the slope.");
  facts("g", n.g, "4 pi sigma/lambda.");
  facts("kappa", n.kappa,
        "Measure of how nearly quadratic the structure function is; rays can be valid from 0.85 up.");
  facts("tis", n.tis, "Fraction of the energy that the roughness scatters.");
  facts("paper_ratio_r", n.paper_ratio_r,
        "The paper's R = 2 sigma D/(1.22 lambda l_c), for information only.");
  facts("airy_ee90_m", n.airy_ee90, "Radius that holds 90 % of the energy of the perfect mirror.");
  facts("kappa_rule_allows_rays", n.kappa_rule_allows_rays,
        "Whether kappa and the spot size allow rays, for information only.");
  facts("theory", scene.theory, "Origin of the targets: ghs, geometric, rays, given or map.");
  facts("model", scene.model, "How statistics were computed from the surface: waves or rays.");
  facts("needed", scene.needed, "The model that the scene needs.");
  facts("reason", scene.reason.empty() ? n.reason : scene.reason, "Reason why it needs that model.");
  facts.where(scene.errors.has_value(), "ghs",
              GhsFacts{scene.errors ? scene.errors->ghs : ModelRadii(), n.tis},
              "Prediction of generalised Harvey-Shack.");
  facts.if_any("model_error", scene.errors, "Error of geometric rays against generalised Harvey-Shack.");
  facts.where(!scene.mean_light.values.empty(), "mean_light", scene.mean_light,
              "Mean PSF of the specification, in the quantities that budgets limit.");
  facts.where(scene.spread.worst() != nullptr, "spread", scene.spread,
              "Standard deviation among single mirrors of the specification.");
}

void describe(Facts& facts, const SplitPart& part) {
  facts("rms_height_m", part.height, "RMS height of this part.");
  facts("rms_slope_per_axis", part.slope, "Its RMS slope along one axis.");
}

static void describe(Facts& facts, const AbgFit& fit) {
  const auto of_model = [&](double value) { return fit.describes() ? value : kNaN; };
  facts("describes", fit.describes(), "Whether the model is within a factor of two over the whole range.");
  facts("a_per_sr", of_model(fit.model.a), "A of the ABg model.");
  facts("b", of_model(fit.model.b), "Its B.");
  facts("g", of_model(fit.model.g), "Its exponent g.");
  facts("theta_min_rad", fit.theta_min, "Smallest angle of the fitted range.");
  facts("theta_max_rad", fit.theta_max, "Largest angle of the fitted range.");
  facts("largest_error", fit.largest_error, "Largest relative error in the range.");
  facts("rms_error", fit.rms_error, "RMS relative error in the range.");
  facts("abg_tis", of_model(fit.tis), "Fraction of the energy that the model scatters into the hemisphere.");
}

namespace {

struct MapResidual {
  double rms_height = kNaN, specified = kNaN;
};

void describe(Facts& facts, const MapResidual& residual) {
  facts("rms_height_m", residual.rms_height, "RMS height of the map minus the terms.");
  facts("specified_rms_height_m", residual.specified,
        "RMS height that these terms would leave of the specification.");
  facts("meaning", kResidualNote, "How to interpret it.");
}

}  // namespace

void describe(Facts& facts, const SplitFacts& split) {
  const BandShares& shares = split.shares;
  const bool fitted = split.surface.has_value(), scatters = shares.rest_rms > 0, cut = shares.cut > 0;
  const EquivalentSurface surface = split.surface.value_or(EquivalentSurface());
  facts("cut_per_m", shares.cut,
        "Frequency where terms end and scatter begins; 0: all of the roughness scatters.");
  facts("automatic", shares.automatic, "Whether the program chose the cut.");
  facts("specified_terms", SplitPart{shares.low_rms, shares.low_slope}, "The roughness below the cut.");
  facts.object("scatter", "The roughness above the cut, which no term carries.", [&](Facts& inside) {
    describe(inside, SplitPart{shares.rest_rms, shares.rest_slope});
    inside("scatter_rms_rad", shares.rest_scatter, "RMS angle of scatter.");
    inside("rest_tis", shares.tis, "Fraction of the energy that it scatters.");
    inside.if_any("abg", split.abg, "ABg models of the scatter function.");
  });
  facts("spread_in_tolerances", shares.spread,
        "Largest standard deviation of judged statistics among such mirrors, in tolerances.");
  facts("spread_of", shares.spread_of, "Statistic with that standard deviation.");
  facts("rms_height_spread", shares.height_spread, "Relative standard deviation of the RMS height.");
  facts("rms_slope_spread", shares.slope_spread, "Relative standard deviation of the RMS slope.");
  facts("reason", shares.reason, "Reason for the cut.");
  facts.where(fitted, "terms", SplitPart{surface.rms_height, surface.rms_slope_per_axis},
              "The fitted surface.");
  facts.where(fitted, "sum",
              SplitPart{std::hypot(surface.rms_height, shares.rest_rms),
                        std::hypot(surface.rms_slope_per_axis, shares.rest_slope)},
              "Terms and scatter together.");
  facts.where(fitted && std::isfinite(shares.map_residual), "map_residual",
              MapResidual{shares.map_residual, shares.specified_residual}, "Residual of a measured part.");
  facts.where(fitted && scatters, "use", cut ? kUse : kUseWithoutTerms, "How to use terms and scatter.");
  facts.where(fitted && scatters && cut, "beware", kBeware, "What to avoid.");
}

}  // namespace aberfit::internal
