#pragma once
#include <Eigen/Core>
#include <vector>

#include "../waves/diffraction_lags.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/waves/diffraction_psf.h"
#include "moment_basis.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// The field of a pupil on cells, in any plane.
class PupilCells {
 public:
  /// cells: across the circle about the aperture.
  PupilCells(const PupilField& field, int cells);
  /// Evenly lit, without aberration, by place instead of direction.
  PupilCells(const Aperture& aperture, int cells);

  const DiffractionPupil& pupil() const { return pupil_; }
  double pitch() const { return pupil_.pitch_x; }  ///< of P [m]
  int side() const { return side_; }               ///< columns or rows, whichever are more
  Eigen::Index column(Eigen::Index cell) const { return grid().column[std::size_t(cell)]; }
  Eigen::Index row(Eigen::Index cell) const { return grid().row[std::size_t(cell)]; }
  /// (|P| / outer)^2 of each cell.
  const Eigen::ArrayXd& square() const { return square_; }
  double outer() const { return outer_; }  ///< [m]
  /// Parts of the mirror that the cells stand for, in any unit.
  Eigen::ArrayXd area() const;
  /// Phase of each cell in the plane f + dz [rad].
  Eigen::ArrayXd phase(double dz) const;
  /// Largest slope of that phase between neighbours, in waves over the aperture's diameter.
  double steepest(double dz) const;

 private:
  PupilCells(const Aperture& aperture, double focal_length, double outer, int cells);
  const CartesianGrid& grid() const;

  DiffractionPupil pupil_;
  int side_ = 0;
  double focal_length_ = 0, wavelength_ = 1, outer_ = 0;
  Eigen::ArrayXd square_, path_, departure_;  // 1 - c; phase of the mirror itself [rad]
};

/// What is made once for all pupils of a size: the transform to the focal plane, and how far its samples lie
/// from the axis.
struct FocalGrid {
  explicit FocalGrid(int samples);
  /// Samples a side, even, whose light has the pupil's autocorrelation at shears up to `end` [m].
  static int samples_for(const PupilCells& cells, double end);

  int side;
  FourierTransform transform;
  LagTable rings;  ///< of samples, as far as the taper goes
};

/// The light of a pupil over its distance from the axis, split by where in the pupil it comes from. Of two
/// points P1 and P2 with u, v = (|P| / outer)^2, whose midpoint has the square a and the part b of it along
/// the shear x,
///   a = (u + v)/2 - x^2/4, b = (u - v)^2/(4 x^2)  (x over outer),
/// so that moments of polynomials in a and b are sums of products of functions of one point each: of
/// F_i F_j*, F_i the transform of the field times u^i.
struct PupilLight {
  /// ((u + v)/2)^i (u - v)^(2j).
  struct Product {
    int i, j;
    std::vector<double> of_powers;  ///< k: of u^(i + 2j - k) v^k
  };
  static std::vector<Product> products(int degree);

  int degree = 0;
  double outer = 0;          ///< [m]
  Eigen::ArrayXd distance;   ///< of the nodes, over lambda times the focal length [cycles/m]
  Eigen::ArrayXXd light;     ///< nodes x products, tapered; all light 1
  double edge = 0, end = 0;  ///< between them the taper falls from 1 to 0 [cycles/m]
  Eigen::MatrixXd mean;      ///< of a^i b^j over the aperture

  /// The same in all directions: of any field.
  static PupilLight of_cells(const PupilCells& cells, const FocalGrid& grid, int degree, double dz);
  /// Of a round field, by its Hankel transform: far out of focus, where cells would be too many.
  static PupilLight of_rings(const PupilField& field, int degree, double dz);
};

/// The autocorrelation of a pupil's field, as PupilOverlap has it:
///   moment_pq(x) = int A(P + x/2) A*(P - x/2) T_p(2a - 1) T_q(2b - 1) d2P / int |A|^2 d2P,
/// p + q up to the degree of its light, averaged over the direction of the shear x: the sum over the light of
/// J0(2 pi distance x). Light beyond the taper comes from sharp edges alone and falls with the cube of the
/// distance; so much of it as is missing is added. Against closed forms within 1e-4 at every shear and 1e-5
/// from ten cells on, encircled energies within 5e-5 (tests/theory/pupil_light_test.cpp).
class LightMoments {
 public:
  LightMoments(PupilLight light, const MomentBasis& basis);
  /// At shears x [m]: rows of moments at the basis' nodes, i major.
  Eigen::ArrayXXd operator()(const Eigen::ArrayXd& x) const;
  /// Of the whole aperture.
  Eigen::ArrayXd whole() const;
  /// Shear that panels of kPanelNodes resolve [m].
  double resolved() const;

 private:
  Eigen::MatrixXd chebyshev(const Eigen::MatrixXd& monomials) const;
  Eigen::MatrixXd monomials(const Eigen::ArrayXd& sums, double shear2) const;

  PupilLight light_;
  const MomentBasis& basis_;
  std::vector<PupilLight::Product> products_;
  Eigen::MatrixXd shifted_;      // (p, i): of t^i in T_p(2t - 1)
  double missing_ = 0;           // share of the light beyond the taper
  Eigen::ArrayXd tail_, share_;  // distances beyond it [cycles/m], and shares of what is missing
};

}  // namespace aberfit::internal
