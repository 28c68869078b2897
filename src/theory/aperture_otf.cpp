#include "aberfit/theory/aperture_otf.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "panel_rule.h"
#include "pupil_light.h"

namespace aberfit {
using namespace internal;

namespace {

using std::numbers::pi;

constexpr int kFewestCells = 320, kMostCells = 4096;

// Common area of two discs.
double lens(double one, double two, double distance) {
  if (distance >= one + two) return 0;
  const double smaller = std::min(one, two);
  if (distance <= std::abs(one - two)) return pi * smaller * smaller;
  // The areas are sectors minus triangles; the chord cuts the line between the centres at u.
  const auto segment = [](double radius, double u) {
    return radius * radius * std::acos(std::clamp(u / radius, -1.0, 1.0)) -
           u * std::sqrt(std::max(0.0, (radius - u) * (radius + u)));
  };
  const double u = (distance * distance + (one - two) * (one + two)) / (2 * distance);
  return segment(one, u) + segment(two, distance - u);
}

// The longest distance between two corners; for many corners, the diameter about the axis.
double longest_distance(const Aperture& aperture) {
  constexpr std::size_t kMany = 2000;
  std::vector<std::array<double, 2>> points;
  for (const Outline& outline : aperture_outlines(aperture))
    points.insert(points.end(), outline.begin(), outline.end());
  double longest = 0;
  if (points.size() > kMany) return 2 * aperture_radius(aperture);
  for (const auto& one : points)
    for (const auto& two : points) longest = std::max(longest, std::hypot(one[0] - two[0], one[1] - two[1]));
  return longest;
}

PanelFunction transfer_of_light(const Aperture& aperture, double cutoff) {
  const double slender = cells_for_edges(aperture);
  if (slender > kMostCells)
    throw ComputationError("the aperture is too slender for its PSF; check its smaller side");
  const PupilCells cells(aperture, std::max(kFewestCells, int(slender)));
  const FocalGrid grid(FocalGrid::samples_for(cells, cutoff), FocalGrid::taper_for(cells, 0));
  const MomentBasis basis(1);
  const LightMoments moments(PupilLight::of_cells(cells, grid, nullptr, 0, 0), basis);
  const int count = std::max(1, int(std::ceil(cutoff / moments.resolved())));
  PanelFunction function;
  for (int k = 0; k < count; ++k) {
    TransferPanel panel{cutoff * k / count, cutoff * (k + 1) / count};
    panel.value = moments(panel.nodes()).col(0);
    function.panels.push_back(panel);
  }
  function.set_coefficients();
  return function;
}

}  // namespace

ApertureOtf::ApertureOtf(const Aperture& aperture) {
  if (const auto* circle = std::get_if<CircleAperture>(&aperture)) {
    outer_ = 0.5 * circle->diameter;
    breakpoints_ = {2 * outer_};
  } else if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture)) {
    outer_ = 0.5 * annulus->diameter;
    inner_ = 0.5 * annulus->inner_diameter;
    breakpoints_ = {outer_ - inner_, 2 * inner_, outer_ + inner_, 2 * outer_};
  } else if (const auto* rectangle = std::get_if<RectangleAperture>(&aperture)) {
    width_ = rectangle->width;
    height_ = rectangle->height;
    breakpoints_ = {width_, height_, std::hypot(width_, height_)};
  } else {
    breakpoints_ = {longest_distance(aperture)};
  }
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
  if (breakpoints_.front() == 0) breakpoints_.erase(breakpoints_.begin());
  const bool open = width_ > 0   ? height_ > 0
                    : outer_ > 0 ? outer_ > inner_ && inner_ >= 0
                                 : aperture_area(aperture) > 0;
  if (breakpoints_.empty() || !open || !std::isfinite(cutoff()))
    throw ComputationError("the aperture lets no light through: its lengths must be positive and finite");
  if (width_ == 0 && outer_ == 0)
    by_light_ = std::make_shared<const PanelFunction>(transfer_of_light(aperture, cutoff()));
}

double ApertureOtf::operator()(double x) const {
  if (x >= cutoff()) return 0;
  if (by_light_) return by_light_->at(x, by_light_->panel_at(x));
  if (width_ > 0) {
    const double from = x > width_ ? std::acos(width_ / x) : 0;
    const double to = x > height_ ? std::asin(height_ / x) : 0.5 * pi;
    const auto antiderivative = [&](double angle) {
      const double sine = std::sin(angle);
      return angle - x * sine / width_ + x * std::cos(angle) / height_ +
             0.5 * x * x * sine * sine / (width_ * height_);
    };
    return 2 / pi * (antiderivative(to) - antiderivative(from));
  }
  const double common = lens(outer_, outer_, x) - 2 * lens(outer_, inner_, x) + lens(inner_, inner_, x);
  return common / (pi * (outer_ - inner_) * (outer_ + inner_));
}

}  // namespace aberfit
