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
#include "moment_panels.h"
#include "pupil_field.h"

namespace aberfit::internal {

/// Length of an aperture's edges times its largest diameter over its area; 4 for a circle.
double slenderness(const Aperture& aperture);
/// Grid points across an aperture for its edges: 1/50 of the energy is then beyond the taper.
double cells_for_edges(const Aperture& aperture);

/// The illuminated points of a grid, with their field.
struct LitCells {
  Eigen::Index columns = 0, rows = 0;
  std::vector<std::uint32_t> column, row;
  Eigen::ArrayXd amplitude, phase, square;  ///< phase [rad]; square: (|P| / outer)^2

  /// Selects the points of `cells`, with their columns and rows.
  LitCells part(const struct SegmentCells& cells) const;
};

/// The grid points of a segment, in the smallest rectangle that holds them.
struct SegmentCells {
  std::vector<Eigen::Index> number;
  std::vector<std::uint32_t> column, row;
  Eigen::Index columns = 0, rows = 0;
  double kept = 1;  ///< fraction of its energy if two points have independent errors
};

/// The field of a pupil on a grid, in any plane.
class PupilCells {
 public:
  /// cells: number of grid points across the circle about the aperture.
  PupilCells(const PupilField& field, int cells);
  /// Evenly illuminated, without aberration, over position instead of direction.
  PupilCells(const Aperture& aperture, int cells);

  const DiffractionPupil& pupil() const { return pupil_; }
  double pitch() const { return pupil_.pitch_x; }  ///< of P [m]
  Eigen::Index columns() const { return Eigen::Index(grid().x.size()); }
  Eigen::Index rows() const { return Eigen::Index(grid().y.size()); }
  double outer() const { return outer_; }  ///< [m]
  /// Means of a^i b^j over the mirror, i + j <= degree.
  Eigen::MatrixXd mean(int degree) const;
  /// Phase of each grid point in the plane f + dz [rad].
  Eigen::ArrayXd phase(double dz) const;
  /// Largest slope of that phase between neighbours [cycles/m].
  double steepest(double dz) const;
  LitCells lit(double dz) const;

  /// Segments with position errors; empty without errors.
  const std::vector<SegmentCells>& segments() const { return segments_; }
  /// The mean of each point's field over the errors of its segment, over the field without errors.
  const Eigen::ArrayXd& fade() const { return fade_; }
  /// Two points of one segment at a shear x keep exp(-decay x^2) of their coherence [1/m^2].
  double decay() const { return decay_; }
  double longest_in_a_segment() const { return longest_; }  ///< longest shear within a segment [m]
  /// The errors are only pistons, so the mean field is even over each segment.
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

/// The transform to the focal plane for pupils of one size, and its samples' radii. Thread-safe.
class FocalGrid {
 public:
  /// Number of samples along x and y, even.
  struct Samples {
    int x, y;
    auto operator<=>(const Samples&) const = default;
  };
  /// The taper of the irradiance begins at `taper` times the field of view.
  FocalGrid(const Samples& samples, double taper);
  ~FocalGrid();
  /// The samples that give the pupil's autocorrelation at shears up to `end` [m].
  static Samples samples_for(const PupilCells& cells, double end);
  /// The samples for the largest segment.
  static Samples samples_for_segments(const PupilCells& cells, double end);
  /// The taper that keeps the energy of a phase with this steepest slope [cycles/m].
  static double taper_for(const PupilCells& cells, double steepest);

  double taper() const { return taper_; }
  double taper_end() const;
  double count() const { return double(samples_.x) * samples_.y; }
  int finest() const { return std::max(samples_.x, samples_.y); }  ///< finest step, the unit of ring radii
  const LagTable& rings() const { return rings_; }                 ///< samples within the taper
  /// J0(2 pi distance x), one column per x. Keeps the last result.
  std::shared_ptr<const Eigen::MatrixXd> bessel(const Eigen::ArrayXd& x,
                                                const Eigen::ArrayXd& distance) const;
  /// Sums of each product p, sum_k p[k] Re F_(last - k) F_k*, over the samples of each ring: products x
  /// rings. F_i is the transform of the field times the i-th power of the point's square, i up to
  /// `powers_of_square`.
  Eigen::ArrayXXd ring_sums(const LitCells& cells, int powers_of_square,
                            const std::vector<std::vector<double>>& products) const;

 private:
  /// Memory of one call. It is kept for the next one, because fresh memory takes as long as the transforms.
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

/// The focal irradiance of a pupil over the distance from the axis, split by its origin in the pupil. For two
/// points P1 and P2 with u, v = (|P| / outer)^2 and a shear x (over outer), a is the square of the midpoint
/// and b the part of it along the shear:
///   a = (u + v)/2 - x^2/4, b = (u - v)^2/(4 x^2).
/// So moments of polynomials in a and b are sums of products F_i F_j* of functions of one point, with F_i the
/// transform of the field times u^i.
struct PupilLight {
  /// The polynomial ((u + v)/2)^i (u - v)^(2j).
  struct Product {
    int i, j;
  };
  static std::vector<Product> products(int degree);
  /// Coefficients of a product: element k belongs to u^(i + 2j - k) v^k.
  static std::vector<double> of_powers(const Product& product);

  int degree = 0;
  double outer = 0;          ///< [m]
  double edge = 0, end = 0;  ///< a taper falls from 1 to 0 between these distances [cycles/m]
  Eigen::MatrixXd mean;      ///< mean of a^i b^j over the aperture
  Eigen::ArrayXd within;     ///< sum of each product over the tapered irradiance
  /// Sums of the products with J0(2 pi distance x), tapered, for a total energy of 1. Each row belongs to one
  /// of the ascending shears x [m].
  std::function<Eigen::ArrayXXd(const Eigen::ArrayXd& x)> sums;

  /// Irradiance of any field, averaged over direction. The grids must outlive the result. `of_segments` is
  /// for segments with errors. Two points of different segments keep the product of their mean fields; two
  /// points of one segment keep what its tilt leaves. So the pairs within each segment are subtracted from
  /// the first sum and added again with the second rule.
  static PupilLight of_cells(const PupilCells& cells, const FocalGrid& grid, const FocalGrid* of_segments,
                             int degree, double dz);
  /// Irradiance of a round field by Hankel transforms; for planes far out of focus.
  static PupilLight of_rings(const PupilField& field, int degree, double dz);
};

/// The autocorrelation of a pupil's field, in the form of PupilOverlap:
///   moment_pq(x) = int A(P + x/2) A*(P - x/2) T_p(2a - 1) T_q(2b - 1) d2P / int |A|^2 d2P,
/// with p + q up to the degree of the irradiance data, averaged over the direction of the shear x. It is the
/// sum over the irradiance of J0(2 pi distance x). Energy beyond the taper comes from sharp edges alone and
/// falls with the cube of the distance; the missing amount is added with that law. Error against closed
/// forms: 1e-4 at every shear, 1e-5 from ten grid cells on, 5e-5 for encircled energies
/// (tests/theory/pupil_light_test.cpp).
class LightMoments {
 public:
  LightMoments(PupilLight light, const MomentBasis& basis);
  /// Moments at the nodes of the basis, i major. Each row belongs to one of the ascending shears x [m].
  Eigen::ArrayXXd operator()(const Eigen::ArrayXd& x) const;
  /// Moments of the whole aperture, from means of a^i b^j.
  static Eigen::ArrayXd whole(const Eigen::MatrixXd& mean, const MomentBasis& basis);
  /// Width in shear [m] that a panel of kPanelNodes resolves.
  double resolved() const;

 private:
  Eigen::MatrixXd monomials(const Eigen::ArrayXd& sums, double shear2) const;

  PupilLight light_;
  const MomentBasis& basis_;
  std::vector<PupilLight::Product> products_;
};

}  // namespace aberfit::internal
