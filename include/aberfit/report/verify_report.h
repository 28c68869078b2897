#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/method/verify.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// result.json of `aberfit verify`: headline, convention, verdict and what decided it, scene, statistics of
/// theory and both branches, the same in light, published numbers where there are any, quantities, warnings.
/// study: the resolved study. SI numbers, unit in the key; what does not exist is null.
nlohmann::ordered_json to_json(const VerifyReport& report, const nlohmann::ordered_json& study);

/// The table people read on the terminal.
std::string summary_table(const VerifyReport& report);

/// Names of the pictures of verify: mirror, reflected_rays, frequency_sampling (only with a published phase),
/// phase_gradients, deflections, scatter_angles, ring_through, height_profile, focal_images, focal_volume.
const std::vector<std::string>& verify_picture_names();

/// Writes them below `directory`/plots, as write_plots does, and returns the paths of the PNGs. They show the
/// rays of one draw: the ideal mirror, the Harvey-Shack branch and the aberration terms. report.shown is
/// there.
std::vector<std::string> write_verify_plots(const VerifyReport& report, const Mirror& mirror,
                                            const Aperture& aperture, double wavelength,
                                            const std::string& directory, Warnings* warnings);

}  // namespace aberfit
