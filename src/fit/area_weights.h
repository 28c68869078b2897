#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/measured/height_map.h"

namespace aberfit::internal {

/// Weights of the fitted points of a map, mean 1. A point has weight one for its own grid cell, and for each
/// hole among its eight neighbours an equal part of that hole's cell. A hole is a cell without a known point
/// inside the closing of the known ones by 5 x 5 cells: dropouts and held-out points, not the surroundings.
/// Figure residuals are smooth, so a hole has the residual of its neighbours. With equal weights, every set
/// of dropouts would change the coefficients. known: indices into map.height (row by row) of all points with
/// a value that the fit may use; fitted: those of them that are fitted.
Eigen::ArrayXd area_weights(const HeightMap& map, const std::vector<Eigen::Index>& known,
                            const std::vector<Eigen::Index>& fitted);

}  // namespace aberfit::internal
