#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "aberfit/equivalence/tost.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/scatter/regime.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Slope RMS of one aperture zone over the overall slope RMS, beside the same ratio over draws of the prior.
struct ZoneSlope {
  double rho_min = 0, rho_max = 0;      ///< edges as fractions of the aperture radius
  double ratio = 0;                     ///< of the fitted surface
  double draws_low = 0, draws_high = 0; ///< 0.5 % and 99.5 % quantiles over draws
};

/// The fitted surface by the numbers of a scene (its own, not the specification's).
struct EquivalentSurface {
  double rms_height = 0;          ///< [m]
  double rms_slope_per_axis = 0;
  double g = 0, kappa = 0;
  double prior_height_factor = 1; ///< 0.5 when the prior was scaled for convention `paper`
  std::vector<ZoneSlope> zones;
  double captured_fraction = 0;   ///< share of the specification's height variance that the term set can carry; 0 without PSD
};

struct Provenance {
  std::string version;
  std::uint64_t seed = 0;
  int threads = 1;
  std::map<std::string, std::string> libraries;
};

/// Everything result.json holds for `kind: fit` (and, with an empty fit, `trace`). Statistic vectors run parallel to `targets`.
struct ResultDocument {
  std::string kind = "fit";
  nlohmann::ordered_json study;   ///< the resolved study
  bool has_roughness = false;
  SceneNumbers scene;             ///< of the specification
  std::string theory;             ///< "geometric" or "rays": the model that made the targets
  std::vector<Target> targets;
  FitResult fit;
  TermSet terms;
  Eigen::Index rays = 0;
  double radius = 0;              ///< normalisation radius [m]
  EquivalentSurface surface;
  Eigen::VectorXd start, fitted, validated;
  Verdict verdict = Verdict::kUndecided;
  std::vector<EquivalenceMetric> metrics;
  Warnings warnings;
  Provenance provenance;
};

/// result.json, format version 1 (plain SI numbers, unit in the key; NaN and infinity become null).
nlohmann::ordered_json to_json(const ResultDocument& result);

/// Zernike (n, m, Noll index, value_m, std_m), Fourier and spherical coefficients as CSV with a commented header that says units and conventions.
std::string coefficients_csv(const TermSet& terms, const Eigen::VectorXd& coefficients, const Eigen::VectorXd& std);

/// Coefficients from a file that coefficients_csv wrote, fitted into `terms` (missing terms 0). Throws InputError; terms the set lacks are an error.
Eigen::VectorXd read_coefficients_csv(const std::string& path, TermSet* terms);

/// The table people read on the terminal: scene, fit, target | fitted | fresh rays | difference | verdict, warnings.
/// `width`: columns of the terminal; `all`: every statistic instead of the z = f ones and the worst.
std::string summary_table(const ResultDocument& result, bool all);

/// Writes `text` to `path` whole or not at all: aside, then renamed. Creates the folder. Throws InputError when it cannot.
void write_file(const std::string& path, const std::string& text);

}  // namespace aberfit
