#pragma once
#include <cstdint>
#include <vector>

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
  int scales = 1;  ///< > 1: that many grids of ever lower frequency are added, each `oversize` times larger,
                   ///< for bands wider than one grid
};

/// A draw of a stationary surface with PSD S on rows x columns points of the given pitch [m]. Expected
/// variance: that of the part of S the grid (all scales together) can hold; any rows, columns, odd or even,
/// square or not.
HeightMap random_surface(const RadialPsd& psd, Eigen::Index rows, Eigen::Index columns, double pitch,
                         const RandomSurfaceOptions& options = {});

/// Heights along a line over such a surface: one-sided S1(f) = 2 int S2(sqrt(f^2 + fy^2)) dfy.
Profile random_profile(const RadialPsd& psd, Eigen::Index points, double pitch,
                       const RandomSurfaceOptions& options = {});

/// The one-sided profile PSD S1(f) [m^3] of an isotropic surface, f > 0 [cycles/m]; error below 1e-9 of S1.
double profile_psd(const RadialPsd& psd, double f);

}  // namespace aberfit
