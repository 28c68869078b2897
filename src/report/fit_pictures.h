#pragma once
#include <optional>

#include "aberfit/report/pictures.h"
#include "picture.h"

namespace aberfit::internal {

// The script of each picture says what it shows. A function returns nothing if there is nothing to show.
Picture ee_curves_picture(const FitPictures& fit);
Picture ring_through_picture(const FitPictures& fit);
Picture focal_images_picture(const FitPictures& fit);
std::optional<Picture> focal_core_picture(const FitPictures& fit);
std::optional<Picture> mtf_picture(const FitPictures& fit);
std::optional<Picture> specified_psd_picture(const FitPictures& fit);
std::optional<Picture> bsdf_picture(const FitPictures& fit);
Picture gradients_picture(const FitPictures& fit);
Picture surface_picture(const FitPictures& fit, const SurfaceField& grid);
Picture profile_picture(const FitPictures& fit, const SurfaceField& grid);
Picture coefficients_picture(const FitPictures& fit);
Picture frontier_picture(const FitPictures& fit);
Picture character_picture(const FitPictures& fit);
Picture map_heights_picture(const FitPictures& fit);
Picture map_light_picture(const FitPictures& fit);

}  // namespace aberfit::internal
