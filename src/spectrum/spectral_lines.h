#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"
#include "periodogram.h"

namespace aberfit::internal {

struct LineSearch {
  std::vector<SpectralLine> lines;  ///< strongest first
  std::vector<char> left_out;       ///< ordinates that belong to them; empty without lines
};

/// Ordinates that stand out of the continuum. ordinate: periodogram of the whole grid, one-sided [m^3] or
/// two-sided [m^4]; node_frequency, transfer: power that arrives of a wave, which the RMS is corrected by;
/// correlation: sum over ordinates of |W2|^2 along one axis.
/// The continuum is a running median over neighbours after a piecewise power law is taken out; its own
/// uncertainty goes into the false-alarm probability (F distribution). Lines are looked for from the eighth
/// ordinate on: below, figure and lines cannot be told apart.
LineSearch find_lines(const OrdinateGrid& grid, const Eigen::ArrayXd& ordinate, int lobe_half,
                      double correlation, const Eigen::ArrayXd& node_frequency,
                      const Eigen::ArrayXd& transfer);

}  // namespace aberfit::internal
