#pragma once
#include <string>
#include <vector>

#include "aberfit/method/verify.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// Names of the pictures of verify: reflected_rays, deflections, ring_through, height_profile, focal_images,
/// focal_volume.
const std::vector<std::string>& verify_picture_names();

/// Contents: rays of one realisation for the ideal mirror, the Harvey-Shack branch and the aberration terms.
struct VerifyPictures {
  const VerifyReport& report;  ///< has report.shown
  const Mirror& mirror;
  const Aperture& aperture;
};
/// Draws the pictures as a fit does (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const VerifyPictures& of, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
