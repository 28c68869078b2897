#include "aberfit/report/frontier.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

std::string set_name(const FrontierPoint& point) {
  return point.family == "fourier" ? fmt::format("{} waves", point.order)
                                   : fmt::format("n <= {}", point.order);
}

std::string row(const FrontierPoint& point) {
  const std::string verdict = point.verdict ? to_string(*point.verdict) : "not judged";
  const std::string held_out =
      std::isfinite(point.held_out_mismatch) ? fmt::format("{:.3f}", 100 * point.held_out_mismatch) : "-";
  return fmt::format(
      "  {:<14} {:>7} {:>9} {:>12} {:>14} {:>8.2f}  {}\n", set_name(point), point.terms, point.rays,
      std::isfinite(point.fitted_mismatch) ? fmt::format("{:.4g}", point.fitted_mismatch) : "-", held_out,
      point.seconds,
      point.chosen   ? verdict + ", taken"
      : point.passes ? verdict + ", passes"
                     : verdict);
}

}  // namespace

Json to_json(const Frontier& frontier) {
  Json points = Json::array();
  for (const FrontierPoint& point : frontier.points)
    points.push_back({{"family", point.family},
                      {"order", point.order},
                      {"terms", point.terms},
                      {"pupil_points", point.rays},
                      {"fitted_mismatch_tolerances", json_number(point.fitted_mismatch)},
                      {"held_out_mismatch", json_number(point.held_out_mismatch)},
                      {"seconds", json_number(point.seconds)},
                      {"verdict", point.verdict ? Json(to_string(*point.verdict)) : Json(nullptr)},
                      {"passes", point.passes},
                      {"chosen", point.chosen}});
  return {{"message", frontier.message},
          {"fewest", frontier.fewest},
          {"seconds", json_number(frontier.seconds)},
          {"margin", json_number(frontier.margin)},
          {"points", points}};
}

Json to_json(const RayChoice& rays) {
  return {{"automatic", rays.automatic},
          {"gap", json_number(rays.gap)},
          {"sampling_error", json_number(rays.sampling_error)},
          {"allowed", json_number(rays.allowed)},
          {"reason", rays.reason}};
}

Json to_json(const BandUse& band) {
  return {{"modelled_f_min", json_number(band.modelled_f_min)},
          {"modelled_f_max", json_number(band.modelled_f_max)},
          {"limited_by", band.limited_by},
          {"left_out_height_share", json_number(band.left_out_height_share)},
          {"left_out_slope_share", json_number(band.left_out_slope_share)},
          {"ee90_change", json_number(band.ee90_change)}};
}

std::string frontier_lines(const Frontier& frontier, const std::string& points_name) {
  std::string out = paragraph("Terms", fmt::format("{}; {:.3g} s", frontier.message, frontier.seconds));
  if (frontier.points.size() == 1 && !frontier.fewest) return out;
  out += fmt::format("  {:<14} {:>7} {:>9} {:>12} {:>14} {:>8}\n", "set", "terms", points_name, "fit [tol.]",
                     "held out [%]", "time [s]");
  for (const FrontierPoint& point : frontier.points) out += row(point);
  return out;
}

}  // namespace aberfit
