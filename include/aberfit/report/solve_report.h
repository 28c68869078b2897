#pragma once
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/budget_light.h"
#include "aberfit/specify/solve.h"

namespace aberfit {

/// contour.csv: both unknowns, then every budget's value and margin, and the binding budget in the last
/// column. It has one line per point, with SI units in the header.
std::string contour_csv(const Specification& spec);

/// Draws pictures as a fit does (report/pictures.h): budget_light, encircled energies with the budgets marked
/// (unless `light` is empty); sensitivities, a bar for each budget and unknown; contour of two unknowns.
std::vector<DrawnPicture> draw_pictures(const Specification& spec, const BudgetLight& light,
                                        const std::string& directory, const PictureOptions& options,
                                        Warnings* warnings);

}  // namespace aberfit
