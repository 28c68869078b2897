#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/light.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/theory/vocabulary.h"

// What the method works on: the physics of a study without its file. Member names follow the keys of the
// study format; SI units and radians throughout.
namespace aberfit {

/// One entry of target.statistics. Names: ee<percent>, ring_fwhm, ee_within, ring_profile, scatter_rms,
/// scatter_mean, spot_fwhm, rms_radius, rms_height, strehl, mtf, ensquared_within.
struct StatisticRequest {
  std::string name;
  std::vector<double> planes = {0};  ///< ee*, *_within, rms_radius: dz [m]
  std::vector<double> radii;         ///< ee_within [m]
  std::vector<double> sides;         ///< ensquared_within [m]
  std::vector<double> frequencies;   ///< mtf: of the image [cycles/m]
  std::variant<std::string, double> ring =
      std::string("ee90");          ///< ring_fwhm, ring_profile: "ee<percent>" or a radius [m]
  std::optional<double> bandwidth;  ///< spot_fwhm [m]
  std::optional<double> value;      ///< the target itself, in the statistic's unit; absent: from theory
  double standard_error = 0;        ///< of a given value, in its unit
  double tolerance = 1e-3;          ///< relative to the target value (shares and ring_profile: absolute)
  std::string file;                 ///< ring_profile: CSV with columns dz [m], share
  std::vector<double> profile_dz, profile_value;  ///< ring_profile: given inline or loaded from `file`
};

/// PSD bins of the term surface as targets, beside the focal statistics.
struct PsdTarget {
  std::optional<double> f_min,
      f_max;  ///< band [cycles/m]; absent: the part of the roughness that the terms carry
  int bins_per_decade = 12;
  double tolerance = 0.05;             ///< of log PSD
  std::string method = "closed-form";  ///< of Zernikes over the disc; "estimator": any terms, through the
                                       ///< estimator of a measurement
};

struct TargetSpec {
  std::optional<Theory>
      theory;  ///< of targets without a value; absent ("auto"): what the scene needs (choose_model)
  Convention convention = Convention::kPhysical;
  std::vector<StatisticRequest> statistics;  ///< empty: the default set
  std::optional<PsdTarget> psd;
};

struct ZernikeSpec {
  int n_min = 2;
  std::optional<int> n_max;  ///< absent: the order that carries the band (order_to_carry), at most 100
};
enum class FourierSampling {
  kLog,   ///< `count` waves on log-uniform rings
  kGrid,  ///< all of the frequency grid of pitch 1/(2R), R the aperture's radius, that the band has part in
};
struct FourierSpec {
  std::optional<int> count;  ///< kLog; absent: law::kUsualWaves
  FourierSampling sampling = FourierSampling::kLog;
};
/// Where the terms end and scatter begins (PHYSICS 10).
enum class BandRule {
  kDefault,  ///< kAuto where terms are automatic and the theory is not geometric, else kAll
  kAuto,     ///< where the rest no longer makes one mirror differ from the mean
  kAll,      ///< every frequency of the roughness is the terms'
  kCut,      ///< at `cut`
};
struct BandSpec {
  BandRule rule = BandRule::kDefault;
  double cut = 0;  ///< kCut [cycles/m]
};
struct TermsSpec {
  std::optional<ZernikeSpec> zernike;
  std::optional<FourierSpec> fourier;
  std::vector<int> spherical;  ///< even powers 4..12
  CovarianceKind covariance = CovarianceKind::kFull;
  BandSpec band;
  bool fewest = false;  ///< of automatic terms: the fewest that are equivalent, not those that carry the band

  /// No terms are named ("auto" or "fewest" in a file): a fit takes those that carry the band.
  bool automatic() const { return !zernike && !fourier && spherical.empty(); }
  /// Those of whoever needs Zernikes: where none are named the default.
  std::optional<ZernikeSpec> zernikes() const { return automatic() ? ZernikeSpec{} : zernike; }
};

struct TraceSpec {
  std::optional<FocusModel> model;                ///< of the surface; absent ("auto"): what the theory needs
  PupilOptions pupil;                             ///< JSON keys pupil, rays, seed sit side by side
  std::optional<double> central_difference_step;  ///< [m]; absent: analytic normals
  Centre centre = Centre::kNominal;
};

enum class FitStart { kDraw, kZero };
struct FitSpec {
  FitStart start = FitStart::kDraw;
  std::uint64_t seed = 1;
  PriorMode prior = PriorMode::kNearStart;
  int max_iterations = 100;
  int starts = 1;  ///< draws to begin with, in turn, until one is equivalent; else the nearest is kept
  /// Prior RMS height of the spherical terms [m]; absent: by waves, whose pattern a start of many waves does
  /// not have, that of the roughness, else 1 um.
  std::optional<double> spherical_rms;
  double bound_sigmas = 0;  ///< > 0: coefficients within so many prior standard deviations
};

struct EquivalenceSpec {
  double margin = 0.01;
  double confidence = 0.95;
  /// Relative difference of the light outside, 1 - E, that counts as equivalent, in encircled energies judged
  /// in light; absent: the margin alone.
  std::optional<double> stray_light;
};

/// A mirror, its light and its roughness, and what is asked of them. The first four have no default; what the
/// others are where nothing is said stands here and in the structs that they are made of, for programs and
/// study files alike. Read, never changed: what a run decides is a plan of its own (plan.h).
struct Task {
  Mirror mirror;
  Aperture aperture;
  Light wavelength = {};        ///< [m]; of a band its mean where a number is wanted
  std::optional<PsdModel> psd;  ///< of the roughness; absent where the study has none
  Warnings data_warnings;       ///< what reading and measuring the roughness ran into
  TargetSpec target;
  TermsSpec terms;
  TraceSpec trace;
  FitSpec fit;
  EquivalenceSpec equivalence;
};

}  // namespace aberfit
