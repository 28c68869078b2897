#include "aberfit/measured/profile.h"

#include <algorithm>
#include <vector>

namespace aberfit {

Eigen::Index valid_count(const Profile& profile) { return profile.value.isFinite().count(); }

double median_pitch(const Profile& profile) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < profile.size(); ++i) steps.push_back(profile.x[i] - profile.x[i - 1]);
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + std::ptrdiff_t(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace aberfit
