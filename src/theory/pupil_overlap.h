#pragma once
#include <Eigen/Core>
#include <vector>

#include "moment_basis.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// The autocorrelation of a round pupil's field, split by where in the pupil: a function H of
/// a = (|P| / outer)^2 of the midpoint and b = (its part along the shear / outer)^2 that is close to a
/// polynomial has
///   int A(P + x/2) A*(P - x/2) H d2P / int |A|^2 d2P = sum_ij moment_ij(x) H(a_i, b_j),
/// with a_i and b_j the nodes of a basis. The moments hold no roughness: one set serves a plane. Real part,
/// which is what encircled energy sees. By Gauss-Legendre under the arcs of the overlap, to 1e-11.
class PupilOverlap {
 public:
  /// `field`, which is round, and `basis` must outlive it.
  PupilOverlap(const PupilField& field, double dz, const MomentBasis& basis);

  /// order^2 moments at shear x >= 0 [m], i major. Safe from many threads.
  Eigen::ArrayXd operator()(double x) const;
  /// Largest turn of the phase across the overlap at shears up to `end` [m], an estimate [rad].
  double turn(double end) const;

 private:
  /// Points of a quarter of the overlap, midpoints of the two pupil points in a frame whose first axis is the
  /// shear, and their weights [m^2].
  struct Points {
    std::vector<double> u, v, weight;
    void resize(std::size_t count);
  };
  /// What the two pupil points of each have: places, product of amplitudes, difference of phases.
  struct Pairs {
    std::vector<double> x1, x2, amplitude, wave, scratch, cosine;
  };
  /// The phase [rad] that turns along the shear and across it.
  struct Turn {
    double along = 0, across = 0;
  };
  /// Between a circle's upper half, from u1 to u2, and its diameter; added or taken off.
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
