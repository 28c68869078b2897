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

/// Finds ordinates above the continuum. ordinate: periodogram of the whole grid, one-sided [m^3] or two-sided
/// [m^4]; node_frequency, transfer: fraction of the power of a wave that passes the processing, which
/// corrects the RMS; correlation: sum over ordinates of |W2|^2 along one axis.
/// The continuum is a running median over neighbours after division by a piecewise power law. Its uncertainty
/// is part of the false-alarm probability (F distribution). The search starts at the eighth ordinate, because
/// below it figure and lines cannot be distinguished.
LineSearch find_lines(const OrdinateGrid& grid, const Eigen::ArrayXd& ordinate, int lobe_half,
                      double correlation, const Eigen::ArrayXd& node_frequency,
                      const Eigen::ArrayXd& transfer);

}  // namespace aberfit::internal
