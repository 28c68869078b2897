#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// A parameter of a PSD model.
struct PsdVariable {
  /// Key of the number in a study (PsdMember), with a derivative if it is not f_min = 0 or f_max = infinity;
  /// "psd" for S at one row of a table [m^4]; "scale" for a factor on all heights of the part, 1 in the model
  /// itself.
  std::string key = "rms";
  /// Path of part indices in a sum, from the outermost; empty for a model that is not a sum.
  std::vector<std::size_t> part;
  std::size_t row = 0;  ///< row of a table

  bool operator==(const PsdVariable&) const = default;
};

/// All parameters of a model that have a derivative, in the order of its parts: numbers of its struct that
/// are set, and table values. "scale" is not included.
std::vector<PsdVariable> psd_variables(const PsdModel& model);
/// JSON pointer below /roughness/psd of a study with this model: "/parts/0/B", "/rms", "/psd/3" for a table,
/// "/scale".
std::string pointer_of(const PsdVariable& parameter);
/// The parameter with this pointer, "/scale" included. Throws std::invalid_argument if there is none.
PsdVariable psd_variable(const PsdModel& model, const std::string& pointer);
double value_of(const PsdModel& model, const PsdVariable& parameter);
/// The model with another value of the parameter. `rms` stays the RMS of the band.
PsdModel with_value(const PsdModel& model, const PsdVariable& parameter, double value);

/// dS/dp of a PSD model at constant other parameters: a density over frequency, and rings where an end of the
/// band moves. Every quantity linear in S (moments, autocorrelation, structure function) has as derivative
/// the same integral over dS/dp. It is exact: d ln S/dp is in closed form, including the normalisation by
/// `rms`. Copies are cheap; many threads may use a const object.
class PsdDerivative {
 public:
  /// Precondition: psd_problem(model) is empty.
  PsdDerivative(const PsdModel& model, const PsdVariable& parameter);

  /// A ring of height variance at one frequency, per unit of p [m^2].
  struct Ring {
    double frequency = 0, variance = 0;
  };
  /// The part of dS/dp inside [f_min, f_max].
  PsdDerivative band(double f_min, double f_max) const;
  /// dS/dp at f >= 0 inside the band [m^4 per unit of p], without the rings.
  double density(double f) const;
  const std::vector<Ring>& rings() const { return rings_; }
  /// 2 pi int_a^b f^(power + 1) dS/dp df, including rings at a or b. The error is below 1e-12 of the same
  /// integral over |dS/dp|. NaN where radial_moment is infinite.
  double moment(double power, double a = 0, double b = std::numeric_limits<double>::infinity()) const;
  /// d(C(0) - C(r))/dp [m^2 per unit of p] at many r >= 0 [m]. The error is below 1e-11 of the same over
  /// |dS/dp|. NaN where the structure function is infinite.
  Eigen::ArrayXd structure_function(const Eigen::ArrayXd& r) const;
  /// dS/dp over S if it is the same at all frequencies of the whole model, e.g. for the rms of one part; else
  /// 0.
  double proportion() const;
  /// Derivative of the highest frequency of the whole model: 1 if p is that frequency, else 0. Quantities
  /// made for the band edge move with it.
  double highest_frequency() const { return highest_; }

 private:
  struct Slope;
  RadialPsd part_;
  std::shared_ptr<const Slope> slope_;
  std::vector<Ring> rings_;
  double highest_ = 0;
  bool is_whole_ = false;  // true if the part is the whole model
};

}  // namespace aberfit
