#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/ceilings.h"

namespace aberfit {

/// ceilings.csv: one line per octave, SI units in the header. Fields are empty if no height violates a
/// budget.
std::string ceilings_csv(const Ceilings& ceilings);

/// Draws picture `ceilings`, profile PSD over frequency on log-log axes, as a fit does (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const Ceilings& ceilings, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
