#pragma once
#include <Eigen/Core>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/spectrum/detrend.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit {

/// Structure function of a measured surface, D(s) = <(h(x + s) - h(x))^2>: what a telescope mirror is
/// specified in.
struct HeightDifferences {
  Eigen::ArrayXd separation;   ///< s [m], ascending, a dozen a decade, to half the (shorter) side
  Eigen::ArrayXd mean_square;  ///< D(s) [m^2]
  Eigen::ArrayXd pairs;        ///< valid points that were compared; never 0
};

/// Of the surface with its shape taken off, over the pairs of points that are both valid. Slopes are
/// integrated first, by the trapezoid rule, which leaves (x cot x)^2, x = pi f pitch, of a wave: D at one to
/// three pitches is up to a fifth too low where slopes are white. An uneven pitch is interpolated linearly
/// where no sample is missing, which takes differences of neighbours off where the surface is rough between
/// them. What detrending takes off is missing at large separations: a record of length L follows its surface
/// to about L/10.
HeightDifferences height_differences(const Profile& measured, const DetrendOptions& detrend);
/// Mean over all directions, each pair of points once: pairs whose distance is within a tenth of a separation
/// (at most half a pitch), of which `separation` is the mean. Correlations of heights and of the mask by FFT;
/// rounding leaves 1e-15 of the height variance. Takes 72 bytes a point. Throws std::invalid_argument when
/// the pitch is unknown.
HeightDifferences height_differences(const HeightMap& measured, const DetrendOptions& detrend);

/// D(s) [m^2] of a fitted model at separations [m], of what it has inside the band of the fit. Profiles: 2
/// int S1(f) (1 - cos 2 pi f s) df of PsdModelFit::curve, to 1e-3. Maps: 4 pi int S f (1 - J0(2 pi f s)) df.
Eigen::ArrayXd model_height_differences(const PsdModelFit& fit, PsdTableKind kind,
                                        const Eigen::ArrayXd& separation);

}  // namespace aberfit
