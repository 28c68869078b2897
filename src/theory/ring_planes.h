#pragma once
#include <functional>

#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit::internal {

/// How N(z), the light inside a ring in the plane z = f + dz, is looked at. Every plane may cost seconds.
struct RingSearch {
  double step;      ///< [m] of the first look: best between a third and a tenth of the width
  double furthest;  ///< [m] |dz| of the last plane that may be asked for
  double accuracy;  ///< of a crossing, as a share of its distance from the peak
  double gain;      ///< of N(z), relative: a peak that is higher by less is no better
};

/// The planes of a ring, with the halves nearest to its peak; NaN where one of them is beyond `furthest`.
/// `energy`(dz) is looked at from the focus outwards until it holds less than half of the most, closer
/// wherever it holds nearly the most - of an annulus the focus may lie between two peaks -, and where
/// polynomials through the planes about the highest one have theirs. Peaks closer together than an eighth of
/// the width are found if their neighbours hold nine tenths of them.
GeneralisedHarveyShack::RingPlanes ring_halves(const std::function<double(double)>& energy,
                                               const RingSearch& search);

}  // namespace aberfit::internal
