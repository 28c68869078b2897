#pragma once
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"
#include "shared_data.h"

namespace aberfit::test {

/// First scan line of ../shared/data/dabam/dabam-<id>, by the conventions of its README.
inline Profile load_dabam(const std::string& id) {
  const std::string stem = (shared_data("dabam").value() / ("dabam-" + id)).string();
  std::ifstream text(stem + ".txt"), data(stem + ".dat");
  const nlohmann::json meta = nlohmann::json::parse(text);
  const int format = meta.at("FILE_FORMAT");
  const std::size_t cx = meta.value("COLUMN_INDEX_ABSCISSAS", 0),
                    cy = meta.value("COLUMN_INDEX_ORDINATES", 1);
  std::string line;
  for (int i = 0; i < int(meta.at("FILE_HEADER_LINES")); ++i) std::getline(data, line);
  std::vector<double> x, y;
  while (std::getline(data, line)) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (double v; fields >> v;) row.push_back(v);
    if (row.size() <= std::max(cx, cy)) continue;
    x.push_back(row[cx] * meta.at("X1_FACTOR").get<double>());
    y.push_back(row[cy] * meta.at("Y1_FACTOR").get<double>());
  }
  Profile profile;
  profile.x = Eigen::Map<Eigen::ArrayXd>(x.data(), Eigen::Index(x.size()));
  profile.value = Eigen::Map<Eigen::ArrayXd>(y.data(), Eigen::Index(y.size()));
  profile.quantity = format % 2 == 1 ? ProfileQuantity::kSlope : ProfileQuantity::kHeight;
  profile.label = id;
  return profile;
}

/// The interferogram of ../shared/data/prysm-zygo; offsets and scale are from its README.
inline HeightMap load_zygo() {
  std::ifstream file(shared_data("prysm-zygo").value() / "valid_zygo_dat_file.dat", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() < 834) throw std::runtime_error("the Zygo file is missing");
  HeightMap map;
  map.height.resize(432, 425);
  map.pitch_x = map.pitch_y = 1.1792420264e-4;
  std::size_t at = 834 + 2 * 640 * 480;
  for (Eigen::Index r = 0; r < 432; ++r)
    for (Eigen::Index c = 0; c < 425; ++c) {
      std::uint32_t raw = 0;
      for (int k = 0; k < 4; ++k) raw = raw << 8 | std::uint8_t(bytes[at++]);
      const std::int32_t phase = std::int32_t(raw);
      map.height(431 - r, c) = phase >= 2147483640 ? std::numeric_limits<double>::quiet_NaN()
                                                   : phase * 6.32799981e-7 * 0.5 / 32768;
    }
  return map;
}

inline const std::vector<std::string>& dabam_ids() {
  static const std::vector<std::string> ids = {"001", "004", "007", "010", "019", "022", "024",
                                               "025", "039", "049", "071", "083", "094", "095"};
  return ids;
}

}  // namespace aberfit::test
