#pragma once
#include <Eigen/Core>
#include <string>

#include "aberfit/core/warning.h"
#include "aberfit/measured/masking.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/spectrum/detrend.h"

namespace aberfit {

/// Samples that do not belong to the surface: spikes of an interferometer, dust, damaged regions.
struct Outliers {
  Mask found;  ///< of the shape of the data; none where too few samples were there to tell
  Eigen::Index count = 0;
  Eigen::Index tested = 0;  ///< valid samples
  double threshold = 0;     ///< of the nearest neighbours, in standard deviations of their residual
};

/// Samples that stand out of their neighbourhood. At distances of 1, 2, 4, 8 (profiles also 16) samples each
/// is compared with the median of what pairs of neighbours on opposite sides make of its place (maps: along
/// rows, columns and both diagonals; profiles: at one, two and three distances), so that slope drops out and
/// one bad neighbour does no harm. The residual's standard deviation is 1.4826 times its median size: of the
/// whole data, and of a tile where that is larger, because real noise is not the same everywhere. It is not
/// taken from the PSD, which the outliers raise before they are known. Outliers are beyond Student's t that
/// Gaussian data exceed in one of 200 measurements (degrees of freedom: 0.37 of the independent residuals,
/// the efficiency of the median). Not outliers are continuations of one side, as both sides of a step are,
/// and regions without an edge, as a turned-down rim. What is found is left out and the search is repeated;
/// beside it 3.5 standard deviations are enough, so that damaged regions are found whole, up to about 8
/// samples across. At the rim, where pairs lack one end, lines are continued from inside. Slope profiles are
/// tested as slopes; what is lost of them is lost to the heights integrated from them.
/// No alarm on 500 clean Gaussian surfaces of 2-D exponents 0 to 4; 1 % of spikes ten standard deviations
/// high rejected, RMS height and slope within 2 % (tests/spectrum/outliers_test.cpp). Fewer than 32 valid
/// samples, profiles below 25 and maps below 9 samples a side are not tested.
Outliers find_outliers(const Profile& profile);
Outliers find_outliers(const HeightMap& map);

/// What becomes of outliers.
enum class OutlierTreatment {
  kWarn,    ///< they stay, with the warning `outliers`
  kReject,  ///< they become holes, with the warning `outliers-rejected`
  kKeep,    ///< nobody looks for them
};

/// Treats the outliers of a measurement, and looks whether its size is that of a mirror. `detrend`: what is
/// taken off for the RMS values that the warnings quote. Warnings: `outliers` or `outliers-rejected` with the
/// number and the effect on RMS slope and height; `unusual` where the record or a map's diagonal is shorter
/// than 0.1 um or longer than 50 m, heights without a parabola span more than 1 % of it, or slopes exceed
/// 1 rad.
Warnings screen(Measurement* data, OutlierTreatment treatment, const DetrendOptions& detrend);

}  // namespace aberfit
