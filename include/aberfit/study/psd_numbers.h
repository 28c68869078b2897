#pragma once
#include <memory>
#include <string>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// A number of the `psd` block of a resolved study, which a solve may look for.
struct PsdNumber {
  std::string pointer;  ///< "/roughness/psd/rms"
  double value = 0;     ///< [its SI unit]
  Dimension dimension = Dimension::kNumber;
};

/// All of them, those of a sum's parts included; a line of a drawing (`profile_psd`) is there as the
/// amplitude and exponent that it stands for. None of a measurement, whose numbers are data.
std::vector<PsdNumber> psd_numbers(const Study& study);

/// Studies that differ in a few numbers, read as from a file: half a millisecond each, tables aside. Const
/// use from many threads.
class StudyFamily {
 public:
  StudyFamily(const Study& study, const std::vector<std::string>& pointers);
  ~StudyFamily();
  /// Throws InputError as read_study does.
  Task operator()(const std::vector<double>& values) const;

 private:
  struct Text;
  std::shared_ptr<const Text> text_;
};

}  // namespace aberfit
