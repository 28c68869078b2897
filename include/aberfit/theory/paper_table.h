#pragma once
#include <string>
#include <vector>

#include "aberfit/theory/regime.h"

namespace aberfit {

/// Ranges of the paper's table of R, one cell for each combination. Defaults: its own 36 cells at its 500 nm.
struct PaperTable {
  std::vector<double> rms_heights = {1e-9, 10e-9, 100e-9, 1e-6};    ///< sigma [m], > 0
  std::vector<double> correlation_lengths = {1e-6, 10e-6, 100e-6};  ///< l_c = int C/C(0) dr [m], > 0
  std::vector<double> diameters = {0.2, 0.5, 1.0};                  ///< D [m], > 0
  double wavelength = 500e-9;                                       ///< [m], > 0
};

/// One combination of the ranges with both verdicts.
struct PaperCell {
  double rms_height = 0, correlation_length = 0, diameter = 0;  ///< [m]
  double ratio = 0;                                             ///< R = 2 sigma D/(1.22 lambda l_c)
  double g = 0, kappa = 0;                                      ///< as in SceneNumbers
  double ray_ee90_error = 0;               ///< ray ee90 over that of GHS - 1; NaN or infinite: none
  FocusModel needed = FocusModel::kWaves;  ///< by choose_model
  double wide_share = 0;                   ///< of the light, scattered beyond kSmallAngle
};

/// Scatter angle [rad] up to which the theories here, of small angles, are trusted (PHYSICS 6), and the share
/// of the light that may lie beyond.
inline constexpr double kSmallAngle = 10 * 0.017453292519943295;
inline constexpr double kWideShare = 1e-3;

/// Share of the light that a surface of RMS height `sigma` [m] and Gaussian autocorrelation
/// C = sigma^2 exp(-(x/length)^2) scatters beyond `angle` [rad], by generalised Harvey-Shack: the transfer
/// function exp(-g^2 (1 - C/sigma^2)) is the Poisson sum exp(-g^2) g^(2n)/n! exp(-n (x/length)^2), whose
/// terms scatter as Gaussians, exp(-(pi length sin(angle)/wavelength)^2/n) of each beyond. All of it beyond
/// 90 degrees is counted as scattered.
double gaussian_share_beyond(double sigma, double length, double wavelength, double angle);

/// The table in numbers.
struct PaperCells {
  double wavelength = 0;         ///< [m]
  std::vector<PaperCell> cells;  ///< by diameter, then RMS height, then correlation length
};

/// R from which the paper's "R much larger than 1" is taken to hold.
inline constexpr double kPaperRatioForRays = 10;

/// The paper's verdict in a word: "rays", "waves" (R < 1), or "unclear" in between.
std::string paper_verdict(double ratio);

/// R = 2 sigma D/(1.22 lambda l_c) over the ranges, with kappa, g and both verdicts per cell. The surface of
/// a cell has a Gaussian autocorrelation of that correlation length, l_c = int C/C(0) dr, on a parabola of
/// `focal_length` [m] - on which neither R nor the verdict depends while angles are small.
PaperCells paper_cells(const PaperTable& ranges, double focal_length);

}  // namespace aberfit
