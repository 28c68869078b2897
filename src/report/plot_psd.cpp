#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/report/psd_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

double least_positive(const Eigen::ArrayXd& values) {
  double least = HUGE_VAL;
  for (const double value : values)
    if (value > 0) least = std::min(least, value);
  return least;
}

Picture psd_picture(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const SurfacePsd& s = report.surface;
  const bool is_profile = e.kind == PsdTableKind::k1dOneSided;
  const Eigen::ArrayXd model =
      (s.frequency >= report.fit.f_min && s.frequency <= report.fit.f_max).select(s.model, NAN);
  Picture picture("psd", report.title);
  picture.add_columns("psd.dat",
                      {fmt::format("PSD of the surface in {}",
                                   is_profile ? "m^3, one-sided, of the profile" : "m^4, two-sided"),
                       "frequency [1/m], PSD, lower and upper end of the interval, model"},
                      {s.frequency, s.psd, s.lower, s.upper, model});
  std::vector<double> lines;
  for (const SpectralLine& line : e.lines) lines.push_back(line.frequency);
  const double scale = is_profile ? 1e21 : 1e24;  // nm^2 mm, nm^2 mm^2
  picture.set("x_axis", log_axis("x", 0.8e-3 * s.frequency.minCoeff(), 1.25e-3 * s.frequency.maxCoeff()));
  picture.set("y_axis", log_axis("y", 0.5 * scale * least_positive(s.psd.min(s.lower)),
                                 2 * scale * largest_size(s.psd.max(s.upper))));
  picture.set("scale", scale);
  picture.set("is_profile", int(is_profile));
  picture.set("lines", int(lines.size()));
  picture.set("line", lines);
  picture.set("confidence", 100 * e.options.confidence);
  picture.set("model", to_string(report.fit.family));
  return picture;
}

Picture structure_function_picture(const PsdReport& report) {
  Picture picture("structure_function", report.title);
  std::vector<PictureColumns> curves;
  for (const HeightDifferences& d : report.differences)
    curves.push_back({d.separation, d.mean_square,
                      model_height_differences(report.fit, report.estimate.kind, d.separation)});
  picture.add_blocks("structure_function.dat",
                     {"separation [m], D of the measurement [m^2], D of the model; one block per file"},
                     curves);
  double first = HUGE_VAL, last = 0, low = HUGE_VAL, high = 0;
  for (const PictureColumns& curve : curves) {
    first = std::min(first, least_positive(curve[0])), last = std::max(last, largest_size(curve[0]));
    low = std::min({low, least_positive(curve[1]), least_positive(curve[2])});
    high = std::max({high, largest_size(curve[1]), largest_size(curve[2])});
  }
  picture.set("x_axis", log_axis("x", 0.8e3 * first, 1.25e3 * last));
  picture.set("y_axis", log_axis("y", 0.5e18 * low, 2e18 * high));
  picture.set("files", int(curves.size()));
  picture.set("model", to_string(report.fit.family));
  return picture;
}

// The smallest and the largest of each run of points, in their order, if a picture cannot show all.
PictureColumns thinned(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  constexpr Eigen::Index kRuns = 1200;
  if (x.size() <= 4 * kRuns) return {x, y};
  std::vector<double> some_x, some_y;
  for (Eigen::Index run = 0; run < kRuns; ++run) {
    const Eigen::Index begin = run * x.size() / kRuns, size = (run + 1) * x.size() / kRuns - begin;
    Eigen::Index least = 0, most = 0;
    y.segment(begin, size).minCoeff(&least);
    y.segment(begin, size).maxCoeff(&most);
    for (const Eigen::Index at : {std::min(least, most), std::max(least, most)})
      some_x.push_back(x[begin + at]), some_y.push_back(y[begin + at]);
  }
  return {array_of(some_x), array_of(some_y)};
}

Picture profile_picture(const PsdReport& report, const Profile& measured, const std::string& name) {
  const Profile heights = detrend(heights_of(measured), report.estimate.options.detrend);
  Picture picture(name, report.title, "data_profile");
  picture.add_columns(name + ".dat",
                      {"Detrended heights of the measured profile: x [m], height [m]; a long one has the "
                       "least and the largest height of each run of points"},
                      thinned(heights.x, heights.value));
  picture.set("x", length_unit(heights.x.abs().maxCoeff()));
  picture.set("h", length_unit(largest_size(heights.value)));
  return picture;
}

Picture map_picture(const PsdReport& report, const HeightMap& measured, const ClearRegion& clear,
                    const std::string& name) {
  HeightMap map = detrend(measured, report.estimate.options.detrend);
  centre_on_grid(&map);
  const double reach = colour_reach({&map.height}), largest = largest_size(map.height);
  Picture picture(name, report.title, "data_map");
  picture.add_matrix(name + ".dat",
                     {"Detrended heights of the measured map [m]; nan where nothing was measured",
                      fmt::format("rows from -y to +y, {:.9g} m apart; columns from -x to +x, {:.9g} m apart",
                                  map.pitch_y, map.pitch_x)},
                     map.height);
  picture.set("x", length_unit(std::max(std::abs(map.x0), std::abs(map.y0))));
  picture.set("h", length_unit(reach));
  picture.set("reach", reach);
  picture.set("extremes", largest > 1.5 * reach
                              ? fmt::format(", colours span 99.9 % of the points; largest {}",
                                            display(largest, Dimension::kLength))
                              : std::string());
  picture.set_pixels(map.x0, map.pitch_x, map.y0, map.pitch_y);
  picture.add_rim(clear, map.x0 - measured.x0, map.y0 - measured.y0);
  return picture;
}

}  // namespace

std::vector<DrawnPicture> draw_pictures(const PsdReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (options.format == PictureFormat::kNone) return {};
  std::vector<Picture> pictures = {psd_picture(report)};
  if (!report.differences.empty() && report.differences.front().separation.size() > 1)
    pictures.push_back(structure_function_picture(report));
  for (std::size_t i = 0; i < report.data.size(); ++i) {
    const std::string name = i == 0 ? "data" : fmt::format("data_{}", i + 1);
    if (const auto* profile = std::get_if<Profile>(&report.data[i]))
      pictures.push_back(profile_picture(report, *profile, name));
    else
      pictures.push_back(map_picture(report, std::get<HeightMap>(report.data[i]), report.clear.at(i), name));
    if (report.data.size() > 1 && i < report.files.size())
      pictures.back().title = "Measurement: " + report.files[i];
  }
  return draw(pictures, directory, options, warnings);
}

}  // namespace aberfit
