#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/budget_light.h"
#include "aberfit/specify/solve.h"

namespace aberfit {

/// contour.csv: both unknowns, then every budget's value and margin, SI units in the header, one line a
/// point; what binds in the last column.
std::string contour_csv(const Specification& spec);

/// Pictures as those of a fit (report/pictures.h): budget_light, encircled energies with the budgets on them
/// (unless `light` is empty); sensitivities, a bar for each budget and unknown; contour of two unknowns.
std::vector<DrawnPicture> draw_pictures(const Specification& spec, const BudgetLight& light,
                                        const std::string& directory, const PictureOptions& options,
                                        Warnings* warnings);

}  // namespace aberfit
