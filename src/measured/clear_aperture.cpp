#include "aberfit/measured/clear_aperture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "fits_layout.h"

namespace aberfit {
namespace {

using Eigen::Index;

// A longer length, as a multiple of the data, means a forgotten percent sign or unit.
constexpr double kMostOfData = 2;

double length_of(const Extent& extent, double whole) {
  if (extent.percent) return 0.01 * extent.value * whole;
  if (extent.value > kMostOfData * whole)
    throw std::invalid_argument(fmt::format("{} is more than twice the extent of the data, {}",
                                            format_quantity(extent.value, Dimension::kLength),
                                            format_quantity(whole, Dimension::kLength)));
  return extent.value;
}

ApertureBox valid_box(const HeightMap& map) {
  ApertureBox box{kInfinity, -kInfinity, kInfinity, -kInfinity};
  for (Index r = 0; r < map.rows(); ++r)
    for (Index c = 0; c < map.columns(); ++c)
      if (std::isfinite(map.height(r, c)))
        box = {std::min(box.x0, map.x(c)), std::max(box.x1, map.x(c)), std::min(box.y0, map.y(r)),
               std::max(box.y1, map.y(r))};
  return box;
}

[[noreturn]] void refuse_for(const char* data, const char* allowed) {
  throw std::invalid_argument(fmt::format("this shape does not suit a {}; use {}", data, allowed));
}

ClearRegion placed(Aperture aperture, double x, double y, const std::vector<double>& centre) {
  ClearRegion region;
  region.aperture = std::move(aperture);
  region.x = x, region.y = y;
  if (!centre.empty()) region.x += centre[0];
  if (centre.size() > 1) region.y += centre[1];
  return region;
}

ClearRegion region_on(const HeightMap& map, const ClearAperture& clear) {
  if (!(map.pitch_x > 0 && map.pitch_y > 0))
    throw std::invalid_argument("the file does not state the distance between its points; give `pitch`");
  const Circle circle = enclosing_circle(map);
  const auto round = [&](const Extent& diameter) { return length_of(diameter, 2 * circle.radius); };
  return std::visit(
      Overloaded{
          [&](const ClearCircle& c) {
            return placed(CircleAperture{round(c.diameter)}, circle.x, circle.y, clear.centre);
          },
          [&](const ClearAnnulus& a) {
            return placed(AnnulusAperture{round(a.diameter), round(a.inner_diameter)}, circle.x, circle.y,
                          clear.centre);
          },
          [&](const ClearRectangle& r) {
            const ApertureBox box = valid_box(map);
            return placed(
                RectangleAperture{length_of(r.width, box.x1 - box.x0), length_of(r.height, box.y1 - box.y0)},
                (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, clear.centre);
          },
          [](const ClearInterval&) -> ClearRegion { refuse_for("map", "circle, annulus or rectangle"); }},
      clear.shape);
}

ClearRegion region_on(const Profile& profile, const ClearAperture& clear) {
  const auto* interval = std::get_if<ClearInterval>(&clear.shape);
  if (!interval) refuse_for("profile", "interval");
  Index first = 0, last = profile.size() - 1;
  while (first < last && !std::isfinite(profile.value[first])) ++first;
  while (last > first && !std::isfinite(profile.value[last])) --last;
  const double from = profile.x[first], to = profile.x[last];
  return placed(RectangleAperture{length_of(interval->length, to - from), 0}, (from + to) / 2, 0,
                clear.centre);
}

bool inside(const ClearRegion& region, double x, double y) {
  return aperture_holds(*region.aperture, x - region.x, y - region.y);
}

Mask outside(const HeightMap& map, const ClearRegion& region) {
  Mask result(map.rows(), map.columns());
  for (Index r = 0; r < map.rows(); ++r)
    for (Index c = 0; c < map.columns(); ++c) result(r, c) = !inside(region, map.x(c), map.y(r));
  return result;
}
Mask outside(const Profile& profile, const ClearRegion& region) {
  Mask result(1, profile.size());
  for (Index c = 0; c < profile.size(); ++c) result(0, c) = !inside(region, profile.x[c], region.y);
  return result;
}

// Marks every sample that has an invalid sample or an end of the data within `by` samples along its line.
void widen(const Mask& invalid, Index by, bool rows, Mask* wide) {
  const Index lines = rows ? invalid.rows() : invalid.cols(), n = rows ? invalid.cols() : invalid.rows();
  wide->resize(invalid.rows(), invalid.cols());
  for (Index line = 0; line < lines; ++line) {
    const auto at = [&](Index i) { return i < 0 || i >= n || (rows ? invalid(line, i) : invalid(i, line)); };
    Index last = -1 - by, next = -1;  // nearest invalid samples before and after
    for (Index i = 0; i < n; ++i) {
      if (at(i - 1)) last = i - 1;
      if (at(i)) last = i;
      for (next = std::max(next, i); !at(next);) ++next;
      (rows ? (*wide)(line, i) : (*wide)(i, line)) = i - last <= by || next - i <= by;
    }
  }
}

Mask at_the_rim(const Mask& invalid, Index by, bool profile) {
  Mask wide, result;
  widen(invalid, by, true, &wide);
  if (profile) return wide;
  widen(wide, by, false, &result);
  return result;
}

void require_mask(const HeightMap& map, const Grid& mask) {
  if (mask.rows() != map.rows() || mask.cols() != map.columns())
    throw std::invalid_argument(fmt::format("the mask has {} x {} points, the map {} x {}", mask.cols(),
                                            mask.rows(), map.columns(), map.rows()));
}

}  // namespace

std::string ClearRegion::text() const {
  if (!aperture) return "";
  const auto length = [](double value) { return format_quantity(value, Dimension::kLength); };
  return std::visit(Overloaded{[&](const CircleAperture& c) { return "circle of " + length(c.diameter); },
                               [&](const AnnulusAperture& a) {
                                 return fmt::format("annulus of {} and {}", length(a.diameter),
                                                    length(a.inner_diameter));
                               },
                               [&](const RectangleAperture& r) {
                                 return r.height > 0 ? fmt::format("rectangle of {} x {}", length(r.width),
                                                                   length(r.height))
                                                     : "interval of " + length(r.width);
                               },
                               [](const PolygonAperture&) { return std::string("polygon"); },
                               [](const SegmentedAperture&) { return std::string("segments"); }},
                    *aperture) +
         (std::holds_alternative<RectangleAperture>(*aperture) &&
                  std::get<RectangleAperture>(*aperture).height == 0
              ? " about " + length(x)
              : fmt::format(" about ({}, {})", length(x), length(y)));
}

std::vector<std::vector<std::array<double, 2>>> ClearRegion::outlines() const {
  if (!aperture) return {};
  std::vector<std::vector<std::array<double, 2>>> lines;
  const auto circle = [&](double diameter) {
    auto& line = lines.emplace_back();
    for (int degree = 0; degree <= 360; ++degree)
      line.push_back({x + 0.5 * diameter * std::cos(degree * kPi / 180),
                      y + 0.5 * diameter * std::sin(degree * kPi / 180)});
  };
  if (const auto* round = std::get_if<CircleAperture>(&*aperture)) circle(round->diameter);
  if (const auto* ring = std::get_if<AnnulusAperture>(&*aperture))
    circle(ring->diameter), circle(ring->inner_diameter);
  for (Outline corners : aperture_outlines(*aperture)) {
    corners.push_back(corners.front());
    for (auto& [cx, cy] : corners) cx += x, cy += y;
    lines.push_back(std::move(corners));
  }
  return lines;
}

ClearRegion take_clear_part(Measurement* data, const ClearPart& part, const std::string& mask_path,
                            bool mask_bottom_first) {
  ClearRegion region;
  std::visit(
      [&](auto& measured) {
        constexpr bool kProfile = std::is_same_v<std::decay_t<decltype(measured)>, Profile>;
        const Index before = valid_count(measured);
        if (before == 0) return;
        if (part.aperture) {
          region = region_on(measured, *part.aperture);
          take_out(&measured, outside(measured, region));
        }
        if constexpr (kProfile) {
          if (!part.mask.empty())
            throw std::invalid_argument("a mask is for maps; a profile takes an interval");
          if (part.erode > 0)
            take_out(&measured, at_the_rim(!measured.value.isFinite().transpose(), part.erode, true));
        } else {
          if (!part.mask.empty()) {
            const Grid mask = read_mask(mask_path, mask_bottom_first);
            require_mask(measured, mask);
            take_out(&measured, !mask.isFinite() || mask == 0);
          }
          if (part.erode > 0) take_out(&measured, at_the_rim(!measured.height.isFinite(), part.erode, false));
        }
        region.taken_out = before - valid_count(measured);
        if (valid_count(measured) == 0)
          throw std::invalid_argument("no sample is left inside aperture, mask and eroded rim");
      },
      *data);
  return region;
}

Grid read_mask(const std::string& path, bool bottom_first) {
  if (detect_format(path) == MeasuredFormat::kFits) return internal::fits_pixels(path);
  TextLines lines(path);
  std::vector<std::vector<double>> rows;
  for (std::string_view line; lines.next(&line);) {
    const std::vector<std::string_view> cells = words(before_comment(line), " \t\r,;");
    if (cells.empty()) continue;
    rows.emplace_back();
    for (const std::string_view cell : cells) {
      const std::optional<double> value = parse_number<double>(cell);
      if (!value) lines.fail(in_quotes(cell), "numbers, with 0 or nan where the map is to be left out");
      rows.back().push_back(*value);
    }
    if (rows.back().size() != rows.front().size())
      lines.fail(fmt::format("{} numbers", rows.back().size()),
                 fmt::format("{}, as in the first row", rows.front().size()));
  }
  if (rows.empty())
    throw InputError(path, "", "no numbers", "a mask with 0 or nan where the map is to be left out");
  Grid mask(Index(rows.size()), Index(rows.front().size()));
  for (Index r = 0; r < mask.rows(); ++r)
    for (Index c = 0; c < mask.cols(); ++c)
      mask(r, c) = rows[std::size_t(bottom_first ? r : mask.rows() - 1 - r)][std::size_t(c)];
  return mask;
}

}  // namespace aberfit
