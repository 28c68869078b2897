#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>

#include "aberfit/measured/write_map.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

std::string map_csv(const HeightMap& map) {
  if (!(map.pitch_x > 0 && map.pitch_y > 0))
    throw std::invalid_argument("map csv: the pitch of the map is unknown");
  std::string text;
  const std::string name = one_line(map.label, 200);
  if (!name.empty()) text += "# " + name + "\n";
  text += "# of: surface\n# x_m,y_m,height_m\n";
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      if (std::isfinite(map.height(row, column)))
        fmt::format_to(std::back_inserter(text), "{},{},{}\n", map.x(column), map.y(row),
                       map.height(row, column));
  return text;
}

}  // namespace aberfit
