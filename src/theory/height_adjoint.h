#pragma once
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <vector>

#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/theory/realisation_spread.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

using ComplexGrid = std::vector<std::complex<double>>;

/// Data of all planes of a mirror on one pupil grid: the grid points, their phase without defocus, the mean
/// transfer function of the roughness, and transforms of twice the size of the pupil.
class AdjointGrid {
 public:
  AdjointGrid(const SpreadProblem& problem, int cells);

  /// Grid points across the aperture that the plane needs: two for each cycle across that affects a disc to
  /// first order. The highest of these has twice the frequency of the wave's own phase. At least 64, at most
  /// 512.
  static int cells_for(const SpreadProblem& problem, double dz);

  /// Phase of the mirror without roughness in a plane [rad], one per pupil point; all zero in a perfect
  /// focus.
  Eigen::ArrayXd phase(double dz) const;
  const DiffractionPupil& pupil() const { return pupil_; }
  double focal_length() const { return focal_length_; }
  double wavelength() const { return wavelength_; }
  double pitch() const { return pupil_.pitch_x; }  ///< of P [m]
  int side() const { return side_; }               ///< number of samples of the transforms along one side
  std::size_t place(Eigen::Index point) const { return place_[std::size_t(point)]; }
  const FourierTransform& transform() const { return transform_; }
  /// Mean transfer function of the roughness at a shear of `cells` pitches.
  double transfer(double cells) const;
  /// J0(2 pi f d), d = bin * pitch / kBinsPerCell: bins x frequencies. 0 for f too high for the grid.
  const Eigen::MatrixXd& bessel() const { return bessel_; }
  void set_frequencies(const Eigen::ArrayXd& frequency);
  /// Distances of a corner's lags (i, j), j <= i <= side/2, at index i (i + 1)/2 + j [grid cells].
  const Eigen::ArrayXd& distance() const { return distance_; }

 private:
  double focal_length_, wavelength_;
  DiffractionPupil pupil_;
  int side_;
  FourierTransform transform_;
  Eigen::ArrayXd departure_;  // phase [rad]
  Eigen::ArrayXd transfer_, distance_;
  Eigen::MatrixXd bessel_;
  std::vector<std::size_t> place_;
};

/// Energy in discs of one plane and its response to heights.
class HeightAdjoint {
 public:
  HeightAdjoint(const AdjointGrid& grid, double dz);
  /// True if the response to heights is zero to first order.
  bool is_flat() const { return flat_; }
  /// Mean over directions of |int dE/dh(P) exp(-2 pi i f.P) d2P|^2 [m^-2] at the frequencies of the grid,
  /// frequencies x discs. radius [m].
  Eigen::ArrayXXd power(const std::vector<double>& radius) const;
  /// First-order covariance of the energy in discs from heights with this PSD on the grid: discs x discs.
  Eigen::MatrixXd covariance(const std::vector<double>& radius, const RadialPsd& psd) const;
  /// Transfer function without roughness at shears of 0, 1, 2, ... grid cells, averaged over direction.
  Eigen::ArrayXd transfer_function() const;

 private:
  // Two discs at a time: their real kernels fit into one complex transform.
  ComplexGrid kernels(double first, double second) const;
  ComplexGrid responses(double first, std::optional<double> second) const;  // dE/dh, in the same form
  Eigen::MatrixXd autocorrelations(ComplexGrid responses) const;

  const AdjointGrid& grid_;
  double dz_;
  bool flat_;
  ComplexGrid field_, transform_;  // on the pupil's points within the larger grid
};

}  // namespace aberfit::internal
