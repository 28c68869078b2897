#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/equivalence/tost.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/report/frontier.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/theory/regime.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Slope RMS of one aperture zone over the overall slope RMS, beside the same ratio over draws of the prior.
struct ZoneSlope {
  double rho_min = 0, rho_max = 0;       ///< edges as fractions of the aperture radius
  double ratio = 0;                      ///< of the fitted surface
  double draws_low = 0, draws_high = 0;  ///< 0.5 % and 99.5 % quantiles over draws

  bool inside() const { return ratio >= draws_low && ratio <= draws_high; }
  /// Outside, but nearer to 1, the ratio of the roughness itself, than draws are: few Zernikes leave most
  /// slopes at the edge, and a fit may do better.
  bool more_even() const;
};

/// The fitted surface by the numbers of a scene (its own, not the specification's).
struct EquivalentSurface {
  double rms_height = 0;  ///< [m]
  double rms_slope_per_axis = 0;
  double g = 0, kappa = 0;
  std::string needed;              ///< "rays" or "waves": by its own height; empty without PSD
  double prior_height_factor = 1;  ///< 0.5 when the prior was scaled for convention `paper`
  std::vector<ZoneSlope> zones;
  double captured_fraction =
      0;  ///< share of the specification's height variance that the term set can carry; 0 without PSD
};

/// What made a result, so that it can be made again.
struct Provenance {
  std::string version;  ///< of aberfit
  std::uint64_t seed = 0;
  int threads = 1;
  std::map<std::string, std::string> libraries;  ///< name -> version, the compiler among them
};

/// Version of this library, its compiler and the libraries the report room can see (Eigen, Boost,
/// nlohmann-json, fmt). A room with a library of its own (Ceres in fit) adds that entry itself.
Provenance make_provenance(std::uint64_t seed, int threads);
nlohmann::ordered_json to_json(const Provenance& provenance);

/// A PSD bin that was fitted along.
struct SpectrumBin {
  double low = 0, high = 0;       ///< [cycles/m]
  double target = 0, fitted = 0;  ///< [m^4]
  double tolerance = 0;           ///< of log PSD
};

/// Spread of ee90 between realisations of one specification, standard deviation over mean.
struct Realisation {
  double predicted = 0;  ///< 0.65 / sqrt(n_eff), a law of rays
  double measured = 0;   ///< over seeded draws of the terms, through the model of the fit; NaN: not measured
  int draws = 0;         ///< that were measured; 0: none
  /// What to reckon with: the law holds for rays and many modes, so what was measured goes first.
  double spread() const { return draws > 0 ? measured : predicted; }
};

/// The fitted surface through the model that its scene needs, against the theory that the scene needs.
struct NeededJudgement {
  std::string theory;  ///< "ghs"; "given" where the targets are values
  std::string model;   ///< "waves"
  std::string reason;  ///< one sentence: why the fit's own model does not decide
  Verdict verdict = Verdict::kUndecided;
  std::vector<EquivalenceMetric> metrics;  ///< empty where it cannot be computed
};

/// Everything result.json holds for `kind: fit` (and, with an empty fit, `trace`). Statistic vectors run
/// parallel to `targets`.
struct ResultDocument {
  std::string kind = "fit";
  nlohmann::ordered_json study;  ///< the resolved study
  bool has_roughness = false;
  SceneNumbers scene;                 ///< of the specification
  std::string theory;                 ///< "geometric", "rays", "ghs": what made the targets; "given", "map"
  std::string model = "rays";         ///< "rays", "waves": what turned the surface into statistics
  std::string needed;                 ///< the same words: what the scene needs; empty without roughness
  std::string model_reason;           ///< why it is needed, one sentence
  std::optional<ModelErrors> errors;  ///< of rays against GHS; absent without roughness
  std::optional<Realisation> realisation;
  std::vector<Target> targets;
  FitResult fit;
  TermSet terms;
  Eigen::Index rays = 0;
  double radius = 0;  ///< normalisation radius [m]
  EquivalentSurface surface;
  Eigen::VectorXd start, fitted, validated;
  std::vector<SpectrumBin> spectrum;  ///< empty where no PSD bins were asked for
  std::optional<Frontier> frontier;  ///< what the search for the fewest terms tried; absent: terms were given
  std::optional<RayChoice> ray_choice;
  std::optional<BandUse> band;      ///< absent without roughness
  std::optional<MapFitResult> map;  ///< least-squares fit of a measured map; statistics then have no target
  Verdict verdict = Verdict::kUndecided;            ///< that of `needed_judgement` where there is one
  std::vector<EquivalenceMetric> metrics;           ///< on the model of the fit
  std::optional<NeededJudgement> needed_judgement;  ///< where that model is too simple for the scene
  Warnings warnings;
  Provenance provenance;
};

/// result.json, format version 1 (plain SI numbers, unit in the key; NaN and infinity become null).
/// `scene` is null without roughness; statistics vectors that were never computed are left out.
/// `scene.theory` made the targets, `scene.model` turned the surface into statistics, `scene.needed` is the
/// model that the scene needs and `scene.reason` says why; `scene.ghs` is the prediction of generalised
/// Harvey-Shack and `scene.model_error` what simpler models make of it, model / GHS - 1.
/// `equivalence.verdict` is that of `equivalence.needed` where the fit's model is simpler than the scene
/// needs. Spherical terms: `value_m` is the height of the term at the rim, `coefficient` the same as c_2n of
/// sum c_2n rho^2n [m^(1-2n)]. Two targets of one name (rings of different radius, say) get "#2", "#3", ...
/// appended to the later ones.
nlohmann::ordered_json to_json(const ResultDocument& result);
/// `scene` of a result: numbers, models, GHS prediction, model errors, realisation scatter.
nlohmann::ordered_json scene_json(const ResultDocument& result);

/// Zernike, Fourier and spherical coefficients, one per row, in the order of `terms`, after a commented
/// header that says units, signs and conventions. Columns: kind (zernike, cos, sin, spherical), n (radial
/// order; power of rho), m, noll, fx_per_m, fy_per_m, value_m, std_m. Numbers carry the fewest digits that
/// read back to the same bits. `std`: standard deviations [m], or empty: no values in that column.
std::string coefficients_csv(const TermSet& terms, const Eigen::VectorXd& coefficients,
                             const Eigen::VectorXd& std);

/// Coefficients [m] from a file that coefficients_csv wrote, put into the order of `terms`; terms the file
/// lacks are 0. An empty set (no terms) becomes the set of the file, radius included. Fourier frequencies
/// match within 1e-9 of their length. Throws InputError with file and line: unreadable file, no or another
/// normalisation radius, unknown kind, term the set lacks, the same term twice, something that is not a
/// finite number.
Eigen::VectorXd read_coefficients_csv(const std::string& path, TermSet* terms);

/// The table people read on the terminal, at most 100 columns: verdict, scene, fit, target | fitted | fresh
/// rays | difference | verdict, slope zones, warnings. Lengths and angles in the unit that suits them. ASCII
/// but for the study's own words. all: every statistic instead of those at z = f and the worst of the rest.
std::string summary_table(const ResultDocument& result, bool all);

/// Writes `text` to `path` whole or not at all: into a file beside it that is then renamed over it. Creates
/// the folder. Throws InputError when it cannot; nothing is left behind then.
void write_file(const std::string& path, const std::string& text);

}  // namespace aberfit
