#pragma once
#include <Eigen/Core>
#include <vector>

#include "moment_panels.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// The autocorrelation of a round pupil's field, split by position in the pupil. Let a = (|P| / outer)^2 at
/// the midpoint and b = (its part along the shear / outer)^2. For a function H of a and b that is close to a
/// polynomial,
///   int A(P + x/2) A*(P - x/2) H d2P / int |A|^2 d2P = sum_ij moment_ij(x) H(a_i, b_j),
/// with a_i and b_j the nodes of a basis. The moments do not depend on the roughness: one set serves a plane.
/// They are the real part, which decides encircled energies. By Gauss-Legendre, to 1e-11.
class PupilOverlap {
 public:
  /// `field`, which is round, and `basis` must outlive it.
  PupilOverlap(const PupilField& field, double dz, const MomentBasis& basis);

  /// order^2 moments at shear x >= 0 [m], i major. Safe from many threads.
  Eigen::ArrayXd operator()(double x) const;
  /// Estimate of the largest phase change [rad] across the overlap at shears up to `end` [m].
  double turn(double end) const;

 private:
  /// Midpoints of pairs in a quarter of the overlap, first axis along the shear, with weights [m^2].
  struct Points {
    std::vector<double> u, v, weight;
    void resize(std::size_t count);
  };
  /// The two pupil points of each midpoint: positions, product of amplitudes, difference of phases.
  struct Pairs {
    std::vector<double> x1, x2, amplitude, wave, scratch, cosine;
  };
  /// Change of the phase [rad] along the shear and across it.
  struct Turn {
    double along = 0, across = 0;
  };
  /// The area between a circle's upper half, from u1 to u2, and its diameter; added or subtracted by `sign`.
  struct Arc {
    double radius, centre, u1, u2, sign;
  };
  std::vector<Arc> arcs(double shear) const;
  Turn turn_of(const std::vector<Arc>& arcs, double x) const;
  void set_points(const std::vector<Arc>& arcs, const Turn& turn, Points* points) const;
  void set_pairs(const Points& points, double x, Pairs* pairs) const;

  const PupilField& field_;
  const MomentBasis& basis_;
  double dz_ = 0;
  double scale_ = 1;  // 1 / int |A|^2 d2P
};

}  // namespace aberfit::internal
