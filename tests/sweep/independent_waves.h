#pragma once
#include <complex>
#include <functional>
#include <vector>

#include "aberfit/scene/aperture.h"
#include "independent_surface.h"

namespace aberfit {

/// PSF of a surface near a parabola, written anew for the tests. It shares only the outline of the aperture
/// with the library. The pupil is sampled uniformly in f times the direction cosine (PHYSICS 6,
/// aperture-exact: not paraxial at any f-number). Heights are path differences to first order, each plane is
/// one padded FFT, encircled energies are along circles. Good to a few 1e-4 of the energy if the grid
/// resolves the phase.
class IndependentWaves {
 public:
  /// cells: grid points across the aperture. Lengths in [m].
  IndependentWaves(double focal_length, const Aperture& aperture, double wavelength,
                   const IndependentSurface& surface, int cells);
  ~IndependentWaves();
  IndependentWaves(const IndependentWaves&) = delete;
  IndependentWaves& operator=(const IndependentWaves&) = delete;

  /// Adds roughness to the terms by its mean effect. S(f) [m^4] between two frequencies [cycles/m], with
  /// Gaussian heights; its factor on the transfer function is averaged over the aperture for each direction
  /// of the shear.
  void scatter(const std::function<double(double)>& psd, double f_min, double f_max);

  /// Fractions of the energy through the aperture inside circles about the axis, in the plane z = f + dz.
  std::vector<double> shares(double dz, const std::vector<double>& radii);

 private:
  struct Cell {
    int column, row;
    double amplitude, phase, versine;
  };
  double power(int column, int row) const;
  double on_circle(double r) const;
  void apply_scatter();

  double focal_length_, wavelength_, pitch_, total_ = 0;
  int samples_;
  std::vector<Cell> cells_;
  // Factor on the transfer function, by direction of the shear, in steps of an eighth of the pitch; empty: 1.
  static constexpr int kShearDirections = 32;
  std::vector<std::vector<double>> factor_;
  double rim_ = 0;  // t there
  std::complex<double>* field_;
  void* plan_;
};

}  // namespace aberfit
