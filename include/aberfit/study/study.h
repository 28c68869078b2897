#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/fit/calibrate.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/report/exports.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/theory/convention.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/modal_covariance.h"

// A study file in memory, format version 1. Member names follow the JSON keys; SI units and radians
// throughout.
namespace aberfit {

/// `psd.model: "table"`: what the file says and how to read it. The table itself is loaded by read_study.
struct PsdTableFile {
  std::string file;         ///< as written in the study, relative to it
  std::string kind = "2d";  ///< "2d": two-sided [m^4]; "1d": one-sided profile PSD [m^3]
  std::string frequency_unit = "/m";
  std::string psd_unit = "m^4";
  std::string of = "surface";          ///< "wavefront": heights are half
  double scale = 1;                    ///< height factor, to put a measured shape on another mirror
  std::optional<double> f_min, f_max;  ///< band cut [cycles/m]
  PsdTableResult
      table;  ///< loaded: two-sided 2-D surface PSD with `of`, `scale` and the cut applied; what was left out
};

/// A measured profile or map: the file and what it may not say itself.
struct MeasuredFile {
  std::string file;  ///< as written in the study, relative to it
  std::string format = "auto";
  int column = 1;                  ///< profiles: which scan line, from 1
  std::string quantity;            ///< profile text: "height" or "slope"; empty: as the file says
  std::string of;                  ///< "surface" or "wavefront"; empty: as the file says
  std::string x_unit, value_unit;  ///< empty: as the file says
  std::optional<double> pitch;     ///< maps: pixel scale [m]
  std::optional<double>
      wavelength;    ///< of the instrument [m], for values in waves or radians; absent: as the file says
  double scale = 1;  ///< factor on the heights, to put a measured shape on another mirror
};

/// `psd.model: "measured"`: measurement -> PSD -> model. The measuring is done by read_study.
struct MeasuredPsd {
  MeasuredFile source;
  std::vector<MeasuredFile> further;  ///< other instruments' bands of the same surface
  PsdEstimatorOptions estimator;
  PsdFitOptions fit;
  // What came of it:
  std::vector<Measurement> data;  ///< as read, heights scaled
  PsdEstimate estimate;
  PsdModelFit result;
};

/// A node of the `psd` block: a closed model, a table file, a measurement, or a sum of nodes.
struct RoughnessModel;
struct RoughnessSum {
  std::vector<RoughnessModel> parts;
};
struct RoughnessModel {
  std::variant<UniformPsd, KCorrelationPsd, PowerLawPsd, GaussianPsd, PsdTableFile, MeasuredPsd, RoughnessSum>
      model;
};

/// One entry of target.statistics. Names: ee<percent>, ring_fwhm, ring_profile, scatter_rms, scatter_mean,
/// spot_fwhm, rms_radius, rms_height.
struct StatisticRequest {
  std::string name;
  std::vector<double> planes = {0};  ///< ee*, rms_radius: dz [m]
  std::variant<std::string, double> ring =
      std::string("ee90");          ///< ring_fwhm, ring_profile: "ee<percent>" or a radius [m]
  std::optional<double> bandwidth;  ///< spot_fwhm [m]
  std::optional<double> value;      ///< the target itself, in the statistic's unit; absent: from theory
  double standard_error = 0;        ///< of a given value, in its unit
  double tolerance = 1e-3;  ///< relative to the target value (ring_profile: absolute share of the light)
  std::string file;         ///< ring_profile: CSV with columns dz [m], share
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

/// A measured map as target: least-squares terms.
struct MapTarget {
  MeasuredFile source;
  std::string origin = "circle";  ///< the axis is at the middle of the enclosing circle, of the "grid", or
                                  ///< where the "file" has it
  MapFitOptions fit;
};

struct TargetSpec {
  std::optional<Theory>
      theory;  ///< of targets without a value; absent ("auto"): what the scene needs (choose_model)
  Convention convention = Convention::kPhysical;
  std::vector<StatisticRequest> statistics;  ///< empty: the default set (DESIGN)
  std::optional<PsdTarget> psd;
  std::optional<MapTarget> map;  ///< instead of statistics
};

struct ZernikeSpec {
  int n_min = 2;
  std::optional<int> n_max;  ///< absent: the order that captures 99 % of the height variance
};
struct FourierSpec {
  int count = 400;
  FourierSampling sampling = FourierSampling::kLog;
};
struct TermsSpec {
  /// "auto", or no terms in the file: a fit takes the fewest Zernikes that do; `zernike` then holds the
  /// default (99 %) for all that needs terms without a fit.
  bool automatic = false;
  std::optional<ZernikeSpec> zernike;
  std::optional<FourierSpec> fourier;
  std::vector<int> spherical;  ///< even powers 4..12
  CovarianceKind covariance = CovarianceKind::kFull;
};

struct TraceSpec {
  std::optional<FocusModel> model;  ///< of the surface; absent ("auto"): what the theory needs
  PupilOptions pupil;               ///< JSON keys pupil, rays, seed sit side by side
  bool automatic_rays = false;      ///< "auto", or no rays in the file: a fit finds how many it needs;
                                    ///< `pupil.rays` then holds what everything else uses
  std::optional<double> central_difference_step;  ///< [m]; absent: analytic normals
  Centre centre = Centre::kNominal;
};

enum class FitStart { kDraw, kZero };
struct FitSpec {
  FitStart start = FitStart::kDraw;
  std::uint64_t seed = 1;
  PriorMode prior = PriorMode::kNearStart;
  int max_iterations = 100;
  int starts = 1;               ///< tries from different draws; the best is kept
  double spherical_rms = 1e-6;  ///< prior RMS height of the spherical terms [m]
  double bound_sigmas = 0;      ///< > 0: coefficients within so many prior standard deviations
};

struct EquivalenceSpec {
  double margin = 0.01;
  double confidence = 0.95;
};

struct OutputSpec {
  bool plots = true;
  std::vector<ExportFormat> exports;
  int export_grid = 257;  ///< points per side of exported maps
};

/// The paper's published phase synthesis: Phi = sum sqrt(P0 dA_k) cos(2 pi f_k.x + phi_k) [rad] over modes
/// log-uniform in f, with dA_k taken with log10 and no factor 4 pi/lambda (PHYSICS 9). Kept to show what
/// those formulas give.
struct PhaseSynthesis {
  double psd_level = 1e-20;  ///< P0 as printed
  int modes = 10000;
  double f_min = 2.5;  ///< [cycles/m]
  double f_max = 1e6;  ///< [cycles/m]
};

/// Zernikes n = 2..n_max drawn independently with equal variance and a total RMS height: a candidate reading
/// of the paper's aberration branch.
struct IndependentTerms {
  int n_max = 8;
  double rms = 100e-9;  ///< [m]
  int draws = 200;
};

/// What a formula of study/published.h works on; absent values come from the study.
struct FormulaInputs {
  std::optional<double> gradient_x, gradient_y;  ///< RMS phase gradient per axis [rad/m]
  std::optional<double> wavelength, focal_length, diameter, rms, correlation_length;  ///< [m]
  std::optional<double> f_min, f_max;                                                 ///< [cycles/m]
};

/// A number printed elsewhere, to be set beside ours.
struct PublishedNumber {
  std::string label;
  std::string quantity;  ///< key of the quantities of a verify result, or
  std::string
      formula;  ///< a formula of study/published.h on `inputs`; both empty: nothing to compare, reading only
  FormulaInputs inputs;
  double value = 0;     ///< as printed
  std::string unit;     ///< as printed
  double scale = 1;     ///< printed value times scale = SI value
  std::string reading;  ///< what holds and what does not, in a sentence
};
struct VerifySpec {
  std::optional<PhaseSynthesis> published_phase;
  std::optional<IndependentTerms> independent_terms;
  std::vector<PublishedNumber> published;
};

struct Study {
  std::string path;  ///< file it was read from
  std::string title;
  Mirror mirror;
  Aperture aperture;
  double wavelength = 0;  ///< [m]
  std::optional<RoughnessModel> roughness;
  TargetSpec target;
  TermsSpec terms;
  TraceSpec trace;
  FitSpec fit;
  EquivalenceSpec equivalence;
  OutputSpec output;
  VerifySpec verify;
};

/// The PSD model of a roughness node, tables included.
PsdModel psd_model(const RoughnessModel& roughness);

}  // namespace aberfit
