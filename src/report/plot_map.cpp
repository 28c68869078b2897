#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "fit_pictures.h"
#include "map_report.h"

namespace aberfit::internal {
namespace {

// Largest number of points per side of a drawn map. A larger map shows every second, third, ... point.
constexpr Eigen::Index kMostDrawn = 512;
Eigen::ArrayXXd thinned(const Grid& height, Eigen::Index step) {
  const auto every = [&](Eigen::Index n) { return Eigen::seqN(0, (n + step - 1) / step, step); };
  return height(every(height.rows()), every(height.cols()));
}

std::string nanometres(double metres) { return fmt::format("{:.4g} nm", 1e9 * metres); }

}  // namespace

Picture map_heights_picture(const FitPictures& fit) {
  const MapPanels& panels = *fit.result.map.panels;
  const HeightMap& map = panels.measured.map;
  const Eigen::Index step = (std::max(map.rows(), map.columns()) + kMostDrawn - 1) / kMostDrawn;
  const double both = colour_reach({&map.height, &panels.fitted.map.height});
  const std::tuple<const char*, const char*, const MapPanel*> all[] = {
      {"measured", "measured", &panels.measured},
      {"fitted", "fitted terms", &panels.fitted},
      {"residual", "residual", &panels.residual}};
  Picture picture("map_heights", fit.result.title);
  std::vector<std::string> labels;
  for (const auto& [key, label, panel] : all) {
    picture.add_matrix(
        fmt::format("map_heights_{}.dat", key),
        {fmt::format(
             "Height [m] of the surface, {}, positive towards the incoming light, without piston and tilt of "
             "the mount; nan where nothing was measured; RMS {:.6g}, peak to valley {:.6g} of all points",
             label, panel->rms, panel->peak_to_valley),
         fmt::format("rows from -y to +y, columns from -x to +x, every {} of the map's points; the first at "
                     "{:.9g}, {:.9g} m",
                     step, map.x0, map.y0)},
        thinned(panel->map.height, step));
    labels.push_back(
        fmt::format("{}: RMS {}, PV {}", label, nanometres(panel->rms), nanometres(panel->peak_to_valley)));
  }
  picture.set("label", labels);
  picture.set("reach", std::vector<double>{both, both, colour_reach({&panels.residual.map.height})});
  picture.set("x", AxisUnit{1e3, "mm"});
  picture.set_pixels(map.x0, map.pitch_x * double(step), map.y0, map.pitch_y * double(step));
  picture.set("x_last", map.x(map.columns() - 1));
  picture.set("y_last", map.y(map.rows() - 1));
  return picture;
}

Picture map_light_picture(const FitPictures& fit) {
  constexpr double kFaintest = 1e-5;  // fraction of the perfect mirror's peak
  const MapLight& light = *fit.result.map.light;
  const double last = light.radius[light.radius.size() - 1];
  const PsfImage& first = light.perfect.psf;
  const bool images = first.intensity.size() > 0;
  Picture picture("map_light", fit.result.title);
  PictureColumns columns = {light.radius};
  std::string curves, lit_images;
  std::vector<std::string> labels, titles;
  std::vector<double> fwhm, ee80;
  for (std::size_t k = 0; k < light.columns().size(); ++k) {
    const LitSurface& lit = *light.columns()[k];
    columns.push_back(lit.share.size() > 0 ? lit.share : Eigen::ArrayXd::Constant(light.radius.size(), NAN));
    const auto text = [](double length) { return display(length, Dimension::kLength); };
    labels.push_back(fmt::format("{}: ee50 {}, ee80 {}, ee90 {}, FWHM {}", kMapColumns[k].label,
                                 text(lit.ee50), text(lit.ee80), text(lit.ee90), text(lit.spot_fwhm)));
    if (lit.obstacle.empty()) curves += fmt::format("{} ", k + 1);
    titles.push_back(fmt::format("{}: Strehl {:.4f}", kMapColumns[k].label, lit.strehl));
    fwhm.push_back(lit.spot_fwhm), ee80.push_back(lit.ee80);
    if (!images || k == 3 || lit.psf.intensity.size() == 0) continue;
    lit_images += fmt::format("{} ", k + 1);
    picture.add_matrix(
        fmt::format("map_light_{}.dat", kMapColumns[k].key),
        {fmt::format("Irradiance over the peak of the perfect mirror, {}", kMapColumns[k].label),
         fmt::format("samples {:.9g} m apart, rows from -y to +y, columns from -x to +x, the "
                     "first at {:.9g} m in x and y",
                     lit.psf.pitch, lit.psf.first)},
        lit.psf.intensity);
  }
  picture.add_columns(
      "map_light.dat",
      {"Encircled energy: fraction of the energy within a radius of the nominal focus, at z = f",
       "columns: radius_m measured terms terms_and_residual_psd perfect (nan: no PSF)"},
      columns);
  picture.set("height", images ? 1080 : 620);
  picture.set("images", int(images));
  picture.set("curves", curves);
  picture.set("lit", lit_images);
  picture.set("label", labels);
  picture.set("image_title", titles);
  picture.set("fwhm", fwhm);
  picture.set("ee80", ee80);
  picture.set("x", length_unit(last));
  picture.set("last", last);
  picture.set_pixels(first.first, first.pitch, first.first, first.pitch);
  picture.set("faintest", kFaintest);
  return picture;
}

}  // namespace aberfit::internal
