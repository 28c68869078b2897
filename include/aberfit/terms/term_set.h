#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/scene/zernike.h"

namespace aberfit {

/// Plane wave A cos(2 pi f.x) + B sin(2 pi f.x).
struct FourierMode {
  double fx = 0;  ///< [cycles/m]
  double fy = 0;  ///< [cycles/m]
};

/// Which aberration terms a surface has; what they weigh is a coefficient vector of `size()` entries, all
/// heights [m]:
///   one per Zernike mode (RMS over the disc); then A, B per Fourier mode (amplitudes);
///   then one per spherical power: c_2n radius^2n, the height of the term at the rim.
struct TermSet {
  double radius = 0;  ///< normalisation radius of Zernike and spherical terms [m]
  std::vector<ZernikeMode> zernike;
  std::vector<FourierMode> fourier;
  std::vector<int> spherical;  ///< even powers out of 4, 6, 8, 10, 12
  /// Where all Fourier modes are points of a lattice, i pitch and j pitch, each standing for its cell: the
  /// pitch [cycles/m], which fast transforms and the prior go by; else 0.
  double fourier_pitch = 0;

  Eigen::Index size() const { return Eigen::Index(zernike.size() + 2 * fourier.size() + spherical.size()); }
  Eigen::Index fourier_begin() const { return Eigen::Index(zernike.size()); }
  Eigen::Index spherical_begin() const { return Eigen::Index(zernike.size() + 2 * fourier.size()); }
};

/// All modes n_min <= n <= n_max in OSA order (n ascending, then m ascending).
std::vector<ZernikeMode> zernike_modes(int n_min, int n_max);

}  // namespace aberfit
