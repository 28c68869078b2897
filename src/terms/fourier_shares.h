#pragma once
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// Height variance [m^2] each mode stands for. The band is cut into rings halfway (in log f) between
/// neighbouring |f| of the modes, the first and last reaching to the band's edges; the variance of a ring is
/// shared equally by the modes of its |f|. Sums to the height variance of the PSD; modes outside its band get
/// 0. Throws ComputationError when the height variance is infinite.
std::vector<double> fourier_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes);

/// That of the cell of each mode of a lattice [m^2]: the integral of the PSD over the squares about f and -f.
std::vector<double> lattice_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes,
                                      double pitch);

}  // namespace aberfit::internal
