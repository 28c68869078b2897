#pragma once
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"

namespace aberfit {

/// chart.csv: one line per row, all of its members and its family's descriptions, SI units in the header;
/// what does not exist is empty.
std::string chart_csv(const Chart& chart);

/// "rays, rays 65,536", "terms and scatter, f_c 12.5 /m": a row by its setting.
std::string setting_text(const ChartRow& row);

/// Pictures as those of a fit (report/pictures.h), one per family: error against time with the frontier,
/// today's setting and the cheapest within tolerance marked.
std::vector<DrawnPicture> draw_pictures(const Chart& chart, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
