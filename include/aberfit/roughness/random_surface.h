#pragma once
#include <cstdint>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/psd.h"

namespace aberfit {

enum class SpectrumDraw {
  kGaussian,   ///< Gaussian amplitudes: a draw of the random process
  kPhaseOnly,  ///< fixed amplitudes, random phases: every draw has the mean RMS; its statistics are not those
               ///< of the process
};

struct RandomSurfaceOptions {
  SpectrumDraw draw = SpectrumDraw::kGaussian;
  std::uint64_t seed = 1;
  /// Grid of the spectrum over the size of the map: 1 gives a periodic map, 2 or more a cut-out that knows
  /// nothing of its own edges and holds waves longer than itself.
  int oversize = 2;
  /// Grids in all. Those after the first replace the lowest frequencies of the one before, each `oversize`
  /// (at least 2) times larger than the one before, for bands wider than one grid.
  int scales = 1;
};

/// A draw of a stationary surface with PSD S on rows x columns points of the given pitch [m], the origin in
/// the middle. Expected variance: int S over the frequencies that the grids hold, exactly: the rectangle
/// |fx|, |fy| <= 1/(2 pitch) without the one around zero that is a frequency step of the largest grid wide
/// (waves too long for it). Any rows, columns, odd or even, square or not. Throws std::invalid_argument for
/// sizes or options below 1 and a pitch that is not positive.
HeightMap random_surface(const RadialPsd& psd, Eigen::Index rows, Eigen::Index columns, double pitch,
                         const RandomSurfaceOptions& options = {});

/// Heights along a line over such a surface, with its one-sided S1(f) (`profile_psd`); the same rules in one
/// dimension.
Profile random_profile(const RadialPsd& psd, Eigen::Index points, double pitch,
                       const RandomSurfaceOptions& options = {});

/// The one-sided profile PSD of an isotropic surface, f > 0 [cycles/m],
///   S1(f) = 2 int_-inf^inf S2(sqrt(f^2 + fy^2)) dfy = 4 int_f^inf S2(g) g / sqrt(g^2 - f^2) dg [m^3],
/// so that int_0^inf S1 df = variance (FORMATS, PSD conventions: int S2 dfy alone is S1/2). Error below 1e-9
/// of S1; infinity where S2 falls as 1/f or slower for ever.
double profile_psd(const RadialPsd& psd, double f);

}  // namespace aberfit
