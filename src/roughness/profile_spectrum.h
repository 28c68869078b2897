#pragma once
#include <vector>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {

/// profile_psd at many frequencies from `lowest` up [cycles/m], with the same error. S is evaluated once on
/// panels of its band, and again only on the panels next to f.
class ProfileSpectrum {
 public:
  ProfileSpectrum(const RadialPsd& psd, double lowest);
  double operator()(double f) const;

 private:
  const RadialPsd& psd_;
  std::vector<PsdPanel> panels_;  // ascending, to the end of the band or to tail_from_
  std::vector<PowerTerm> tail_;
  double tail_from_ = 0;
};

}  // namespace aberfit::internal
