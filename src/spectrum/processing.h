#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <complex>
#include <memory>
#include <vector>

#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "periodogram.h"

namespace aberfit::internal {

using ComplexGrid = Eigen::Array<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The processing of a surface before the Fourier transform, for one geometry: sampling, integration of
/// slopes, detrending, bridging of holes, resampling, window. All but the ellipse is linear.
class SurfaceProcessing {
 public:
  virtual ~SurfaceProcessing() = default;
  /// Returns the windowed samples of the surface exp(2 pi i (u step_x x + v step_y y)).
  virtual ComplexGrid wave(double u, double v) const = 0;
  /// Returns the discrete Fourier transform of `wave`.
  virtual ComplexGrid wave_transform(double u, double v) const;

  OrdinateGrid grid;
  Eigen::ArrayXd window_x, window_y;  ///< window_y is a single 1 for a profile

  /// Returns the sum over samples of the squared window.
  double window_power() const { return window_x.square().sum() * window_y.square().sum(); }
  /// Returns |transform|^2 of windowed samples.
  Eigen::ArrayXd power(ComplexGrid windowed) const;
  void apply_window(ComplexGrid* samples) const;

 protected:
  void prepare(WindowKind window);  ///< requires `grid`

 public:
  std::unique_ptr<FourierTransform> transform;
  /// Factor for the amplitude of each ordinate that undoes the integration of slopes; empty: none.
  Eigen::ArrayXd restored;

 private:
  void transform_and_restore(ComplexGrid* windowed) const;
};

/// Returns the number of samples, at least 2, of an even grid of about that pitch over ascending positions.
/// Throws std::invalid_argument that names the widest gap if there are more than 2^26.
int even_samples(const Eigen::ArrayXd& x, double pitch);

class ProfileProcessing : public SurfaceProcessing {
 public:
  ProfileProcessing(const Profile& geometry, const PsdEstimatorOptions& options);
  ComplexGrid wave(double u, double v) const override;
  /// Returns the windowed samples of detrended heights.
  ComplexGrid windowed(const Profile& detrended_heights) const;

 private:
  void undo_integration();
  ComplexGrid bridged(const Eigen::VectorXcd& valid_heights) const;

  ProfileQuantity quantity_;
  std::vector<Eigen::Index> valid_;
  Eigen::ArrayXd x_;       // positions of the valid samples, relative to the first
  Eigen::MatrixXd basis_;  // orthonormal shapes to subtract, valid x count
  struct Knot {
    double x;
    Eigen::Index left;
    double share;  // weight of sample left + 1
  };
  std::vector<Knot> knots_;  // valid samples and substitutes for the missing ones
  bool even_ = true;
  double pitch_ = 0;
};

class MapProcessing : public SurfaceProcessing {
 public:
  MapProcessing(const HeightMap& geometry, const PsdEstimatorOptions& options);
  ComplexGrid wave(double u, double v) const override;
  ComplexGrid wave_transform(double u, double v) const override;
  /// Returns the part of the map that is used: the largest rectangle inside its outline.
  HeightMap region(const HeightMap& map) const;
  /// Returns the windowed samples of a detrended region.
  ComplexGrid windowed(const HeightMap& detrended_region) const;

 private:
  void bridge(ComplexGrid* samples) const;
  // A detrended wave without holes: x(i) y(j) - sum_ab shape(a, b) P_a(i) P_b(j).
  struct Separable {
    Eigen::VectorXcd x, y;
    Eigen::MatrixXcd shape;
  };
  Separable separable(double u, double v) const;

  Eigen::Index row_ = 0, column_ = 0;
  std::vector<int> holes_;  // indices in the grid
  struct Link {
    int hole, from;  // index in holes_, index in the grid
    double weight;
  };
  std::vector<Link> links_;  // valid neighbours of the holes
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> laplacian_;
  Eigen::MatrixXd across_, down_;  // Legendre polynomials of the columns and of the rows
  std::vector<std::pair<int, int>> products_;
  Eigen::MatrixXd inverse_gram_;
  std::unique_ptr<FourierTransform> along_x_, along_y_;
  Eigen::MatrixXcd across_transform_, down_transform_;  // transforms of the windowed polynomials
};

struct PixelRectangle {
  Eigen::Index row = 0, column = 0, rows = 0, columns = 0;
};
/// Returns the largest axis-aligned rectangle inside the outline of the valid points. Holes that do not reach
/// the border of the valid area count as inside, unless one takes more than 5 % of the rectangle.
PixelRectangle largest_inner_rectangle(const HeightMap& map);

/// The upper of the two in the middle; reorders the values, of which there must be one.
double median_of(std::vector<double>* values);

}  // namespace aberfit::internal
