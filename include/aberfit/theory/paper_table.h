#pragma once
#include <string>
#include <vector>

#include "aberfit/theory/regime.h"

namespace aberfit {

/// Ranges of the paper's table of R, one cell for each combination. Defaults: the cells whose R the paper
/// prints (1 nm, 1 um; 100 nm, 10 um), at its 500 nm.
struct PaperTable {
  std::vector<double> rms_heights = {1e-9, 10e-9, 100e-9};        ///< sigma [m], > 0
  std::vector<double> correlation_lengths = {1e-6, 10e-6, 1e-3};  ///< l_c = int C/C(0) dr [m], > 0
  std::vector<double> diameters = {0.2, 0.4, 0.5, 1.0};           ///< D [m], > 0
  double wavelength = 500e-9;                                     ///< [m], > 0
};

/// One combination of the ranges with both verdicts.
struct PaperCell {
  double rms_height = 0, correlation_length = 0, diameter = 0;  ///< [m]
  double ratio = 0;                                             ///< R = 2 sigma D/(1.22 lambda l_c)
  double g = 0, kappa = 0;                                      ///< as in SceneNumbers
  double ray_ee90_error = 0;               ///< ray ee90 over that of GHS - 1; NaN or infinite: none
  FocusModel needed = FocusModel::kWaves;  ///< by choose_model
};

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
