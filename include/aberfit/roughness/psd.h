#pragma once
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace aberfit {

// Isotropic two-dimensional, two-sided power spectral densities of surface height, S(f) [m^4] over f
// [cycles/m] (PHYSICS 3). Band limits belong to the model: S = 0 outside [f_min, f_max], and `rms` [m] is the
// RMS inside the band. f_min = 0 and f_max = infinity are allowed if the moments exist.

// `kModel` is the word of a study for the model. What else a model needs is src/roughness/psd_models.h.

/// S = const.
struct UniformPsd {
  static constexpr const char* kModel = "uniform";
  double rms = 0, f_min = 0, f_max = 0;
};
/// S proportional to (1 + (B f)^2)^(-exponent/2); B [m] (knee at f = 1/B), exponent: 2-D.
struct KCorrelationPsd {
  static constexpr const char* kModel = "k-correlation";
  double rms = 0, correlation = 0, exponent = 0;
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();
};
/// S = amplitude (f / (1 cycle/m))^-exponent, amplitude [m^4]. Exactly one of `rms` and `amplitude` is given.
struct PowerLawPsd {
  static constexpr const char* kModel = "power-law";
  std::optional<double> rms, amplitude;
  double exponent = 0, f_min = 0, f_max = std::numeric_limits<double>::infinity();
};
/// ACF sigma^2 exp(-(r/l)^2), i.e. S = pi l^2 sigma^2 exp(-(pi l f)^2), without band limits.
struct GaussianPsd {
  static constexpr const char* kModel = "gaussian";
  double rms = 0, correlation_length = 0;
};
/// Tabulated S with log-log interpolation between the points; zero outside.
struct TablePsd {
  std::vector<double> frequency;  ///< ascending, > 0 [cycles/m]
  std::vector<double> psd;        ///< > 0 [m^4]
};
struct SumPsd;
/// The models that have parameters, and what else a place takes.
template <class... Others>
using PsdModelOr = std::variant<UniformPsd, KCorrelationPsd, PowerLawPsd, GaussianPsd, Others...>;
using PsdModel = PsdModelOr<TablePsd, SumPsd>;
struct SumPsd {
  std::vector<PsdModel> parts;
};

/// Checks a model. Returns an empty text for a usable model, else a sentence with the problem: rms not
/// positive, f_min >= f_max, no finite height variance for an `rms`, unsorted table, ... A power law with
/// `amplitude` may have any band, because its Zernike covariances may exist even if its moments are infinite.
std::string psd_problem(const PsdModel& model);

/// The role of a number in a model. It decides how the number scales with heights and with frequencies.
enum class PsdRole {
  kRms,        ///< RMS height inside the band [m]
  kAmplitude,  ///< S at 1 cycle/m of the power of f that S is at high frequency [m^4]
  kLength,     ///< of the surface [m]
  kExponent,   ///< a pure number
  kLowest,     ///< where the band begins [cycles/m]
  kHighest,    ///< where the band ends [cycles/m]; may be infinity
  kFrequency,  ///< points of a table [cycles/m]
  kDensity,    ///< S at these points [m^4]
};
/// One number of a model, or one column of a table.
struct PsdMember {
  const char* key;  ///< of a study
  PsdRole role;
  std::span<double> values;  ///< in the model; empty if not set
};
/// All numbers of a model; of a sum none.
std::vector<PsdMember> psd_members(PsdModel& model);
/// S'(f) = heights^2 S(f/frequencies)/frequencies^2. Apart from the heights, the variance stays.
PsdModel scaled(PsdModel model, double heights, double frequencies);
/// S as formula with numbers, in the conventions of other programs too: lines that begin with "# PSD: ".
/// A k-correlation there goes up to 1/wavelength [m].
std::string psd_formula(const PsdModel& model, double wavelength);
/// "2.5 to 40 /m", or "from 2.5 /m on" for a band without end.
std::string band_text(double f_min, double f_max);

/// amplitude (f / reference)^-exponent [m^4].
struct PowerTerm {
  double amplitude = 0;  ///< [m^4]
  double exponent = 0;
  double reference = 1;  ///< [cycles/m]; e.g. the knee, which avoids overflow for steep powers

  double operator()(double f) const { return amplitude * std::pow(f / reference, -exponent); }
};

/// A PSD model ready for evaluation. Precondition: psd_problem(model) is empty.
class RadialPsd {
 public:
  explicit RadialPsd(const PsdModel& model);

  /// S(f) [m^4] for f >= 0 [cycles/m]; 0 outside the band.
  double operator()(double f) const;
  double f_min() const { return f_min_; }
  double f_max() const { return f_max_; }  ///< may be infinity
  /// Frequencies in (0, inf), ascending, where S or its derivative jumps: band edges, knees, table points.
  const std::vector<double>& breakpoints() const { return breakpoints_; }
  /// The same PSD with heights multiplied by `factor`.
  RadialPsd scaled(double height_factor) const;
  /// The part of this PSD inside [f_min, f_max]. It is zero, with zero moments, if the two bands do not meet.
  RadialPsd band(double f_min, double f_max) const;
  /// The limits of S for f -> 0 (parts whose band starts at 0) and for f -> infinity (parts whose band has no
  /// end), as sums of powers. They are exact to rounding beyond 1e-9 of the lowest and 1e9 of the highest
  /// breakpoint. They decide which integrals exist.
  std::vector<PowerTerm> low_frequency_terms() const;
  std::vector<PowerTerm> high_frequency_terms() const;

 private:
  RadialPsd() = default;
  void find_band();
  // Its closed forms need the models.
  friend Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r);
  struct Part {
    PsdModelOr<TablePsd> model;
    double factor;  // amplitude of the shape of the model [m^4]
    double f_min, f_max;
  };
  std::vector<Part> parts_;
  std::vector<double> breakpoints_;
  double f_min_ = 0, f_max_ = 0;
};

/// Integrals of an isotropic PSD over its band.
struct PsdMoments {
  double height_variance = 0;         ///< int S d2f [m^2]
  double slope_variance = 0;          ///< int (2 pi f)^2 S d2f, both axes together
  double f2_squared = 0;              ///< int (f^2 S)^2 d2f [m^2]; needed for N_eff
  double rms_height() const;          ///< [m]
  double rms_slope_per_axis() const;  ///< sqrt(slope_variance / 2)
};
/// Moments by Gauss-Legendre panels that resolve S between breakpoints, and closed forms of its powers at 0
/// and infinity. Relative error below 1e-12. An integral that does not exist is infinity (height_variance
/// only if `amplitude` was given).
PsdMoments psd_moments(const RadialPsd& psd);

/// N_eff = area (int f^2 S d2f)^2 / int (f^2 S)^2 d2f: the number of modes that carry the slope over an
/// aperture of `area` [m^2]. Infinity when only the slope variance diverges, NaN when both integrals do.
double effective_modes(const PsdMoments& moments, double area);

/// ACF C(r) = 2 pi int S(f) J0(2 pi f r) f df [m^2] at r >= 0 [m]; infinity when the height variance is
/// infinite. Error below 1e-11 C(0). Gauss-Legendre panels serve up to 2 pi f r = 30 and Filon panels of the
/// Hankel amplitude beyond, so the cost does not grow with r.
double autocorrelation(const RadialPsd& psd, double r);
/// The same at many r, with S evaluated once. Prefer it for long tables.
Eigen::ArrayXd autocorrelation(const RadialPsd& psd, const Eigen::ArrayXd& r);
/// C(0) - C(r) [m^2] at many r >= 0 [m]: half the structure function of the heights. The relative error is
/// below 1e-11 even for small r, where the difference of two autocorrelations loses its digits. For a
/// k-correlation whose exponent is within 1e-6 of an even number it is up to 1e-7. Closed forms serve the
/// Gaussian and the k-correlation without band limits and the uniform band, with power series at small r;
/// otherwise the integral of S (1 - J0), whose integrand has one sign. It exists for S up to f^-4 at f = 0,
/// even where the height variance does not (e.g. Kolmogorov's f^-11/3). It is infinity beyond that, and where
/// the height variance diverges at high frequency.
Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r);
/// l_c = int_0^inf C(r)/C(0) dr = int S df / (height variance) [m]. Infinity when int S df diverges at f = 0;
/// NaN without a finite height variance.
double correlation_length(const RadialPsd& psd);

}  // namespace aberfit
