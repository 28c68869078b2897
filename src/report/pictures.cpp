#include "aberfit/report/pictures.h"

#include "fit_pictures.h"

namespace aberfit {
using namespace internal;

namespace {

// True for a map without a specification whose focus needs wave optics. Then `map_light` shows it, and rays
// would be wrong.
bool rays_show_nothing(const ResultDocument& result) {
  return result.map.fit && !result.has_roughness && result.scene.model == "waves";
}

}  // namespace

const std::vector<std::string>& fit_picture_names() {
  static const std::vector<std::string> names = {"map_heights",  "map_light",    "specified_psd", "ee_curves",
                                                 "ring_through", "focal_images", "focal_core",    "mtf",
                                                 "bsdf",         "surface",      "profile",       "gradients",
                                                 "coefficients", "character",    "frontier"};
  return names;
}

std::vector<DrawnPicture> draw_pictures(const FitPictures& fit, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (options.format == PictureFormat::kNone) return {};
  const ResultDocument& result = fit.result;
  std::vector<Picture> pictures;
  const auto add = [&](std::optional<Picture> picture) {
    if (picture) pictures.push_back(std::move(*picture));
  };
  if (result.map.panels) add(map_heights_picture(fit));
  if (result.map.light) add(map_light_picture(fit));
  add(specified_psd_picture(fit));
  if (!rays_show_nothing(result)) {
    add(ee_curves_picture(fit));
    add(ring_through_picture(fit));
    add(focal_images_picture(fit));
    add(focal_core_picture(fit));
    add(mtf_picture(fit));
  }
  add(bsdf_picture(fit));
  const Eigen::VectorXd& coefficients = result.fitted.fit.coefficients;
  if (coefficients.size() > 0 && coefficients.size() == fit.surface_grid.terms().size()) {
    SurfaceField grid;
    fit.surface_grid.apply(coefficients, &grid);
    add(surface_picture(fit, grid));
    add(profile_picture(fit, grid));
    add(gradients_picture(fit));
    add(coefficients_picture(fit));
  }
  if (result.judgement.character && !result.judgement.character->zones.empty()) add(character_picture(fit));
  if (result.choices.frontier && result.choices.frontier->points.size() > 1) add(frontier_picture(fit));
  return draw(pictures, directory, options, warnings);
}

}  // namespace aberfit
