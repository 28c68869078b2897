#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/measured/clear_aperture.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

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

/// What result.json says of `kind: fit` (and, with an empty fit, `trace`).
struct ResultDocument : FitOutcome {
  std::string kind = "fit";
  std::string title;  ///< of the study
  Provenance provenance;
  ClearRegion clear;  ///< of a fitted map, in the coordinates of the mirror
};

/// result.json, format version 1, with the resolved `study` (plain SI numbers, unit in the key; NaN and
/// infinity become null). `scene` is null without roughness; statistics vectors that were never computed are
/// left out. `scene.theory` made the targets, `scene.model` turned the surface into statistics,
/// `scene.needed` is the model that the scene needs and `scene.reason` says why; `scene.ghs` is the
/// prediction of generalised Harvey-Shack and `scene.model_error` what rays make of it, model / GHS
/// - 1. `equivalence.light` is light's answer: `decides` says whether `equivalence.verdict` is its verdict
/// (it is unless the study names another theory); `metrics` are there where those of the fit are not light's.
/// `equivalence.perfect_mirror` is how far the mirror without roughness would be from the targets. Spherical
/// terms: `value_m` is the height of the term at the rim, `coefficient` the same as c_2n of sum c_2n rho^2n
/// [m^(1-2n)]. Two targets of one name (rings of different radius, say) get "#2", "#3", ... appended to the
/// later ones.
nlohmann::ordered_json to_json(const ResultDocument& result, const nlohmann::ordered_json& study);
/// `scene` of a result: numbers, models, GHS prediction, model errors, spread of mirrors.
nlohmann::ordered_json scene_json(const FitOutcome& result);

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
