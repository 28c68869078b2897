#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "aberfit/study/study_cases.h"

namespace aberfit {

/// All cases of a `vary` block, in their order. In a grid the last value changes fastest; Sobol points keep
/// the order of the sequence; realisations change fastest of all. Const use from many threads is safe.
class CasePlan {
 public:
  /// seed: of the first realisation (`fit.seed`). path: of the study, for messages. Throws InputError for a
  /// range whose ends do not fit together and for more than 1e9 cases.
  CasePlan(const VarySpec& vary, std::uint64_t seed, const std::string& path);

  std::size_t size() const { return places_ * realisations_; }
  std::size_t realisations() const { return realisations_; }
  /// Number of pointers() from `vary.over`.
  std::size_t axes() const { return axes_.size(); }
  /// JSON pointers of the varied values; with realisations the last is "/fit/seed".
  const std::vector<std::string>& pointers() const { return pointers_; }
  CaseValues at(std::size_t index) const;
  /// The values of the k-th pointer, as JSON texts; empty for a range of Sobol points.
  const std::vector<std::string>& values(std::size_t k) const { return axes_[k].values; }

 private:
  struct Axis {
    std::vector<std::string> values;
    VaryAxis range;
  };
  std::string sobol_value(std::size_t axis, double u) const;
  void place_sobol(const VarySpec& vary);

  std::vector<std::string> pointers_;
  std::vector<Axis> axes_;
  std::vector<std::vector<double>> points_;  // Sobol: [place][axis], in [0, 1)
  std::size_t places_ = 1, realisations_ = 1;
  std::uint64_t seed_ = 1;
};

/// First `count` points of the Sobol sequence in `dimensions` dimensions (direction numbers of Joe and Kuo
/// 2008, from Boost.Random), including the point 0. A random digital shift changes the bits of each
/// coordinate. Of 2^k points each of 2^k equal intervals of each coordinate holds one.
std::vector<std::vector<double>> shifted_sobol(std::size_t count, std::size_t dimensions, std::uint64_t seed);

/// The value at the fraction `share` of a range, as JSON text: 12 significant digits, in the unit of `from`.
/// Throws UnitError if the ends have no common unit, std::invalid_argument for log through 0.
std::string range_value(const VaryAxis& range, double share);

/// Number and unit of a value (empty for a plain number). `read_number` is false for other values.
struct NumberWithUnit {
  double number = 0;
  std::string unit;
};
bool read_number(const std::string& json, NumberWithUnit* value);

}  // namespace aberfit
