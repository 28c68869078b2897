#include "aberfit/scene/mirror.h"

#include <limits>

namespace aberfit {

double sag_domain_radius(const Mirror& mirror) {
  if (mirror.conic <= -1.0) return std::numeric_limits<double>::infinity();
  return 2.0 * mirror.focal_length / std::sqrt(1.0 + mirror.conic);
}

}  // namespace aberfit
