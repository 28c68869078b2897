// This file describes the result of a fit: result.json of kind "fit".
#include <cassert>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/method/constants.h"
#include "aberfit/scene/zernike.h"
#include "facts.h"
#include "map_report.h"
#include "statistic_label.h"

namespace aberfit::internal {

static void describe(Facts& facts, const EquivalentSurface& surface) {
  facts("rms_height_m", surface.rms_height, "RMS height of the fitted surface.");
  facts("rms_slope_per_axis", surface.rms_slope_per_axis, "Its RMS slope along one axis.");
  facts("g", surface.g, "4 pi sigma/lambda of the fitted surface.");
  facts("kappa", surface.kappa, "kappa of the fitted surface.");
  facts("needed", surface.needed, "Model that the height of the fitted surface needs.");
  facts("prior_height_factor", surface.prior_height_factor, "0.5 where convention `paper` halved the prior.");
  facts("captured_fraction", surface.captured_fraction,
        "Fraction of the specification's height variance that the terms can carry.");
}

static void describe(Facts& facts, const OperatorChoice& choice) {
  facts("zernike", choice.zernike, "Method for Zernike terms; null without them.");
  facts("fourier", choice.fourier, "Method for plane waves; null without them.");
  facts("reason", choice.reason, "Reason for these methods.");
}

static void describe(Facts& facts, const RayChoice& rays) {
  facts("automatic", rays.automatic, "Whether the program chose the number of points.");
  facts("gap", rays.gap, "Largest relative difference of fitted and fresh statistics.");
  facts("sampling_error", rays.sampling_error, "Largest relative standard error on fresh points.");
  facts("allowed", rays.allowed, "Limit of both the gap and the sampling error.");
  facts("reason", rays.reason, "Reason for the number of points.");
}

static void describe(Facts& facts, const FrontierPoint& point) {
  facts("family", point.family, "zernike or fourier.");
  facts("order", point.order, "Largest n, or number of plane waves.");
  facts("terms", point.terms, "Number of terms.");
  facts("pupil_points", point.rays, "Number of rays (by wave optics: of grid points).");
  facts("fitted_mismatch_tolerances", point.fitted_mismatch,
        "Largest difference of a fitted statistic, in tolerances.");
  facts("held_out_mismatch", point.held_out_mismatch, "Largest relative difference of a held-out statistic.");
  facts("seconds", point.seconds, "Time of this fit.");
  facts("verdict", point.verdict, "Verdict of this fit; null where it was not judged.");
  facts("passes", point.passes, "Whether it is equivalent.");
  facts("chosen", point.chosen, "Whether this set was taken.");
}

static void describe(Facts& facts, const Frontier& frontier) {
  facts("message", frontier.message, "Which set was taken, and why.");
  facts("fewest", frontier.fewest, "Whether the study requests the fewest terms.");
  facts("seconds", frontier.seconds, "Time of all these fits.");
  facts("margin", frontier.margin, "Margin of the verdicts.");
  facts("points", frontier.points, "The sets that were tried, by number of terms.");
}

static void describe(Facts& facts, const BandUse& band) {
  facts("modelled_f_min", band.modelled_f_min, "Lowest frequency that is modelled [1/m].");
  facts("modelled_f_max", band.modelled_f_max, "Highest frequency that is modelled [1/m].");
  facts("limited_by", band.limited_by, "What limits the highest frequency.");
  facts("left_out_height_share", band.left_out_height_share, "Fraction of the height variance left out.");
  facts("left_out_slope_share", band.left_out_slope_share, "Fraction of the slope variance left out.");
  facts("ee90_change", band.ee90_change, "Relative change of ee90 that this causes.");
}

static void describe(Facts& facts, const BesideDraws& one) {
  facts("value", one.value, "Value of the fitted surface.");
  facts("draws_mean", one.mean, "Mean of realisations of the roughness.");
  facts("draws_low", one.low, "Lower end of the interval that holds one more realisation.");
  facts("draws_high", one.high, "Upper end of that interval.");
  facts("inside", one.inside(), "Whether the fitted surface is in that interval.");
}

static void describe(Facts& facts, const CharacterBin& bin) {
  facts("f_low_per_m", bin.low, "Lower edge of the bin.");
  facts("f_high_per_m", bin.high, "Upper edge of the bin.");
  facts("specification_m4", bin.specification, "Mean of the specified PSD in the bin.");
  describe(facts, bin.ratio);
}

static void describe(Facts& facts, const ZoneSlope& zone) {
  facts("rho_min", zone.rho_min, "Inner edge over the aperture's radius.");
  facts("rho_max", zone.rho_max, "Outer edge over the aperture's radius.");
  describe(facts, zone.ratio);
}

static void describe(Facts& facts, const OtherLight& other) {
  const bool known = other.obstacle.empty();
  facts("wavelength_m", other.wavelength, "Another wavelength.");
  facts("stop", other.stop, "Diameter of the stop over that of the mirror.");
  facts.where(!known, "obstacle", other.obstacle, "Reason why there is no number.");
  facts.where(known, "worst_tolerances", other.worst,
              "Largest difference of ee35, 50, 65, 80 and 90 from generalised Harvey-Shack.");
  facts.where(known, "worst_share", other.fraction, "Energy fraction of that radius.");
  facts.where(known, "draws_rms_tolerances", other.draws,
              "Root mean square of the same difference over realisations.");
}

static void describe(Facts& facts, const Character& character) {
  facts("of_this_roughness", character.fault().empty(),
        "Whether the surface looks like a realisation of this roughness.");
  facts("fault", character.fault(), "Property that is farthest outside its interval; empty where none is.");
  facts("draws", character.draws, "Number of realisations.");
  facts("confidence", law::kCharacterConfidence,
        "Confidence that all bins (or all zones) are inside at once.");
  facts("psd_ratio", character.psd, "PSD of the surface over the mean of realisations, bin by bin.");
  facts("zones", character.zones, "RMS slope of zones over that of the aperture.");
  facts("slope_x_over_y", character.slope_x_over_y, "RMS slope along x over that along y.");
  facts("length_over_width", character.length_over_width, "Elongation of the image inside ee90.");
  facts("bright_share", character.bright_share,
        "Fraction of the energy between ee35 and ee90 that falls on the brightest hundredth of that area.");
  facts.where(!character.light_obstacle.empty(), "light_obstacle", character.light_obstacle,
              "Reason why there is no image.");
  facts("other_light", character.others, "The same surface at other wavelengths and smaller stops.");
}

static void describe(Facts& facts, const SpectrumBin& bin) {
  facts("low_per_m", bin.low, "Lower edge of the bin.");
  facts("high_per_m", bin.high, "Upper edge of the bin.");
  facts("target_m4", bin.target, "Specified PSD.");
  facts("fitted_m4", bin.fitted, "PSD of the fitted surface.");
  facts("tolerance", bin.tolerance, "Tolerance of the logarithm of the PSD.");
}

static void describe(Facts& facts, const PerfectMirror& perfect) {
  facts("mismatch_tolerances", perfect.mismatch,
        "Largest difference of the perfect mirror by wave optics, in tolerances.");
  facts("statistic", perfect.statistic, "Statistic with that difference.");
}

static void describe(Facts& facts, const MapPanel& panel) {
  facts("rms_m", panel.rms, "RMS height about the mean.");
  facts("peak_to_valley_m", panel.peak_to_valley, "Highest less lowest height.");
  facts("rms_slope_x", panel.rms_slope_x, "RMS slope along x by central differences.");
  facts("rms_slope_y", panel.rms_slope_y, "RMS slope along y by central differences.");
}

static void describe(Facts& facts, const MapPanels& panels) {
  facts("measured", panels.measured, "The map without piston and tilt.");
  facts("fitted", panels.fitted, "The terms.");
  facts("residual", panels.residual, "The residual, map minus terms.");
}

static void describe(Facts& facts, const LitSurface& lit) {
  facts("strehl", lit.strehl, "Strehl ratio.");
  facts("ee50_radius_m", lit.ee50, "Radius that holds half of the energy.");
  facts("ee80_radius_m", lit.ee80, "Radius that holds 80 % of the energy.");
  facts("ee90_radius_m", lit.ee90, "Radius that holds 90 % of the energy.");
  facts("spot_fwhm_m", lit.spot_fwhm, "Full width at half maximum of the line spread.");
  facts.where(!lit.obstacle.empty(), "obstacle", lit.obstacle, "Reason why there is no PSF.");
}

static void describe(Facts& facts, const ResidualPsd& rest) {
  facts("f_min_per_m", rest.f_min, "Lower end of the band.");
  facts("f_max_per_m", rest.f_max, "Upper end of the band.");
  facts("rms_height_m", rest.rms_height, "RMS height inside the band.");
  facts("residual_tis", rest.tis, "Fraction of the energy that it scatters.");
  facts.where(!rest.obstacle.empty(), "obstacle", rest.obstacle, "Reason why there is no PSD.");
}

static void describe(Facts& facts, const MapLight& light) {
  facts("cells", light.cells, "Number of grid points of the pupil.");
  facts("filled_share", light.filled_share,
        "Fraction of the aperture without measured heights, which takes those of the terms.");
  const char* const meanings[] = {"The map as measured.", "The terms alone.",
                                  "The terms with the mean scatter of the residual's PSD.",
                                  "The mirror without any error."};
  for (std::size_t k = 0; k < light.columns().size(); ++k)
    facts(kMapColumns[k].key, *light.columns()[k], meanings[k]);
  facts("residual_psd", light.rest, "PSD of the residual.");
}

namespace {

struct FittedMap {
  MapFitResult fit;
  std::optional<MapPanels> panels;
  std::optional<MapLight> light;
  std::optional<ClearRegion> clear;
};

void describe(Facts& facts, const FittedMap& map) {
  const auto& panels = map.panels;
  facts("points", map.fit.points, "Number of points that were fitted.");
  facts("held_out_points", map.fit.held_out_points, "Number of points that were kept back.");
  facts("rms_map_m", map.fit.rms_map, "RMS height of the map about its mean.");
  facts("rms_residual_m", map.fit.rms_residual, "RMS residual over the fitted points.");
  facts("rms_held_out_m", map.fit.rms_held_out, "RMS residual over the points kept back.");
  facts("independent_points", map.fit.independent_points, "Number of independent residuals.");
  facts("condition_number", map.fit.condition_number,
        "Condition number of the design matrix with scaled columns.");
  facts("rank", map.fit.rank, "Number of terms that the points determine.");
  facts.where(panels.has_value(), "pitch_x_m", panels ? panels->measured.map.pitch_x : 0,
              "Distance of the map's columns.");
  facts.where(panels.has_value(), "pitch_y_m", panels ? panels->measured.map.pitch_y : 0,
              "Distance of its rows.");
  facts.if_any("heights", panels, "Measured, fitted and residual heights.");
  facts.if_any("light", map.light, "PSF of the map and of the terms by wave optics.");
  facts("clear", map.clear, "The part of the file that was used; null: the whole file.");
}

struct ZernikeFact {
  ZernikeMode mode;
  double value = kNaN, std = kNaN;
};

void describe(Facts& facts, const ZernikeFact& term) {
  facts("n", term.mode.n, "Radial order.");
  facts("m", term.mode.m, "Azimuthal order; cosine where positive, sine where negative.");
  facts("noll", noll_index(term.mode), "Noll's index.");
  facts("value_m", term.value, "Coefficient of the orthonormal mode.");
  facts("std_m", term.std, "Standard deviation of the coefficient; null where it is not known.");
}

struct FourierFact {
  double fx = 0, fy = 0;
  double cosine = kNaN, sine = kNaN, cosine_std = kNaN, sine_std = kNaN;
};

void describe(Facts& facts, const FourierFact& wave) {
  facts("fx_per_m", wave.fx, "Frequency along x.");
  facts("fy_per_m", wave.fy, "Frequency along y.");
  facts("cos_m", wave.cosine, "Amplitude of the cosine.");
  facts("sin_m", wave.sine, "Amplitude of the sine.");
  facts("cos_std_m", wave.cosine_std, "Standard deviation of the cosine.");
  facts("sin_std_m", wave.sine_std, "Standard deviation of the sine.");
}

struct SphericalFact {
  double value = kNaN, std = kNaN, coefficient = kNaN;
};

void describe(Facts& facts, const SphericalFact& term) {
  facts("value_m", term.value, "Height of the term at the rim.");
  facts("std_m", term.std, "Standard deviation of that height.");
  facts("coefficient", term.coefficient, "c_2n [m^(1-2n)] in the sum of c_2n rho^2n.");
}

struct SegmentFact {
  Segments::Segment segment;
  bool has_piston = true, has_tilt = true;
  std::array<double, 3> value = {kNaN, kNaN, kNaN}, std = {kNaN, kNaN, kNaN};
};

void describe(Facts& facts, const SegmentFact& one) {
  facts("x_m", one.segment.centre[0], "Centre of the segment.");
  facts("y_m", one.segment.centre[1], "Centre of the segment.");
  facts("radius_m", one.segment.radius, "Radius of the smallest circle around the segment.");
  facts.where(one.has_piston, "piston_m", one.value[0], "Piston of the segment.");
  facts.where(one.has_piston, "piston_std_m", one.std[0], "Standard deviation of it.");
  facts.where(one.has_tilt, "slope_x_m", one.value[1], "Height at that radius due to tilt along x.");
  facts.where(one.has_tilt, "slope_x_std_m", one.std[1], "Standard deviation of it.");
  facts.where(one.has_tilt, "slope_y_m", one.value[2], "Height at that radius due to tilt along y.");
  facts.where(one.has_tilt, "slope_y_std_m", one.std[2], "Standard deviation of it.");
}

// Coefficients with their terms.
class TermFacts {
 public:
  TermFacts() = default;
  explicit TermFacts(const FitOutcome& outcome)
      : terms_(outcome.fitted.terms),
        value_(outcome.fitted.fit.coefficients),
        std_(outcome.fitted.fit.coefficient_std) {
    assert(value_.size() == 0 || value_.size() == terms_.size());
  }
  bool any() const { return value_.size() > 0; }
  double radius() const { return terms_.radius; }
  std::vector<ZernikeFact> zernike() const {
    std::vector<ZernikeFact> all;
    for (std::size_t i = 0; i < terms_.zernike.size(); ++i)
      all.push_back({terms_.zernike[i], value_[Eigen::Index(i)], std(Eigen::Index(i))});
    return all;
  }
  std::vector<FourierFact> fourier() const {
    std::vector<FourierFact> all;
    Eigen::Index k = terms_.fourier_begin();
    for (const auto& wave : terms_.fourier) {
      all.push_back({wave.fx, wave.fy, value_[k], value_[k + 1], std(k), std(k + 1)});
      k += 2;
    }
    return all;
  }
  std::map<std::string, SphericalFact> spherical() const {
    std::map<std::string, SphericalFact> all;
    Eigen::Index k = terms_.spherical_begin();
    for (const int power : terms_.spherical) {
      all["c" + std::to_string(power)] = {value_[k], std(k), value_[k] / std::pow(terms_.radius, power)};
      ++k;
    }
    return all;
  }
  bool of_segments() const { return terms_.of_a_segment() > 0; }
  std::vector<SegmentFact> segments() const {
    std::vector<SegmentFact> all;
    if (!of_segments()) return all;
    Eigen::Index k = terms_.segments_begin();
    for (const Segments::Segment& segment : terms_.segments->all()) {
      SegmentFact one{segment, terms_.segments->piston() > 0, terms_.segments->tip_tilt() > 0};
      for (std::size_t j = one.has_piston ? 0 : 1; j < (one.has_tilt ? 3 : 1); ++j, ++k)
        one.value[j] = value_[k], one.std[j] = std(k);
      all.push_back(std::move(one));
    }
    return all;
  }

 private:
  double std(Eigen::Index k) const { return k < std_.size() ? std_[k] : kNaN; }

  TermSet terms_;
  Eigen::VectorXd value_, std_;
};

void describe(Facts& facts, const TermFacts& terms) {
  facts.where(terms.any(), "radius_m", terms.radius(), "Radius that coefficients are normalised to.");
  facts.where(terms.any(), "zernike", terms.zernike(), "Orthonormal Zernike terms.");
  facts.where(terms.any(), "fourier", terms.fourier(), "Plane waves.");
  facts.where(terms.any(), "spherical", terms.spherical(), "Even powers of the radius, by name.");
  facts.where(terms.of_segments(), "segments", terms.segments(), "Errors of each segment of the aperture.");
}

}  // namespace

static void describe_fit(Facts& facts, const FitOutcome& result) {
  const FitResult& fit = result.fitted.fit;
  facts("status", fit.status, "How the solver ended.");
  facts("message", fit.message, "How the solver ended, in a sentence.");
  facts("interrupted", result.interrupted, "Whether this is the best so far of a fit that was stopped.");
  facts("stopped_by", result.interrupted ? std::optional(result.stopped_by) : std::nullopt,
        "What stopped the fit; null where nothing did.");
  facts("iterations", fit.iterations, "Iterations of the solver.");
  facts("evaluations", fit.evaluations, "Evaluations of all statistics.");
  facts("seconds", fit.seconds, "Time of the fit.");
  facts("initial_cost", fit.initial_cost, "Cost function at the start.");
  facts("final_cost", fit.final_cost, "Cost function at the end.");
  facts("rank", fit.rank, "Number of directions in the space of terms that the targets determine.");
  facts("null_directions", fit.null_directions, "Number of directions that the targets do not depend on.");
  facts("terms", result.fitted.terms.size(), "Number of terms.");
  facts("pupil_points", result.fitted.rays, "Number of rays (by wave optics: of grid points).");
  facts("operator", fit.operator_choice, "How heights and slopes follow from the coefficients.");
  facts("equivalent_surface", result.fitted.surface, "Height, slope and regime of the fitted surface.");
  facts("singular_values", fit.singular_values,
        "Singular values of the linearised problem, in units of the prior.");
  facts.if_any("ray_choice", result.choices.rays, "Number of points that the fit used, and the reason.");
  facts.if_any("frontier", result.choices.frontier, "The sets of terms that were tried.");
}

static void describe_statistics(Facts& facts, const FitOutcome& result,
                                const std::vector<std::string>& names) {
  const auto add = [&](const char* key, const Eigen::VectorXd& values, const char* meaning) {
    assert(values.size() == 0 || values.size() == Eigen::Index(names.size()));
    facts.where(values.size() > 0, key, NamedNumbers{names, values}, meaning);
  };
  add("start", result.fitted.start, "Values of the surface that the fit began with.");
  add("fitted", result.fitted.values, "Values of the fitted surface on the points of the fit.");
  add("validated", result.fitted.validated, "Values of the fitted surface on fresh points.");
  add("posterior_std", result.fitted.posterior_std,
      "Standard deviation of the fitted values by the linearised problem.");
}

// Describes the verdict of wave optics; `metrics` only if they differ from those of the fit.
static void describe_light(Facts& facts, const FitOutcome& result) {
  const bool own = result.judgement.light.has_value();
  const LightJudgement light = result.judgement.light.value_or(LightJudgement());
  facts("decides", !own || light.decides, "Whether the verdict of the result is that of wave optics.");
  facts("theory", own ? light.theory : result.scene.theory, "Theory that the targets come from.");
  facts("model", "waves", "How the PSF is computed.");
  std::optional<Verdict> verdict = own ? light.verdict : result.judgement.verdict;
  if (own && light.metrics.empty()) verdict.reset();
  facts("verdict", verdict, "Verdict by wave optics; null where there is none.");
  facts.where(!light.obstacle.empty(), "obstacle", light.obstacle, "Reason why there is none.");
  facts.where(own, "metrics", light.metrics,
              "Statistics by wave optics, where those of the fit are by rays.");
}

void describe_scene(Facts& facts, const FitOutcome& result) {
  describe(facts, result.scene);
  facts.if_any("band", result.band.use, "Part of the band that terms and points can represent.");
}

namespace {

// `scene` of a fit; null without roughness.
struct FitScene {
  const FitOutcome* of = nullptr;
};

void describe(Facts& facts, const FitScene& scene) {
  describe_scene(facts, scene.of ? *scene.of : FitOutcome());
}

}  // namespace

void describe(Facts& facts, const ResultDocument& result) {
  const std::vector<std::string> names = unique_names(result.fitted.targets);
  const bool split = result.band.shares.has_value();
  const bool judged =
      result.fitted.fit.status != FitStatus::kNotRun && !(result.map.fit && !result.has_roughness);
  facts("scene", result.has_roughness ? std::optional(FitScene{&result}) : std::nullopt,
        "The specification, and the models that were used; null without roughness.");
  facts.keyed("target", names, result.fitted.targets, "Target of each statistic, by its name.");
  facts.object("fit", "How the fit went.", [&](Facts& inside) { describe_fit(inside, result); });
  facts("coefficients", TermFacts(result), "The terms; empty where nothing was fitted.");
  facts.object("statistics", "Values of all statistics.",
               [&](Facts& inside) { describe_statistics(inside, result, names); });
  facts.where(split, "split",
              SplitFacts{split ? *result.band.shares : BandShares(),
                         result.band.scatter ? std::optional(result.band.scatter->abg) : std::nullopt,
                         result.fitted.surface},
              "How the roughness is divided between terms and scatter.");
  facts.where(!result.fitted.spectrum.empty(), "spectrum", result.fitted.spectrum,
              "PSD bins that were also fitted.");
  facts.where(result.map.fit.has_value(), "map",
              FittedMap{result.map.fit.value_or(MapFitResult()), result.map.panels, result.map.light,
                        used_part(result.clear)},
              "The fit of a measured map.");
  facts.if_any("character", result.judgement.character,
               "The surface compared with random realisations of its roughness.");
  facts.object("equivalence", "The verdict, and the comparisons that it is based on.", [&](Facts& inside) {
    inside("verdict", result.judgement.verdict, "equivalent, different or undecided.");
    inside("metrics", result.judgement.metrics, "One entry for each statistic.");
    inside.object_where(judged, "light", "The verdict by wave optics.",
                        [&](Facts& light) { describe_light(light, result); });
    inside.where(judged && result.judgement.perfect.has_value(), "perfect_mirror",
                 result.judgement.perfect.value_or(PerfectMirror()),
                 "How far the mirror without roughness is from the targets.");
  });
  facts("warnings", result.warnings, "Warnings that the reader should know.");
}

}  // namespace aberfit::internal
