#pragma once
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"

namespace aberfit {

/// chart.csv: one line per row with all of its members and its family's descriptions, SI units in the header.
/// Values that do not exist are empty.
std::string chart_csv(const Chart& chart);

/// Setting of a row: "rays, rays 65,536", "terms and scatter, f_c 12.5 /m".
std::string setting_text(const ChartRow& row);

/// Draws one picture per family, as a fit does (report/pictures.h): error against time, with marks for the
/// frontier, today's setting and the cheapest within tolerance.
std::vector<DrawnPicture> draw_pictures(const Chart& chart, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
