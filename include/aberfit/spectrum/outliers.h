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
  Mask found;  ///< mask of the shape of the data; nothing marked if there are too few samples
  Eigen::Index count = 0;
  Eigen::Index tested = 0;  ///< valid samples
  double threshold = 0;     ///< limit for the nearest neighbours, in standard deviations of their residual
};

/// Finds samples that stand out of their neighbourhood. Each sample is compared with the median prediction of
/// pairs of neighbours on opposite sides, at distances of 1, 2, 4, 8 (profiles also 16) samples. In maps the
/// pairs lie along rows, columns and both diagonals; in profiles at one, two and three distances. Slope
/// therefore cancels, and one bad neighbour does no harm.
/// The standard deviation of the residual is 1.4826 times its median size. A tile uses its own median if that
/// is larger than the median of the whole data, because real noise varies over the surface. The PSD is not
/// used, because outliers raise it.
/// The limit is Student's t that Gaussian data exceed in one of 200 measurements (degrees of freedom: 0.37 of
/// the independent residuals, the efficiency of the median). A sample is kept if it continues one side, as at
/// a step, or if its region has no edge, as at a turned-down rim.
/// Outliers are removed and the search is repeated, with 3.5 standard deviations beside them, so that damaged
/// regions up to about 8 samples across are found whole. At the rim, lines are extrapolated from inside.
/// Slope profiles are tested as slopes; heights integrated from them lose the removed samples.
/// No false alarm on 500 clean Gaussian surfaces of 2-D exponents 0 to 4. Rejection of 1 % of spikes of ten
/// standard deviations restores RMS height and slope to 2 % (tests/spectrum/outliers_test.cpp). Not tested:
/// fewer than 32 valid samples, profiles below 25 and maps below 9 samples a side.
Outliers find_outliers(const Profile& profile);
Outliers find_outliers(const HeightMap& map);

/// Treatment of outliers.
enum class OutlierTreatment {
  kWarn,    ///< keep them, with the warning `outliers`
  kReject,  ///< make them invalid, with the warning `outliers-rejected`
  kKeep,    ///< do not search for them
};

/// Treats the outliers of a measurement and checks whether its size is plausible for a mirror. `detrend`:
/// shape subtracted for the RMS values in the warnings. Warnings: `outliers` or `outliers-rejected` with
/// number and effect on RMS slope and height; `unusual` for a record or map diagonal outside 0.1 um to 50 m,
/// heights without a parabola above 1 % of it, or slopes above 1 rad.
Warnings screen(Measurement* data, OutlierTreatment treatment, const DetrendOptions& detrend);

}  // namespace aberfit
