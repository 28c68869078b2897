#include "aberfit/measured/masking.h"

#include <stdexcept>

#include "aberfit/core/constants.h"

namespace aberfit {
namespace {

void require_shape(const Mask& mask, Eigen::Index rows, Eigen::Index columns) {
  if (mask.rows() != rows || mask.cols() != columns)
    throw std::invalid_argument("the mask does not have the shape of the measurement");
}

}  // namespace

void take_out(Profile* profile, const Mask& marked) {
  require_shape(marked, 1, profile->size());
  profile->value = marked.row(0).transpose().select(kNaN, profile->value);
}

void take_out(HeightMap* map, const Mask& marked) {
  require_shape(marked, map->rows(), map->columns());
  map->height = marked.select(kNaN, map->height);
}

}  // namespace aberfit
