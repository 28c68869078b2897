#include <fmt/format.h>

#include "fit_pictures.h"

namespace aberfit::internal {
namespace {

// Columns with one row per bin or zone: edges, value and the band of realisations.
template <class Rows>
PictureColumns columns(const Rows& rows, auto low, auto high) {
  PictureColumns result(6, Eigen::ArrayXd(Eigen::Index(rows.size())));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto k = Eigen::Index(i);
    const BesideDraws& ratio = rows[i].ratio;
    result[0][k] = low(rows[i]), result[1][k] = high(rows[i]);
    result[2][k] = ratio.value, result[3][k] = ratio.mean;
    result[4][k] = ratio.low, result[5][k] = ratio.high;
  }
  return result;
}

}  // namespace

Picture character_picture(const FitPictures& fit) {
  const Character& character = *fit.result.judgement.character;
  Picture picture("character", fit.result.title);
  const std::vector<std::string> header = {
      "value of the surface, mean of realisations, and the band that holds 99 % of them",
      "columns: low edge, high edge, value, mean, band low, band high"};
  const auto add = [&](const std::string& file, const std::string& what, const PictureColumns& rows) {
    picture.add_columns(file, {what, header[0], header[1]}, rows);
  };
  const bool has_psd = !character.psd.empty();
  picture.set("has_psd", int(has_psd));
  if (has_psd) {
    add("character_psd.dat",
        "PSD over the mean of realisations of the specification; edges f_per_m [cycles/m]",
        columns(
            character.psd, [](const CharacterBin& b) { return b.low; },
            [](const CharacterBin& b) { return b.high; }));
    picture.set("f_axis", log_axis("x", character.psd.front().low, character.psd.back().high));
  }
  add("character_zones.dat",
      "RMS slope of zones as a fraction of that of the aperture; edges in aperture radii",
      columns(
          character.zones, [](const ZoneSlope& z) { return z.rho_min; },
          [](const ZoneSlope& z) { return z.rho_max; }));
  return picture;
}

}  // namespace aberfit::internal
