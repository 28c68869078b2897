#include "pupil_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "pupil_kernel.h"

namespace aberfit::internal {
namespace {

constexpr double kStraight = 2e-4;         // of the radius: departure of an edge's picture from its chord
constexpr double kSameDirection = 1e-6;    // rad
constexpr double kSamePlace = 1e-9;        // of the radius
constexpr int kMostPieces = 8;             // of one edge
constexpr double kSamePhase = 1e-9;        // rad, of points at one radius of a round surface
constexpr double kPolynomialPhase = 1e-6;  // rad, of a departure that is not round
constexpr double kRoundPhase = 1e-9;       // rad, of one that is
// Cells across the table of a departure that is not round: cubic interpolation errs by 0.023 cell^4 of the
// fourth derivative, 1e-5 of the amplitude for an aberration of radial order 8.
constexpr int kTable = 160;
constexpr int kMargin = 4;  // cells beyond the aperture

// P over r.
double conjugate(double rho, double focal_length) {
  const double t = 0.5 * rho / focal_length;
  return 1 / (1 + t * t);
}

}  // namespace

double longest_distance(const std::vector<PupilField::Point>& points) {
  double longest = 0;
  for (const PupilField::Point& one : points)
    for (const PupilField::Point& two : points)
      longest = std::max(longest, std::hypot(one[0] - two[0], one[1] - two[1]));
  return longest;
}

std::vector<double> edge_directions(const std::vector<PupilField::Point>& polygon) {
  std::vector<double> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PupilField::Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if (a == b) continue;
    double direction = std::atan2(b[1] - a[1], b[0] - a[0]);
    if (direction < 0) direction += std::numbers::pi;
    if (direction >= std::numbers::pi - kSameDirection) direction = 0;
    result.push_back(direction);
  }
  std::sort(result.begin(), result.end());
  const auto same = [](double one, double two) { return two - one < kSameDirection; };
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result;
}

PupilField::PupilField(const Mirror& mirror, const Aperture& aperture, double wavelength,
                       const Departure& departure)
    : focal_length_(mirror.focal_length), wavelength_(wavelength) {
  const double rim = aperture_radius(aperture);
  if (!(rim > 0 && rim < 2 * focal_length_ && aperture_area(aperture) > 0))
    throw ComputationError(fmt::format(
        "no light comes back to the focus: the aperture's radius is {} m, and must be above zero and below "
        "twice the focal length of {} m, where the mirror is 45 degrees steep",
        rim, focal_length_));
  if (!(rim < sag_domain_radius(mirror)))
    throw ComputationError(fmt::format("the mirror has no sag {} m off its axis", rim));
  is_parabola_ = !departure && is_parabola(mirror);
  if (!is_parabola_)
    departure_ = [mirror, departure](double x, double y) {
      const double own = base_surface(mirror, x, y).height - (x * x + y * y) / (4 * mirror.focal_length);
      return own + (departure ? departure(x, y) : 0.0);
    };
  outline(aperture);
  if (!is_parabola_) {
    for (const double part : {0.31, 0.77, 1.0})
      for (const double angle : {0.4, 1.3, 2.9, 4.4}) {
        const double first = departure_(part * rim, 0);
        const double here = departure_(part * rim * std::cos(angle), part * rim * std::sin(angle));
        if (!std::isfinite(first) || !std::isfinite(here))
          throw ComputationError(
              fmt::format("the mirror's height {} m off its axis is not a number", part * rim));
        if (std::abs(here - first) * 4 * std::numbers::pi / wavelength > kSamePhase) is_round_ = false;
      }
    if (is_round_) {
      even_ = EvenPolynomial::of([this](double p) { return departure_at(p, 0); }, outer_, kRoundPhase);
    } else {
      polynomial_ = DiscPolynomial::of([this](double x, double y) { return departure_at(x, y); }, outer_,
                                       kPolynomialPhase);
      if (!polynomial_) tabulate();
    }
  }
}

void PupilField::outline(const Aperture& aperture) {
  const double rim = aperture_radius(aperture);
  outer_ = rim * conjugate(rim, focal_length_);
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture)) {
    const double rho = 0.5 * annulus->inner_diameter;
    inner_ = rho * conjugate(rho, focal_length_);
  }
  is_rectangle_ = std::holds_alternative<RectangleAperture>(aperture);
  const std::vector<Point> polygon = aperture_corners(aperture);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (length == 0) continue;
    // The picture's largest departure from its chord: 1/(1 + t^2) along the edge is a parabola in the
    // position on it, to second order, of this sag.
    const double sag = std::pow(0.25 * length / focal_length_, 2) * rim;
    const int pieces = std::clamp(int(std::ceil(std::sqrt(sag / (kStraight * rim)))), 1, kMostPieces);
    for (int k = 0; k < pieces; ++k) {
      const double part = double(k) / pieces, x = a[0] + part * (b[0] - a[0]),
                   y = a[1] + part * (b[1] - a[1]);
      const double scale = conjugate(std::hypot(x, y), focal_length_);
      corners_.push_back({scale * x, scale * y});
      if (k == 0) straight_corners_.push_back(corners_.back());
    }
  }
  const auto has_opposite = [&](const Point& one) {
    return std::any_of(corners_.begin(), corners_.end(), [&](const Point& other) {
      return std::hypot(one[0] + other[0], one[1] + other[1]) < kSamePlace * outer_;
    });
  };
  is_point_symmetric_ = !corners_.empty() && std::all_of(corners_.begin(), corners_.end(), has_opposite);
  edge_directions_ = internal::edge_directions(polygon);
  across_ = polygon.empty() ? 2 * outer_ : longest_distance(straight_corners_);
}

double PupilField::departure_at(double x, double y) const {
  const double p2 = (x * x + y * y) / (focal_length_ * focal_length_), c = std::sqrt(1 - p2);
  const double scale = 2 / (1 + c);  // r over P
  return 2 * std::numbers::pi / wavelength_ * (1 + c) * departure_(scale * x, scale * y);
}

void PupilField::tabulate() {
  constexpr int kSide = kTable + 2 * kMargin + 1, kMiddle = kSide / 2;
  pitch_ = 2 * outer_ / kTable;
  table_ = Eigen::ArrayXXd::Zero(kSide, kSide);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double x = (i - kMiddle) * pitch_, y = (j - kMiddle) * pitch_;
      if (std::hypot(x, y) < std::min(outer_ + kMargin * pitch_, 0.999 * focal_length_)) {
        const double value = departure_at(x, y);
        if (std::isfinite(value)) table_(i, j) = value;
      }
    }
}

double PupilField::interpolated(double x, double y) const {
  const Eigen::Index row = table_.rows() / 2;
  const double middle = double(row);
  const auto weights =
      [](double t) {  // cubic through the four nearest, t in [0, 1] between the second and third
        return std::array<double, 4>{-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2,
                                     -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6};
      };
  const double u = x / pitch_ + middle, v = y / pitch_ + middle;
  const int i = std::clamp(int(u), 1, int(table_.rows()) - 3),
            j = std::clamp(int(v), 1, int(table_.cols()) - 3);
  const auto across = weights(u - i), along = weights(v - j);
  double sum = 0;
  for (int b = 0; b < 4; ++b) {
    const double* const column = &table_(i - 1, j - 1 + b);
    sum += along[std::size_t(b)] *
           (across[0] * column[0] + across[1] * column[1] + across[2] * column[2] + across[3] * column[3]);
  }
  return sum;
}

// One root and one division serve amplitude and defocus: 1 - c = p^2 / (1 + c), without cancellation.
void PupilField::pairs(double dz, const double* x1, const double* y1, const double* x2, const double* y2,
                       int n, double* amplitude, double* difference, double* scratch) const {
  const double scale = 1 / (focal_length_ * focal_length_);
  const double defocus = 2 * std::numbers::pi / wavelength_ * dz / (1 + dz / focal_length_);
  parabola_pairs(best_instruction_set(), scale, defocus, {x1, y1, x2, y2, n, amplitude, difference});
  if (is_parabola_) return;
  add_departure(x1, y1, n, difference);
  std::fill(scratch, scratch + n, 0.0);
  add_departure(x2, y2, n, scratch);
  for (int k = 0; k < n; ++k) difference[k] -= scratch[k];
}

void PupilField::add_departure(const double* x, const double* y, int n, double* result) const {
  if (even_) {
    even_->add(x, y, n, result);
  } else if (polynomial_) {
    polynomial_->add(x, y, n, result);
  } else if (!is_round_) {
    for (int k = 0; k < n; ++k) result[k] += interpolated(x[k], y[k]);
  } else {
    for (int k = 0; k < n; ++k) result[k] += departure_at(std::sqrt(x[k] * x[k] + y[k] * y[k]), 0);
  }
}

}  // namespace aberfit::internal
