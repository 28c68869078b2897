#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/psd_of_focus.h"

namespace aberfit {

/// focus.csv: radius, measured and fitted light, noise and one mirror's own spread, residual over both; SI
/// units in the header, one line a circle or ring.
std::string focus_csv(const PsdOfFocus& result);

/// Picture `focus`, measured light with its noise and that of the fitted roughness, and below it what is left
/// in standard deviations, as the pictures of a fit (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const PsdOfFocus& result, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
