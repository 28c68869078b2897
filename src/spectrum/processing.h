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

/// Rows by columns of the windowed samples.
using ComplexGrid = Eigen::Array<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What a surface goes through on its way to the Fourier transform, for one geometry: sampling, integration
/// of slopes, detrending, bridging of holes, resampling, window. All but the ellipse is linear, so that the
/// way of a plane wave tells the way of every surface.
class SurfaceProcessing {
 public:
  virtual ~SurfaceProcessing() = default;
  /// Windowed samples of the surface exp(2 pi i (u step_x x + v step_y y)).
  virtual ComplexGrid wave(double u, double v) const = 0;
  /// Its discrete Fourier transform.
  virtual ComplexGrid wave_transform(double u, double v) const;

  OrdinateGrid grid;
  Eigen::ArrayXd window_x, window_y;  ///< window_y is a single 1 for a profile

  /// sum over samples of the squared window.
  double window_power() const { return window_x.square().sum() * window_y.square().sum(); }
  /// |transform|^2 of windowed samples.
  Eigen::ArrayXd power(ComplexGrid windowed) const;
  void apply_window(ComplexGrid* samples) const;

 protected:
  void prepare(WindowKind window);  ///< once `grid` is known

 public:
  std::unique_ptr<FourierTransform> transform;
  /// Per ordinate, what its amplitude is multiplied by to undo the integration of slopes; empty: nothing to
  /// undo.
  Eigen::ArrayXd restored;

 private:
  void transform_and_restore(ComplexGrid* windowed) const;
};

/// Samples of an even grid of about that pitch over ascending positions, two or more. Throws
/// std::invalid_argument naming the widest gap where there are more than 2^26.
int even_samples(const Eigen::ArrayXd& x, double pitch);

class ProfileProcessing : public SurfaceProcessing {
 public:
  ProfileProcessing(const Profile& geometry, const PsdEstimatorOptions& options);
  ComplexGrid wave(double u, double v) const override;
  /// Windowed samples of heights that are detrended already.
  ComplexGrid windowed(const Profile& detrended_heights) const;

 private:
  void undo_integration();
  ComplexGrid bridged(const Eigen::VectorXcd& valid_heights) const;

  ProfileQuantity quantity_;
  std::vector<Eigen::Index> valid_;
  Eigen::ArrayXd x_;       // of the valid samples, from the first
  Eigen::MatrixXd basis_;  // orthonormal shapes to take off, valid x count
  struct Knot {
    double x;
    Eigen::Index left;
    double share;  // of sample left + 1
  };
  std::vector<Knot> knots_;  // valid samples and stand-ins for the missing ones
  bool even_ = true;
  double pitch_ = 0;
};

class MapProcessing : public SurfaceProcessing {
 public:
  MapProcessing(const HeightMap& geometry, const PsdEstimatorOptions& options);
  ComplexGrid wave(double u, double v) const override;
  ComplexGrid wave_transform(double u, double v) const override;
  /// The part of the map that is estimated from: largest rectangle inside its outline.
  HeightMap region(const HeightMap& map) const;
  /// Windowed samples of a region that is detrended already.
  ComplexGrid windowed(const HeightMap& detrended_region) const;

 private:
  void bridge(ComplexGrid* samples) const;
  // x(i) y(j) - sum_ab shape(a, b) P_a(i) P_b(j): a detrended wave, holes apart.
  struct Separable {
    Eigen::VectorXcd x, y;
    Eigen::MatrixXcd shape;
  };
  Separable separable(double u, double v) const;

  Eigen::Index row_ = 0, column_ = 0;
  std::vector<int> holes_;  // places in the grid
  struct Link {
    int hole, from;  // index in holes_, place in the grid
    double weight;
  };
  std::vector<Link> links_;  // valid neighbours of the holes
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> laplacian_;
  Eigen::MatrixXd across_, down_;  // Legendre polynomials of the columns and of the rows
  std::vector<std::pair<int, int>> products_;
  Eigen::MatrixXd inverse_gram_;
  std::unique_ptr<FourierTransform> along_x_, along_y_;
  Eigen::MatrixXcd across_transform_, down_transform_;  // of the windowed polynomials
};

/// Rectangle of whole pixels.
struct PixelRectangle {
  Eigen::Index row = 0, column = 0, rows = 0, columns = 0;
};
/// Largest axis-aligned rectangle inside the outline of the valid points: holes that do not reach the border
/// of the valid area count as inside, unless one takes more than 5 % of the rectangle.
PixelRectangle largest_inner_rectangle(const HeightMap& map);

}  // namespace aberfit::internal
