#pragma once
#include <cstdint>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/psd.h"

namespace aberfit {

enum class SpectrumDraw {
  kGaussian,  ///< Gaussian amplitudes: a realisation of the random process
  /// Fixed amplitudes, random phases: each realisation has the mean RMS, but not the statistics of the
  /// process.
  kPhaseOnly,
};

struct RandomSurfaceOptions {
  SpectrumDraw draw = SpectrumDraw::kGaussian;
  std::uint64_t seed = 1;
  /// Size of the spectrum's grid over the size of the map. 1 gives a periodic map. 2 or more gives a cut-out
  /// without correlation between opposite edges and with waves longer than the map.
  int oversize = 2;
  /// Number of grids, for bands wider than one grid. Each grid after the first is `oversize` (at least 2)
  /// times larger and replaces the lowest frequencies of the previous one.
  int scales = 1;
};

/// A realisation of a stationary surface with PSD S on rows x columns points of the given pitch [m], with the
/// origin in the centre. Rows and columns may be odd, even and different. The expected variance is exactly
/// int S over the frequencies of the grids. These are the rectangle |fx|, |fy| <= 1/(2 pitch) without a
/// rectangle around zero (longer waves), as wide as one frequency step of the largest grid. Throws
/// std::invalid_argument for sizes or options below 1 and a pitch that is not positive.
HeightMap random_surface(const RadialPsd& psd, Eigen::Index rows, Eigen::Index columns, double pitch,
                         const RandomSurfaceOptions& options = {});

/// Heights along a line over such a surface, with its one-sided S1(f) (`profile_psd`). The same rules hold.
Profile random_profile(const RadialPsd& psd, Eigen::Index points, double pitch,
                       const RandomSurfaceOptions& options = {});

/// The one-sided profile PSD of an isotropic surface, f > 0 [cycles/m],
///   S1(f) = 2 int_-inf^inf S2(sqrt(f^2 + fy^2)) dfy = 4 int_f^inf S2(g) g / sqrt(g^2 - f^2) dg [m^3],
/// with int_0^inf S1 df = variance (FORMATS, PSD conventions: int S2 dfy alone is S1/2). Error below 1e-9 of
/// S1. Infinity if S2 falls as 1/f or more slowly without a band limit.
double profile_psd(const RadialPsd& psd, double f);

}  // namespace aberfit
