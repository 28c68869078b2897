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

/// What the planes of a mirror have in common on one pupil grid: cells, their phase without defocus, the mean
/// transfer function of the roughness, transforms to twice the size of the pupil.
class AdjointGrid {
 public:
  AdjointGrid(const SpreadProblem& problem, int cells);

  /// Cells across the aperture that the plane needs: two for each cycle across that a disc sees in first
  /// order, up to twice those which the wave's own phase turns through, and no fewer than 64; at most 512,
  /// where the largest frequencies are lost.
  static int cells_for(const SpreadProblem& problem, double dz);

  /// Phase of the mirror without roughness in a plane [rad], one per pupil point; all zero where light
  /// from everywhere arrives in phase.
  Eigen::ArrayXd phase(double dz) const;
  const DiffractionPupil& pupil() const { return pupil_; }
  double focal_length() const { return focal_length_; }
  double wavelength() const { return wavelength_; }
  double pitch() const { return pupil_.pitch_x; }  ///< of P [m]
  int side() const { return side_; }               ///< of the transforms
  std::size_t place(Eigen::Index point) const { return place_[std::size_t(point)]; }
  const FourierTransform& transform() const { return transform_; }
  /// Mean transfer function of the roughness at a shear of `cells` pitches.
  double transfer(double cells) const;
  /// J0(2 pi f d) of distances d = bin * pitch / kBinsPerCell over the frequencies: bins x frequencies. 0 for
  /// frequencies that the cells do not carry.
  const Eigen::MatrixXd& bessel() const { return bessel_; }
  void set_frequencies(const Eigen::ArrayXd& frequency);
  /// Distances of a corner's lags (i, j), j <= i <= side/2, at i (i + 1)/2 + j [cells].
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

/// Light in discs of one plane, and how it answers to heights.
class HeightAdjoint {
 public:
  HeightAdjoint(const AdjointGrid& grid, double dz);
  /// Whether the answer to heights is zero to first order.
  bool is_flat() const { return flat_; }
  /// Mean over directions of |int dE/dh(P) exp(-2 pi i f.P) d2P|^2 [m^-2] at the frequencies of the grid,
  /// frequencies x discs. radius [m].
  Eigen::ArrayXXd power(const std::vector<double>& radius) const;
  /// Covariance of the light in discs on account of heights of this PSD, to first order: discs x discs, of
  /// the frequencies that the grid holds.
  Eigen::MatrixXd covariance(const std::vector<double>& radius, const RadialPsd& psd) const;
  /// Transfer function without roughness at shears of 0, 1, 2, ... cells, averaged over direction.
  Eigen::ArrayXd transfer_function() const;

 private:
  // Two discs at a time: what is real of both is one complex transform.
  ComplexGrid kernels(double first, double second) const;
  ComplexGrid responses(double first, std::optional<double> second) const;  // dE/dh, likewise
  Eigen::MatrixXd autocorrelations(ComplexGrid responses) const;

  const AdjointGrid& grid_;
  double dz_;
  bool flat_;
  ComplexGrid field_, transform_;  // on the pupil's cells within the larger grid
};

}  // namespace aberfit::internal
