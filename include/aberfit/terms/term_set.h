#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "aberfit/scene/segments.h"
#include "aberfit/scene/zernike.h"

namespace aberfit {

/// Plane wave A cos(2 pi f.x) + B sin(2 pi f.x).
struct FourierMode {
  double fx = 0;  ///< [cycles/m]
  double fy = 0;  ///< [cycles/m]
};

/// The aberration terms of a surface. A coefficient vector has `size()` entries, all heights [m], in this
/// order:
///   one per Zernike mode (RMS over the disc);
///   A, B per Fourier mode (amplitudes);
///   one per spherical power: c_2n radius^2n, the height of the term at the rim;
///   per segment with errors: its piston, if any, then its slopes along x and y about its centre, if any,
///   each times its radius.
struct TermSet {
  double radius = 0;  ///< normalisation radius of Zernike and spherical terms [m]
  std::vector<ZernikeMode> zernike;
  std::vector<FourierMode> fourier;
  std::vector<int> spherical;  ///< even powers from 4, 6, 8, 10, 12
  /// Pitch [cycles/m] if all Fourier modes are points (i, j) pitch of a lattice and each represents its grid
  /// cell; else 0. Fast transforms and the prior use it.
  double fourier_pitch = 0;
  std::shared_ptr<const Segments> segments = nullptr;

  Eigen::Index size() const {
    return segments_begin() + (segments ? Eigen::Index(segments->all().size()) * of_a_segment() : 0);
  }
  Eigen::Index fourier_begin() const { return Eigen::Index(zernike.size()); }
  Eigen::Index spherical_begin() const { return Eigen::Index(zernike.size() + 2 * fourier.size()); }
  Eigen::Index segments_begin() const { return spherical_begin() + Eigen::Index(spherical.size()); }
  /// Number of terms per segment.
  Eigen::Index of_a_segment() const {
    return segments ? (segments->piston() > 0 ? 1 : 0) + (segments->tip_tilt() > 0 ? 2 : 0) : 0;
  }
  /// All other terms: a smooth surface with the first segments_begin() coefficients.
  TermSet without_segments() const {
    TermSet others = *this;
    others.segments.reset();
    return others;
  }
};

/// All modes n_min <= n <= n_max in OSA order (n ascending, then m ascending).
std::vector<ZernikeMode> zernike_modes(int n_min, int n_max);

}  // namespace aberfit
