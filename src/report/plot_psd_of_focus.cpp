#include <algorithm>
#include <cmath>

#include "aberfit/report/psd_of_focus_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

std::vector<DrawnPicture> draw_pictures(const PsdOfFocus& result, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (result.radius.size() == 0) return {};
  const Eigen::ArrayXd deviation = (result.noise.square() + result.spread.square()).sqrt();
  const Eigen::ArrayXd left = (result.measured - result.fitted) / deviation;
  Picture picture("focus", result.title);
  picture.add_columns("focus.dat",
                      {"Radius [m], measured energy, fitted energy, standard deviation (noise and the spread "
                       "of single mirrors), measured minus fitted over that"},
                      {result.radius, result.measured, result.fitted, deviation, left});
  const AxisUnit unit = length_unit(result.radius.maxCoeff());
  const double low = result.radius.minCoeff() / 1.1, high = result.radius.maxCoeff() * 1.1;
  picture.set("r", unit);
  picture.set("r_axis", log_axis("x", low * unit.per_si, high * unit.per_si));
  picture.set("is_image", int(result.is_image));
  picture.set("logarithmic",
              int(result.is_image && (result.measured > 0).all() && (result.fitted > 0).all()));
  picture.set("measured", result.is_one_mirror ? "measured, with noise and spread of single mirrors"
                                               : "measured, with noise");
  picture.set("reach", std::max(3.5, 1.1 * left.abs().maxCoeff()));
  return draw({picture}, directory, options, warnings);
}

}  // namespace aberfit
