#pragma once
#include <Eigen/Core>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/spectrum/detrend.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit {

/// Structure function D(s) = <(h(x + s) - h(x))^2> of a measured surface, as in telescope specifications.
struct HeightDifferences {
  Eigen::ArrayXd separation;   ///< s [m], ascending, about 12 per decade, up to half the (shorter) side
  Eigen::ArrayXd mean_square;  ///< D(s) [m^2]
  Eigen::ArrayXd pairs;        ///< number of pairs of valid points; never 0
};

/// Structure function of a detrended profile, over all pairs of valid points. The trapezoid rule for slopes
/// passes the fraction (x cot x)^2, x = pi f pitch, of the power at f: for white slopes, D at one to three
/// pitches is up to a fifth too low. Uneven positions without missing samples are interpolated linearly,
/// which lowers D at small separations on a rough surface. Detrending lowers D at large separations: a record
/// of length L follows its surface to about L/10.
HeightDifferences height_differences(const Profile& measured, const DetrendOptions& detrend);
/// Structure function of a detrended map over all directions, each pair of points once. A separation collects
/// pairs within a tenth of it (at most half a pitch); `separation` is their mean. The FFT has a rounding
/// error of 1e-15 of the height variance and needs 72 bytes per point. Throws std::invalid_argument without a
/// pitch.
HeightDifferences height_differences(const HeightMap& measured, const DetrendOptions& detrend);

/// Returns D(s) [m^2] of a fitted model at separations [m], from its band. Profiles: 2 int S1(f) (1 - cos 2
/// pi f s) df of PsdModelFit::curve, relative error 1e-3. Maps: 4 pi int S f (1 - J0(2 pi f s)) df.
Eigen::ArrayXd model_height_differences(const PsdModelFit& fit, PsdTableKind kind,
                                        const Eigen::ArrayXd& separation);

}  // namespace aberfit
