#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <compare>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "aberfit/roughness/line_kernel.h"
#include "aberfit/scene/segments.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/lag_table.h"
#include "moment_basis.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// Length of the edges of an aperture times its largest diameter over its area: 4 of a circle.
double slenderness(const Aperture& aperture);
/// Cells across an aperture for its edges, however long: a fiftieth of its light is beyond the taper of so
/// many.
double cells_for_edges(const Aperture& aperture);

/// Cells of a field, and what is in them.
struct LitCells {
  Eigen::Index columns = 0, rows = 0;
  std::vector<std::uint32_t> column, row;
  Eigen::ArrayXd amplitude, phase, square;  ///< phase [rad]; (|P| / outer)^2

  /// Takes some of these cells, whose columns and rows are given with their numbers.
  LitCells part(const struct SegmentCells& cells) const;
};

/// The cells of a segment, in the smallest rectangle that holds them.
struct SegmentCells {
  std::vector<Eigen::Index> number;
  std::vector<std::uint32_t> column, row;
  Eigen::Index columns = 0, rows = 0;
  double kept = 1;  ///< of the light of its pairs, where two points have the means of their fields
};

/// The field of a pupil on cells, in any plane.
class PupilCells {
 public:
  /// cells: across the circle about the aperture.
  PupilCells(const PupilField& field, int cells);
  /// Evenly lit, without aberration, by place instead of direction.
  PupilCells(const Aperture& aperture, int cells);

  const DiffractionPupil& pupil() const { return pupil_; }
  double pitch() const { return pupil_.pitch_x; }  ///< of P [m]
  Eigen::Index columns() const { return Eigen::Index(grid().x.size()); }
  Eigen::Index rows() const { return Eigen::Index(grid().y.size()); }
  double outer() const { return outer_; }  ///< [m]
  /// Means of a^i b^j over the mirror, i + j <= degree.
  Eigen::MatrixXd mean(int degree) const;
  /// Phase of each cell in the plane f + dz [rad].
  Eigen::ArrayXd phase(double dz) const;
  /// Largest slope of that phase between neighbours [cycles/m].
  double steepest(double dz) const;
  LitCells lit(double dz) const;

  /// Segments that err; none where they do not.
  const std::vector<SegmentCells>& segments() const { return segments_; }
  /// The mean of each cell's field over the errors of its segment, as a fraction of the field without them.
  const Eigen::ArrayXd& fade() const { return fade_; }
  /// Two points of one segment a shear x apart keep exp(-decay x^2) of their coherence [1/m^2].
  double decay() const { return decay_; }
  double longest_in_a_segment() const { return longest_; }  ///< shear within one [m]
  /// They have pistons alone, so that what fades is the same all over each.
  bool fade_is_even() const { return decay_ == 0; }

 private:
  PupilCells(const Aperture& aperture, double focal_length, double outer, int cells);
  void set_segments(const Segments& segments);
  const CartesianGrid& grid() const;

  DiffractionPupil pupil_;
  double focal_length_ = 0, wavelength_ = 1, outer_ = 0;
  Eigen::ArrayXd square_, path_, departure_;  // 1 - c; phase of the mirror itself [rad]
  std::vector<SegmentCells> segments_;
  Eigen::ArrayXd fade_;
  double decay_ = 0, longest_ = 0;
};

/// What is made once for all pupils of a size: the transform to the focal plane, and how far its samples lie
/// from the axis. Safe from many threads.
class FocalGrid {
 public:
  /// Samples along x and y, even.
  struct Samples {
    int x, y;
    auto operator<=>(const Samples&) const = default;
  };
  /// Light is tapered from `taper` of the field of view on.
  FocalGrid(const Samples& samples, double taper);
  ~FocalGrid();
  /// Those whose light has the pupil's autocorrelation at shears up to `end` [m].
  static Samples samples_for(const PupilCells& cells, double end);
  /// Those for the largest of its segments.
  static Samples samples_for_segments(const PupilCells& cells, double end);
  /// What leaves the light of a phase with such a steepest slope [cycles/m].
  static double taper_for(const PupilCells& cells, double steepest);

  double taper() const { return taper_; }
  double taper_end() const;
  double count() const { return double(samples_.x) * samples_.y; }
  int finest() const { return std::max(samples_.x, samples_.y); }  ///< of its steps rings are told in
  const LagTable& rings() const { return rings_; }                 ///< of samples, as far as the taper goes
  /// J0(2 pi distance x), x the columns. One that is asked for again is remembered.
  std::shared_ptr<const Eigen::MatrixXd> bessel(const Eigen::ArrayXd& x,
                                                const Eigen::ArrayXd& distance) const;
  /// Of each product p sum_k p[k] Re F_(last - k) F_k* over the samples of each ring: products x rings. F_i
  /// is of the field of the cells times the i-th power of their square, up to `powers_of_square`.
  Eigen::ArrayXXd ring_sums(const LitCells& cells, int powers_of_square,
                            const std::vector<std::vector<double>>& products) const;

 private:
  /// Of one call; kept from one to the next, as fresh memory takes as long as the transforms.
  struct Workspace;
  std::unique_ptr<Workspace> workspace() const;
  void columns_out(Eigen::Index rows, Workspace* work, std::vector<double>* kept) const;

  Samples samples_;
  double taper_;
  LagTable rings_;
  std::vector<int> kept_;  // rows of samples within the taper
  LinePlan<double> along_x_, along_y_;
  std::vector<double> no_shift_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;
  mutable Eigen::ArrayXd last_x_, last_distance_;
  mutable std::shared_ptr<const Eigen::MatrixXd> last_bessel_;
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
  };
  static std::vector<Product> products(int degree);
  /// Of a product: number k times u^(i + 2j - k) v^k.
  static std::vector<double> of_powers(const Product& product);

  int degree = 0;
  double outer = 0;          ///< [m]
  double edge = 0, end = 0;  ///< distances between which a taper falls from 1 to 0 [cycles/m]
  Eigen::MatrixXd mean;      ///< of a^i b^j over the aperture
  Eigen::ArrayXd within;     ///< of each product, summed over what the taper leaves
  /// At shears x [m], ascending: rows of the products' sums over the light that the taper leaves, of
  /// J0(2 pi distance x); all light 1.
  std::function<Eigen::ArrayXXd(const Eigen::ArrayXd& x)> sums;

  /// The same in all directions: of any field. The grids must outlive it. `of_segments` is for segments that
  /// err. Two points of two segments keep the product of the means of their fields, two of one segment what
  /// its tilt leaves: of all pairs with the first, those of each segment are taken off and added with the
  /// second.
  static PupilLight of_cells(const PupilCells& cells, const FocalGrid& grid, const FocalGrid* of_segments,
                             int degree, double dz);
  /// Of a round field, by Hankel transforms: far out of focus, where cells would be too many.
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
  /// At shears x [m], ascending: rows of moments at the basis' nodes, i major.
  Eigen::ArrayXXd operator()(const Eigen::ArrayXd& x) const;
  /// Of the whole aperture, from means of a^i b^j.
  static Eigen::ArrayXd whole(const Eigen::MatrixXd& mean, const MomentBasis& basis);
  /// Shear that panels of kPanelNodes resolve [m].
  double resolved() const;

 private:
  Eigen::MatrixXd monomials(const Eigen::ArrayXd& sums, double shear2) const;

  PupilLight light_;
  const MomentBasis& basis_;
  std::vector<PupilLight::Product> products_;
};

}  // namespace aberfit::internal
