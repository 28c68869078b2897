#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/theory/aperture_otf.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// `PupilOverlap` of a mirror without aberrations, far out of focus, where its integral takes too many
/// points, or means over the azimuth where it errs by next to nothing. There the light of every point of the
/// pupil goes where its ray does, but for diffraction at the rim: a phase that grows with the square of |P|
/// has the overlap in closed form (`ApertureOtf`), and to it is added by how much rays on their true ways,
/// with their true weights and the moments' polynomials, have another transfer than those of the square, both
/// without diffraction,
///   int w(p) l_i(p^2) l_j(p^2 cos^2) cos(x q(p) cos) d2p,  q = d(phase)/dp,
/// whose mean over the azimuth is a sum of Bessel functions J_0, J_2, ... of x q (DLMF 10.12).
/// What is left is diffraction at the rim times how far the two ways differ (`error`).
class FarOverlap {
 public:
  /// Share of the transfer that roughness leaves at shears where it blurs.
  static constexpr double kBlurred = 0.01;
  /// What an encircled energy errs by at most, for a PSD that leaves kBlurred of the transfer or less at
  /// shears beyond `blurred` [m]: of the square of the rim's P/f, the power -0.6 of the phase [rad] from the
  /// middle of the aperture to its rim where the rim's fringes are there to be seen, less where the roughness
  /// blurs them. From f/1.3 to f/8 and 40 to 1200 rad, largest of 20 radii against `PupilOverlap`: 0.3 to 1
  /// of it for discs and annuli, 0.1 to 0.9 for hexagon and rectangle. Infinite below 40 rad.
  static double error(const PupilField& field, double dz, double blurred);
  /// `nodes`: a_i of the moments, `whole`: those of the aperture without shear.
  FarOverlap(const PupilField& field, double dz, const std::vector<double>& nodes, Eigen::ArrayXd whole);
  /// As PupilOverlap's, at shear x >= 0 [m]. Safe from many threads.
  Eigen::ArrayXd operator()(double x) const;
  /// Shears [m] between which few panels do, ascending. Of polygons the last one is where the moments end:
  /// their means over azimuth are known to 2e-5, and so small there.
  std::vector<double> breakpoints() const;

 private:
  void set_polynomials(const std::vector<double>& nodes, const Eigen::ArrayXd& radius,
                       const Eigen::ArrayXd& share, const PupilField& field);

  double curvature_ = 0, gone_ = 0;
  int order_ = 1;
  bool ends_ = false;
  Eigen::ArrayXd whole_;
  ApertureOtf otf_;
  Eigen::ArrayXd straight_slopes_, slopes_;  // of the square and the phase, at radii of a rule each [rad/m]
  Eigen::MatrixXd straight_;                 // (radius, 1): shares of the aperture
  Eigen::MatrixXd polynomial_;               // (radius and harmonic, moment): weights of J_2m, radius minor
};

}  // namespace aberfit::internal
