#pragma once
#include <functional>

#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit::internal {

/// Settings of the search in N(z), the energy inside a ring in the plane z = f + dz. Every plane may take
/// seconds.
struct RingSearch {
  double step;      ///< first step [m]; best between a third and a tenth of the width
  double furthest;  ///< largest |dz| of a plane [m]
  double accuracy;  ///< error of a crossing, relative to its distance from the peak
  double gain;      ///< relative to N(z): a peak that is higher by less does not count as higher
};

/// The planes of a ring, with the half crossings nearest to its peak; NaN where one of them is beyond
/// `furthest`. The search samples `energy`(dz) from the focus outwards until it is below half of the maximum.
/// It then refines at the peaks of polynomials through the planes about the highest one. It also refines
/// wherever the energy is nearly the maximum, because the focus of an annulus may lie between two peaks.
/// Peaks closer together than an eighth of the width are found if their neighbours hold nine tenths of them.
GeneralisedHarveyShack::RingPlanes ring_halves(const std::function<double(double)>& energy,
                                               const RingSearch& search);

}  // namespace aberfit::internal
