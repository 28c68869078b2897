#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// Weights of the fitted points of a map, mean 1: one for the point's own cell, and for each hole among its
/// eight neighbours an equal share of that hole's cell. A hole is a cell without a known point inside the
/// closing of the known ones by 5 x 5 cells: dropouts and points kept back, not the surroundings. Figure
/// residuals are smooth, so a hole's residual is its neighbours'; with equal weights the coefficients would
/// move with every set of dropouts by the lost share of the residual. known: indices into map.height (row by
/// row) of all points with a value that the fit may see; fitted: those of them that are fitted.
Eigen::ArrayXd area_weights(const HeightMap& map, const std::vector<Eigen::Index>& known,
                            const std::vector<Eigen::Index>& fitted);

}  // namespace aberfit::internal
