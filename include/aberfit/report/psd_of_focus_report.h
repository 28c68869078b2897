#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/psd_of_focus.h"

namespace aberfit {

/// focus.csv: radius, measured and fitted energy, noise, spread of single mirrors, and the residual over
/// both. It has one line per circle or ring, with SI units in the header.
std::string focus_csv(const PsdOfFocus& result);

/// Draws picture `focus`, as a fit does (report/pictures.h): the measured focus with its noise and that of
/// the fitted roughness, and below the residual in standard deviations.
std::vector<DrawnPicture> draw_pictures(const PsdOfFocus& result, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
