#pragma once
#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// How many neighbours share one residual: the sum of its autocorrelation over the lags between points, from
/// lag 0 (which gives 1) outwards ring by ring to the ring where its mean is no longer positive.
/// residual: 0 where there is no point, so that the sum of products over a lag, divided by the sum of
/// squares, is correlation times the share of points that have a partner there: holes and edges are allowed
/// for. Error: the autocorrelation of residuals is low by about terms / (independent points) of the variance,
/// as the fit takes part of the noise along; a correlation that reaches beyond a first zero (ripples) is cut.
double correlated_neighbours(const Grid& residual, double pitch_x, double pitch_y, int threads);

}  // namespace aberfit::internal
