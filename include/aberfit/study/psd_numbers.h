#pragma once
#include <memory>
#include <string>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// A number of the `psd` block of a resolved study that a solve may look for.
struct PsdNumber {
  std::string pointer;  ///< "/roughness/psd/rms"
  double value = 0;     ///< [its SI unit]
  Dimension dimension = Dimension::kNumber;
};

/// All such numbers, including those of a sum's parts. A line of a drawing (`profile_psd`) appears as the
/// amplitude and exponent that it stands for. A measurement has none: its numbers are data.
std::vector<PsdNumber> psd_numbers(const Study& study);

/// Studies that differ in a few numbers, each read as from a file. Without tables this is fast enough for
/// every step of a solve. Many threads may use a const object.
class StudyFamily {
 public:
  StudyFamily(const Study& study, const std::vector<std::string>& pointers);
  ~StudyFamily();
  /// Throws InputError like read_study.
  Task operator()(const std::vector<double>& values) const;

 private:
  struct Text;
  std::shared_ptr<const Text> text_;
};

}  // namespace aberfit
