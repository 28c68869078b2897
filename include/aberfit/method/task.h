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

// The input of the method: the physics of a study without its file. Member names follow the keys of the study
// format; SI units and radians throughout.
namespace aberfit {

/// One entry of target.statistics. Names: ee<percent>, ring_fwhm, ee_within, ring_profile, scatter_rms,
/// scatter_mean, spot_fwhm, rms_radius, rms_height, strehl, mtf, ensquared_within.
struct StatisticRequest {
  std::string name;
  std::vector<double> planes = {0};  ///< ee*, *_within, rms_radius: dz [m]
  std::vector<double> places;        ///< StudyOption::kPlaces: radii, sides, frequencies [SI]
  std::variant<std::string, double> ring =
      std::string("ee90");          ///< ring_fwhm, ring_profile: "ee<percent>" or a radius [m]
  std::optional<double> bandwidth;  ///< spot_fwhm [m]
  std::optional<double> value;      ///< given target, in the statistic's unit; absent: from theory
  double standard_error = 0;        ///< standard error of a given value, in its unit
  AskedAs asked;                    ///< ee*: its key and unit in the study, for messages
  double tolerance = 1e-3;          ///< relative to the target value (fractions, ring_profile: absolute)
  std::string file;                 ///< ring_profile: CSV with columns dz [m], share
  std::vector<double> profile_dz, profile_value;  ///< ring_profile: given inline or loaded from `file`
};

/// PSD bins of the term surface as targets, beside the focal statistics.
struct PsdTarget {
  std::optional<double> f_min,
      f_max;  ///< band [cycles/m]; absent: the part of the roughness that the terms carry
  int bins_per_decade = 12;
  double tolerance = 0.05;             ///< of log PSD
  std::string method = "closed-form";  ///< "closed-form": Zernikes over the disc; "estimator": any terms,
                                       ///< with the estimator of a measurement
};

struct TargetSpec {
  std::optional<Theory>
      theory;  ///< theory of targets without a value; absent ("auto"): the scene decides (choose_model)
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
  kGrid,  ///< all frequencies in the band on the grid of pitch 1/(2R), R the aperture's radius
};
struct FourierSpec {
  std::optional<int> count;  ///< kLog; absent: law::kUsualWaves
  FourierSampling sampling = FourierSampling::kLog;
};
/// The rule for the frequency where terms end and scatter begins (PHYSICS 10).
enum class BandRule {
  kDefault,  ///< kAuto where terms are automatic and the theory is not geometric, else kAll
  kAuto,     ///< the frequency above which single mirrors do not differ from their mean
  kAll,      ///< terms carry every frequency of the roughness
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
  bool fewest = false;  ///< automatic terms: the fewest that are equivalent, not those that carry the band

  /// True when no terms are named ("auto" or "fewest" in a file); a fit then takes those that carry the band.
  bool automatic() const { return !zernike && !fourier && spherical.empty(); }
  /// The Zernikes, for code that needs some: the default where no terms are named.
  std::optional<ZernikeSpec> zernikes() const { return automatic() ? ZernikeSpec{} : zernike; }
};

struct TraceSpec {
  std::optional<FocusModel> model;  ///< model of the surface; absent ("auto"): the theory decides
  PupilOptions pupil;               ///< the JSON keys pupil, rays and seed lie side by side
  std::optional<double> central_difference_step;  ///< [m]; absent: analytic normals
  Centre centre = Centre::kNominal;
};

enum class FitStart { kDraw, kZero };
struct FitSpec {
  FitStart start = FitStart::kDraw;
  std::uint64_t seed = 1;
  PriorMode prior = PriorMode::kNearStart;
  int max_iterations = 100;
  int starts = 1;  ///< random starts in turn, until one is equivalent; else the nearest fit is kept
  /// Prior RMS height of the spherical terms [m]. Absent: 1 um, or by waves that of the roughness, because a
  /// start of many wavelengths has no usable diffraction pattern.
  std::optional<double> spherical_rms;
  double bound_sigmas = 0;  ///< > 0: limits coefficients to this many prior standard deviations
};

struct EquivalenceSpec {
  double margin = 0.01;
  double confidence = 0.95;
  /// Relative difference of the energy outside, 1 - E, that counts as equivalent, for encircled energies
  /// judged as energy fractions; absent: only the margin applies.
  std::optional<double> stray_light;
};

/// A mirror, its wavelength and roughness, and the statistics to meet. The first four members have no
/// default. The defaults of the others stand here and in their structs, for programs and study files alike. A
/// task is never changed; the decisions of a run go into a plan (plan.h).
struct Task {
  Mirror mirror;
  Aperture aperture;
  Light wavelength = {};        ///< [m]; the mean of a band where a single number is needed
  std::optional<PsdModel> psd;  ///< PSD of the roughness; absent where the study has none
  Warnings data_warnings;       ///< warnings from reading and measuring the roughness
  TargetSpec target;
  TermsSpec terms;
  TraceSpec trace;
  FitSpec fit;
  EquivalenceSpec equivalence;
};

}  // namespace aberfit
