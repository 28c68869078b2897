#include "aberfit/terms/term_set.h"

namespace aberfit {

std::vector<ZernikeMode> zernike_modes(int n_min, int n_max) {
  std::vector<ZernikeMode> modes;
  for (int n = n_min; n <= n_max; ++n)
    for (int m = -n; m <= n; m += 2) modes.push_back({n, m});
  return modes;
}

}  // namespace aberfit
