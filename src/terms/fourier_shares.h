#pragma once
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// Height variance [m^2] of each mode. The band is divided into rings halfway (in log f) between neighbouring
/// |f| of the modes; the first and last ring extend to the band's edges. The modes of one |f| divide the
/// variance of their ring equally. The sum is the height variance of the PSD; modes outside its band get 0.
/// Throws ComputationError when the height variance is infinite.
std::vector<double> fourier_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes);

/// Height variance of each lattice mode [m^2]: the integral of the PSD over the grid cells about f and -f.
std::vector<double> lattice_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes,
                                      double pitch);

}  // namespace aberfit::internal
