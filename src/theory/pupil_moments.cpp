#include "pupil_moments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <mutex>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "pupil_kernel.h"
#include "pupil_light.h"
#include "pupil_overlap.h"

namespace aberfit::internal {
namespace {

// Largest error of H by polynomials over the aperture, at the worst shear.
constexpr double kInterpolation = 2e-6, kInterpolationByLight = 2e-5;
constexpr double kOverlapMissed = 1e-11;   // largest error of panels of an overlap
constexpr double kRoundingOfDisc = 1e-14;  // rounding of a sum over the points of a disc, over its area
// Largest phase change [rad] across an overlap for which its integral takes only tenths of a second.
constexpr double kMostTurn = 1500;
// Grid points across a pupil: at least, and per wave of the steepest phase slope times the diameter.
constexpr int kFewestPupilCells = 256;
constexpr double kCellsPerWave = 4;
constexpr double kStepOfCells = 1.19;  // ratio of successive grid sizes, so that planes can use the same grid
constexpr double kMostBytes = 2e9;     // memory of the transforms of one plane
constexpr double kKeptOfTransform = 0.35;
// Largest number of these waves over a round pupil; its Hankel transform then takes a second.
constexpr double kMostWavesOfRings = 20000;
constexpr std::size_t kMostKnown = 100;  // planes kept for a pupil
constexpr double kEndsPerOctave = 4;

// Number of nodes for which a polynomial meets exp(-E (1 + delta t)), t in [0, 1], for every E. Chebyshev's
// remainder (E delta)^n exp(-E) / (n! 2^(2n-1)) is largest at E = n.
int interpolation_order(double delta, double accuracy) {
  double factorial = 1;
  for (int n = 1; n < kHighestMomentOrder; ++n) {
    factorial *= n;
    if (n > 1 && std::pow(n * delta / std::exp(1.0), n) / (factorial * std::ldexp(1.0, 2 * n - 1)) < accuracy)
      return n;
  }
  return kHighestMomentOrder;
}

// Shears over the cutoff at which a part of the overlap of an annulus begins or ends.
std::vector<double> kinks(const PupilField& field) {
  if (!(field.inner() > 0)) return {1};
  const double e = field.inner() / field.outer();
  std::vector<double> result{0.5 * (1 - e), e, 0.5 * (1 + e), 1};
  std::sort(result.begin(), result.end());
  return result;
}

// Two points of the pupil; all lengths are over the focal length.
struct PairOfAngles {
  double midpoint2, along, shear, q1, q2;

  PairOfAngles(double square, double along2, double x)
      : midpoint2(square),
        along(std::sqrt(along2) * x),
        shear(x),
        q1(of_sine(square + 0.25 * x * x + along)),
        q2(of_sine(square + 0.25 * x * x - along)) {}
  static double of_sine(double square) { return 0.5 * (1 + std::sqrt(1 - square)); }
  double distance() const {  // on the mirror, where r = P/q
    const double mean = 0.5 * (1 / q1 + 1 / q2), change = 1 / q1 - 1 / q2;
    return std::sqrt(shear * shear * mean * mean + midpoint2 * change * change + 2 * along * mean * change);
  }
};

[[noreturn]] void refuse(double waves, double most, double dz) {
  throw ComputationError(fmt::format(
      "the phase across the aperture changes by up to {:.0f} waves in {}, too many for the mean spot by wave "
      "optics (at most {:.0f}); {}take a mirror nearer to its parabola, or `\"theory\": \"geometric\"` in "
      "`target`",
      waves,
      dz == 0 ? "the focus"
              : fmt::format("the plane {} from the focus", format_quantity(dz, Dimension::kLength)),
      most, dz == 0 ? "" : "request planes nearer to the focus, "));
}

[[noreturn]] void refuse_slender(const Aperture& aperture) {
  throw ComputationError(
      fmt::format("the edge of the aperture is {:.0f} times as long as that of a circle of its size and "
                  "area, which is too slender for the mean spot by wave optics; check its smaller side",
                  slenderness(aperture) / 4));
}

}  // namespace

struct PupilMoments::Known {
  std::mutex planes;
  std::map<std::pair<double, double>, std::shared_ptr<const MomentPanels>> panels;  // by dz and end
  std::mutex grids;
  std::map<int, std::unique_ptr<const PupilCells>> cells;
  std::map<std::pair<FocalGrid::Samples, double>, std::unique_ptr<const FocalGrid>>
      focal;  // by samples and taper
};

PupilMoments::PupilMoments(PupilField field, int halvings)
    : field_(std::move(field)), halvings_(halvings), basis_(1), known_(std::make_unique<Known>()) {
  const double rho2 = std::pow(field_.outer() / field_.focal_length(), 2), delta = rho2 / (1 - rho2);
  basis_ = MomentBasis(interpolation_order(delta, kInterpolation));
  degree_ = interpolation_order(delta, kInterpolationByLight) - 1;
  // Second-order effect of a shear on a pair of points. Lengths use a shear that is short enough for the next
  // order to vanish and long enough against rounding. The coherence is needed over all of the aperture. It
  // uses half of the longest shear, or less, so that both points still lie on the mirror.
  constexpr double kShort = 0.01, kSteepest = 0.95;  // over the focal length; sine
  const double rho = std::sqrt(rho2), far = std::clamp(2 * (kSteepest - rho), kShort, std::max(rho, kShort));
  const double per_f2 = 1 / std::pow(field_.focal_length(), 2);
  for (const double a : basis_.nodes) {
    const double c = std::sqrt(1 - a * rho2), q = 0.5 * (1 + c);
    share_.push_back(q * q);
    for (const double b : basis_.nodes) {
      stretch_.push_back(std::sqrt(1 + b * rho2 / (c * c)) / q);
      const PairOfAngles near(a * rho2, b * rho2, kShort), apart(a * rho2, b * rho2, far);
      bend_.push_back((near.distance() / (kShort * stretch_.back()) - 1) * per_f2 / (kShort * kShort));
      apart_.push_back(0.5 * std::pow(near.q1 - near.q2, 2) * per_f2 / (kShort * kShort));
      fall_.push_back(-std::log(apart.q1 * apart.q2 / (q * q)) * per_f2 / (far * far));
    }
  }
  whole_ = is_round() ? PupilOverlap(field_, 0, basis_)(0)
                      : LightMoments::whole(cells_for(0, cutoff()).mean(degree_), basis_);
}

PupilMoments::~PupilMoments() = default;

double PupilMoments::least_stretch() const { return *std::min_element(stretch_.begin(), stretch_.end()); }

double PupilMoments::most_stretch() const {
  double most = 1;
  for (std::size_t k = 0; k < stretch_.size(); ++k)
    most = std::max(most, stretch_[k] * (1 + bend_[k] * cutoff() * cutoff()));
  return most;
}

std::shared_ptr<const MomentPanels> PupilMoments::panels(double dz, double end) const {
  const double step = std::ceil(kEndsPerOctave * std::log2(std::min(end, 1.0)) - 1e-9);
  const std::pair<double, double> key{dz, std::min(1.0, std::exp2(step / kEndsPerOctave))};
  {
    const std::lock_guard lock(known_->planes);
    if (const auto found = known_->panels.find(key); found != known_->panels.end()) return found->second;
  }
  auto made = std::make_shared<const MomentPanels>(make(dz, key.second));
  const std::lock_guard lock(known_->planes);
  if (known_->panels.size() < kMostKnown) known_->panels.emplace(key, made);
  return made;
}

Eigen::ArrayXd PupilMoments::at(double x, double dz) const {
  if (by_overlap(dz, x)) return PupilOverlap(field_, dz, basis_)(x);
  return by_light(dz, x)(Eigen::ArrayXd::Constant(1, x)).row(0);
}

bool PupilMoments::by_overlap(double dz, double end) const {
  if (!is_round()) return false;
  return PupilOverlap(field_, dz, basis_).turn(end) <= kMostTurn;
}

const PupilCells& PupilMoments::cells_for(double dz, double end) const {
  const auto of = [this](int number) -> const PupilCells& {
    const std::lock_guard lock(known_->grids);
    std::unique_ptr<const PupilCells>& cells = known_->cells[number];
    if (!cells) cells = std::make_unique<const PupilCells>(field_, number);
    return *cells;
  };
  // Largest number that the memory for the field and its products with powers of u allows.
  const ApertureBox box = bounding_box(field_.aperture());
  const double across = 2 * aperture_radius(field_.aperture()), shear = end / cutoff();
  const double samples = ((box.x1 - box.x0) / across + shear) * ((box.y1 - box.y0) / across + shear);
  const double bytes = kKeptOfTransform * sizeof(std::complex<double>) * (2 * degree_ + 1) * samples;
  const double most = std::sqrt(kMostBytes / bytes) / kStepOfCells;
  const double slender = cells_for_edges(field_.aperture());
  if (slender > most) refuse_slender(field_.aperture());
  const int fewest = std::max(kFewestPupilCells, 2 * int(0.5 * slender));
  const double waves = of(fewest).steepest(dz) * cutoff(), most_waves = (most - fewest) / kCellsPerWave;
  if (waves > most_waves) refuse(waves, most_waves, dz);
  int number = fewest;
  do number = 2 * int(std::ceil(0.5 * kStepOfCells * number));
  while (number < fewest + kCellsPerWave * waves);
  return of(number);
}

LightMoments PupilMoments::by_light(double dz, double end) const {
  if (is_round()) {
    const double waves = field_.steepest(dz) / (2 * std::numbers::pi) * cutoff();
    if (waves > kMostWavesOfRings) refuse(waves, kMostWavesOfRings, dz);
    return {PupilLight::of_rings(field_, degree_, dz), basis_};
  }
  const PupilCells& cells = cells_for(dz, end);
  const double taper = FocalGrid::taper_for(cells, cells.steepest(dz));
  const auto grid = [&](const FocalGrid::Samples& samples) {
    const std::lock_guard lock(known_->grids);
    std::unique_ptr<const FocalGrid>& one = known_->focal[{samples, taper}];
    if (!one) one = std::make_unique<const FocalGrid>(samples, taper);
    return one.get();
  };
  const FocalGrid* of_segments =
      cells.segments().empty() ? nullptr : grid(FocalGrid::samples_for_segments(cells, end));
  return {PupilLight::of_cells(cells, *grid(FocalGrid::samples_for(cells, end)), of_segments, degree_, dz),
          basis_};
}

MomentPanels PupilMoments::make(double dz, double end) const {
  if (by_overlap(dz, end)) {
    std::vector<double> breakpoints;
    double from = 0;
    for (const double to : kinks(field_)) {
      for (int part = 1; part <= 1 << halvings_; ++part)
        breakpoints.push_back(from + (to - from) * part / (1 << halvings_));
      from = to;
    }
    const PupilOverlap overlap(field_, dz, basis_);
    // The area of a slender annulus is a small difference of two discs and has their rounding error.
    const double filled = 1 - std::pow(field_.inner() / field_.outer(), 2);
    return moment_panels([&](double s) { return overlap(s * cutoff()); }, breakpoints, end,
                         std::max(kOverlapMissed, kRoundingOfDisc / filled));
  }
  const LightMoments moments = by_light(dz, end * cutoff());
  const int count = (1 << halvings_) * std::max(1, int(std::ceil(end * cutoff() / moments.resolved())));
  MomentPanels made;
  Eigen::ArrayXd x(kPanelNodes * count);
  for (int k = 0; k < count; ++k) {
    made.push_back({end * k / count, end * (k + 1) / count, {}});
    x.segment(kPanelNodes * k, kPanelNodes) = cutoff() * TransferPanel{made.back().a, made.back().b}.nodes();
  }
  const Eigen::ArrayXXd all = moments(x);
  for (int k = 0; k < count; ++k) made[std::size_t(k)].value = all.middleRows(kPanelNodes * k, kPanelNodes);
  return made;
}

}  // namespace aberfit::internal
