#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/spectrum/ordinate_bins.h"
#include "aberfit/terms/surface_spectrum.h"

namespace aberfit {
namespace {

using GridMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Total degree of the polynomial that detrending subtracts from a map; -1: none.
int detrend_degree(const DetrendOptions& options) {
  if (options.shape == DetrendShape::kNone) return -1;
  if (options.shape == DetrendShape::kEllipse) return 2;
  if (options.degree < 0) throw std::invalid_argument("the degree of detrending must be 0 or more");
  return options.degree;
}

// Polynomials of degree 0 .. degree, orthonormal on n equidistant points: n x (degree + 1).
Eigen::MatrixXd orthonormal_polynomials(int n, int degree) {
  if (degree < 0) return Eigen::MatrixXd(n, 0);
  if (degree >= n)
    throw std::invalid_argument("detrending of such a high degree leaves nothing of such a small grid");
  const Eigen::ArrayXd t = (2 * Eigen::ArrayXd::LinSpaced(n, 0, n - 1) - (n - 1)) / std::max(1, n - 1);
  // The columns of Q span the same spaces as the first columns of the polynomials, degree by degree.
  return orthonormal_columns(legendre_polynomials(t, degree + 1).matrix());
}

// The linear steps of the PSD estimator of maps (psd_estimate.h) on a full square grid, with their adjoints.
// A test compares them with the estimator itself.
//
// Values: psd_b = scale/members_b sum over k in b of |F(w P z)_k|^2, with z = L c the surface on the grid, P
// the projection away from polynomials (orthonormal on the full grid, so symmetric), w the window.
// Derivative: d psd_b/dz = scale/members_b P w 2 Re F(conj(F_k) on b, 0 elsewhere), then L^T.
class EstimatedSpectrum : public SurfaceSpectrum {
 public:
  EstimatedSpectrum(const TermSet& terms, const PsdEstimatorOptions& options, int points, double pitch,
                    int threads)
      : n_(points),
        window_(window_values(options.window, points)),
        shapes_(orthonormal_polynomials(points, detrend_degree(options.detrend))),
        bins_(logarithmic_bins({points, points, 1 / (points * pitch), 1 / (points * pitch)},
                               options.bins_per_decade, {})),
        surface_(on_grid(terms, points, pitch, threads)) {
    const double squares = window_.square().sum();
    scale_ = pitch * pitch / (squares * squares);
  }

  const OrdinateBins& edges() const { return bins_; }
  Eigen::Index bins() const override { return bins_.size(); }

  void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                Eigen::MatrixXd* jacobian) const override {
    SurfaceField field;
    surface_.apply(coefficients, &field);
    GridMatrix samples = Eigen::Map<const GridMatrix>(field.height.data(), n_, n_);
    detrend(&samples);
    apply_window(&samples);
    std::vector<std::complex<double>> transformed(samples.data(), samples.data() + n_ * n_);
    fourier_transform(n_, n_, transformed.data());
    values->setZero(bins());
    for (std::size_t k = 0; k < transformed.size(); ++k)
      if (bins_.of[k] >= 0) (*values)[bins_.of[k]] += std::norm(transformed[k]);
    *values = (scale_ * values->array() / (2 * bins_.count)).matrix();
    if (!jacobian) return;
    jacobian->resize(bins(), coefficients.size());
    SurfaceField weights;
    weights.resize(n_ * n_);
    weights.slope_x.setZero();
    weights.slope_y.setZero();
    std::vector<std::complex<double>> part(transformed.size());
    for (Eigen::Index b = 0; b < bins(); ++b) {
      for (std::size_t k = 0; k < part.size(); ++k)
        part[k] = bins_.of[k] == b ? std::conj(transformed[k]) : 0.0;
      fourier_transform(n_, n_, part.data());
      for (std::size_t k = 0; k < part.size(); ++k) samples.data()[k] = part[k].real();
      apply_window(&samples);
      detrend(&samples);
      weights.height =
          scale_ / bins_.count[b] * Eigen::Map<const Eigen::ArrayXd>(samples.data(), samples.size());
      jacobian->row(b) = surface_.apply_transpose(weights).transpose();
    }
  }

 private:
  static SurfaceOperator on_grid(const TermSet& terms, int points, double pitch, int threads) {
    Eigen::ArrayXd x(points * points), y(points * points);
    for (int row = 0; row < points; ++row)
      for (int column = 0; column < points; ++column) {
        x[row * points + column] = (column - 0.5 * (points - 1)) * pitch;
        y[row * points + column] = (row - 0.5 * (points - 1)) * pitch;
      }
    return SurfaceOperator(terms, std::move(x), std::move(y), threads);
  }

  void detrend(GridMatrix* z) const {
    const Eigen::Index degree = shapes_.cols() - 1;
    if (degree < 0) return;
    Eigen::MatrixXd content = shapes_.transpose() * *z * shapes_;
    for (Eigen::Index i = 0; i <= degree; ++i)
      for (Eigen::Index j = degree + 1 - i; j <= degree; ++j) content(i, j) = 0;  // keeps i + j <= degree
    *z -= shapes_ * content * shapes_.transpose();
  }

  void apply_window(GridMatrix* z) const {
    z->array().colwise() *= window_;
    z->array().rowwise() *= window_.transpose();
  }

  int n_;
  Eigen::ArrayXd window_;
  Eigen::MatrixXd shapes_;
  OrdinateBins bins_;  // members: count, and as many conjugates
  SurfaceOperator surface_;
  double scale_ = 0;
};

}  // namespace

std::unique_ptr<SurfaceSpectrum> estimated_spectrum(const TermSet& terms, const PsdEstimatorOptions& options,
                                                    int grid_size, int threads, Eigen::ArrayXd* low,
                                                    Eigen::ArrayXd* high) {
  if (!(terms.radius > 0)) throw std::invalid_argument("the square must lie in a disc of positive radius");
  if (grid_size < 4) throw std::invalid_argument("a spectrum needs a grid of at least 4 x 4 points");
  const double pitch = std::sqrt(2.0) * terms.radius / grid_size;
  // This is the size to which the estimator cuts a map.
  auto spectrum =
      std::make_unique<EstimatedSpectrum>(terms, options, int(smooth_up_to(grid_size)), pitch, threads);
  *low = spectrum->edges().low;
  *high = spectrum->edges().high;
  return spectrum;
}

}  // namespace aberfit
