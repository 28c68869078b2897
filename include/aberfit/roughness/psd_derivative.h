#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// A number that a PSD model is made of.
struct PsdVariable {
  enum class Kind {
    kRms,                ///< [m]
    kAmplitude,          ///< [m^4], of a power law
    kCorrelation,        ///< B of a k-correlation [m]; its knee is at f = 1/B
    kExponent,           ///< of a k-correlation or a power law
    kCorrelationLength,  ///< of a Gaussian [m]
    kLowest,             ///< f_min [cycles/m], where it is above zero
    kHighest,            ///< f_max [cycles/m], where it is finite
    kTableValue,         ///< S at one row of a table [m^4]
    kHeights,            ///< factor on all heights of the part, 1 in the model itself
  };
  Kind kind = Kind::kRms;
  std::vector<std::size_t> part;  ///< of sums, from the outermost on; empty where the model is none
  std::size_t row = 0;            ///< of a table

  bool operator==(const PsdVariable&) const = default;
};

/// All numbers of a model that have a derivative, part after part: those of its struct that are set, table
/// values, without kHeights.
std::vector<PsdVariable> psd_variables(const PsdModel& model);
/// JSON pointer below /roughness/psd of a study that says the model as it is: "/parts/0/B", "/rms"; of a
/// table
/// "/psd/3", of kHeights "/scale".
std::string pointer_of(const PsdVariable& parameter);
/// The parameter of a model that has this pointer, kHeights included. Throws std::invalid_argument where it
/// has none.
PsdVariable psd_variable(const PsdModel& model, const std::string& pointer);
double value_of(const PsdModel& model, const PsdVariable& parameter);
/// The model with another value: what the derivative is the derivative of. `rms` stays that of the band.
PsdModel with_value(const PsdModel& model, const PsdVariable& parameter, double value);

/// dS/dp of a PSD model, all other numbers of the model as they are: a density over frequency, and rings
/// where an end of the band moves. Everything that is linear in S - moments, autocorrelation, structure
/// function - has the derivative that is the same integral over this. Exact: d ln S/dp in closed form, also
/// of the factor that `rms` makes of the band. Cheap to copy; const use from many threads.
class PsdDerivative {
 public:
  /// Precondition: psd_problem(model) is empty.
  PsdDerivative(const PsdModel& model, const PsdVariable& parameter);

  /// A ring of height variance at one frequency, per unit of p [m^2].
  struct Ring {
    double frequency = 0, variance = 0;
  };
  /// The part of it inside [f_min, f_max].
  PsdDerivative band(double f_min, double f_max) const;
  /// dS/dp at f >= 0 inside the band [m^4 per unit of p]; without the rings.
  double density(double f) const;
  const std::vector<Ring>& rings() const { return rings_; }
  /// 2 pi int_a^b f^(power + 1) dS/dp df, rings at a or b included. Relative error below 1e-12 of the same
  /// integral over |dS/dp|. Where radial_moment is infinite its derivative is NaN.
  double moment(double power, double a = 0, double b = std::numeric_limits<double>::infinity()) const;
  /// d(C(0) - C(r))/dp [m^2 per unit of p] at many r >= 0 [m]; error below 1e-11 of that over |dS/dp|. NaN
  /// where the structure function is infinite.
  Eigen::ArrayXd structure_function(const Eigen::ArrayXd& r) const;
  /// dS/dp over S, 1/p-like, where the two are proportional at every frequency of the whole model, as for the
  /// rms of a model that is no sum; 0 elsewhere.
  double proportion() const;
  /// Of the highest frequency of the whole model: 1 where p is it, else 0. What is made for a band edge moves
  /// with it.
  double highest_frequency() const { return highest_; }

 private:
  struct Slope;
  RadialPsd part_;
  std::shared_ptr<const Slope> slope_;
  std::vector<Ring> rings_;
  double highest_ = 0;
  bool is_whole_ = false;  // the part is the model
};

}  // namespace aberfit
