#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/ceilings.h"

namespace aberfit {

/// ceilings.csv: an octave a line, SI units in the header; empty fields where no height violates a budget.
std::string ceilings_csv(const Ceilings& ceilings);

/// Picture `ceilings`, profile PSD over frequency on log-log axes, as those of a fit (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const Ceilings& ceilings, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
