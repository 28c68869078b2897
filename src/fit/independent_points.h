#pragma once
#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// Number of neighbours that share one residual. It is the sum of the residual's autocorrelation over the
/// lags between points, from lag 0 (which gives 1) outwards to the ring where its mean is no longer positive.
/// residual: 0 where there is no point. The sum of products over a lag, divided by the sum of squares, then
/// allows for holes and edges: it is the correlation times the fraction of points with a partner. The
/// autocorrelation of residuals is low by about terms / (independent points) of the variance, as the fit
/// removes part of the noise. Correlation beyond the first zero (ripples) is cut off.
double correlated_neighbours(const Grid& residual, double pitch_x, double pitch_y, int threads);

}  // namespace aberfit::internal
