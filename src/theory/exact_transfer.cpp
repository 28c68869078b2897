#include "exact_transfer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/theory/aperture_otf.h"

namespace aberfit::internal {
namespace {

constexpr double kGone = 45;                    // exponent whose transfer shows nowhere: 3e-20
constexpr double kAccuracyOfTable = 1e-12;      // Legendre tail of E, times exp(-E)
constexpr std::size_t kMostTablePanels = 3000;  // some milliseconds of a closed form
constexpr double kInterpolation = 2e-6;         // of H over the aperture, at the shear where it is largest
constexpr double kRoundMoments = 1e-11, kMeanMoments = 1e-6;
constexpr double kRoundingOfDisc = 1e-14;  // of a sum over the points of a disc, over its area
constexpr double kSpotResolved = 1e-11;
constexpr double kNoOverlap = 1e-7;  // share of the aperture: a mean over less of it is rounding
constexpr int kMostHalvings = 40;
constexpr std::size_t kMostPanels = 100'000;
constexpr double kSameKink = 3e-3;  // of the cutoff
constexpr std::size_t kMostKinks = 8;
// Turn of the phase [rad] from which moments of a round pupil come by the stationary closed form.
constexpr double kFarDefocus = 1500;
// Phase across the whole overlap of a wave of defocus: 2 W pi (1 - x/D) x/D at most.
constexpr double kTurnsPerWave = std::numbers::pi * 2;
// Of a mean over azimuth, which costs much: where the phase turns further than the first [rad], and its share
// in the fourth power of p, about 1/16 of the second [rad], is small.
constexpr double kDefocusOfMean = 100, kParabolic = 4;

double tail(const TransferPanel& panel) {
  return internal::unresolved(panel) * std::sqrt((panel.b - panel.a) / panel.b);
}

// Nodes at which a polynomial meets exp(-E (1 + delta t)), t in [0, 1], for every E: Chebyshev's remainder
// (E delta)^n exp(-E) / (n! 2^(2n-1)) is largest at E = n.
int interpolation_order(double delta) {
  double factorial = 1;
  for (int n = 1; n < kHighestMomentOrder; ++n) {
    factorial *= n;
    if (n > 1 &&
        std::pow(n * delta / std::exp(1.0), n) / (factorial * std::ldexp(1.0, 2 * n - 1)) < kInterpolation)
      return n;
  }
  return kHighestMomentOrder;
}

// Shears over the cutoff at which an azimuth's overlap begins or ends somewhere: distances of corners, and of
// a corner from an edge it faces. Of polygons with many of them the mean is smooth enough without.
std::vector<double> kinks_of_polygon(const std::vector<PupilField::Point>& corners, double cutoff) {
  std::vector<double> shears;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const PupilField::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double ex = b[0] - a[0], ey = b[1] - a[1], length = std::hypot(ex, ey);
    for (const PupilField::Point& p : corners) {
      shears.push_back(std::hypot(p[0] - a[0], p[1] - a[1]));
      const double along = ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / length;
      if (along >= -kSameKink * length && along <= (1 + kSameKink) * length)
        shears.push_back(std::abs((p[0] - a[0]) * ey - (p[1] - a[1]) * ex) / length);
    }
  }
  for (double& shear : shears) shear /= cutoff;
  shears.push_back(1);
  std::sort(shears.begin(), shears.end());
  std::vector<double> result;
  for (const double shear : shears)
    if (shear > kSameKink && shear < 1 - kSameKink && (result.empty() || shear > result.back() + kSameKink))
      result.push_back(shear);
  if (result.size() > kMostKinks) result.clear();
  result.push_back(1);
  return result;
}

std::vector<double> kinks(const PupilField& field) {
  if (!field.straight_corners().empty()) return kinks_of_polygon(field.straight_corners(), 2 * field.outer());
  if (!(field.inner() > 0)) return {1};
  const double e = field.inner() / field.outer();
  std::vector<double> result{0.5 * (1 - e), e, 0.5 * (1 + e), 1};
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace

ExponentTable::ExponentTable(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                             double limit, const SurfaceTransferOptions& options) {
  const std::vector<double> edges = transfer_edges(exponent, limit, options);
  std::vector<TransferPanel> pending;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) pending.push_back({edges[i], edges[i + 1]});
  const auto missing = [&](TransferPanel* panel) {
    if (!panel->value.isFinite().all())
      throw ComputationError("the structure function of this PSD is not finite");
    const double least = panel->value.minCoeff(), core = std::exp(-least);
    const bool matters = least < kGone && panel->b - panel->a > options.smallest;
    return matters && tail(*panel) * core > kAccuracyOfTable ? internal::unresolved(*panel) * core : 0;
  };
  unresolved_ = refine(std::move(pending), kMostTablePanels, exponent, missing, &panels_);
  for (const TransferPanel& panel : panels_) {
    legendre_.push_back((panel_rule().legendre * panel.value.matrix()).array());
    gone_.push_back(panel.value.minCoeff() >= kGone);
    if (!gone_.back()) end_ = panel.b;
  }
  if (!gone_.back()) end_ = kInfinity;
}

std::vector<double> ExponentTable::edges() const {
  std::vector<double> result;
  for (const TransferPanel& panel : panels_) result.push_back(panel.b);
  return result;
}

double ExponentTable::operator()(double x) const {
  const auto panel = std::lower_bound(panels_.begin(), panels_.end(), x,
                                      [](const TransferPanel& one, double place) { return one.b < place; });
  const std::size_t k = panel == panels_.end() ? panels_.size() - 1 : std::size_t(panel - panels_.begin());
  if (gone_[k]) return kInfinity;
  const TransferPanel& here = panels_[k];
  const double t = std::clamp((2 * x - here.a - here.b) / (here.b - here.a), -1.0, 1.0);
  double sum = legendre_[k][0] + legendre_[k][1] * t, before = 1, last = t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double next = ((2 * l + 1) * t * last - l * before) / (l + 1);
    before = last;
    last = next;
    sum += legendre_[k][l + 1] * next;
  }
  return sum;
}

PanelArray ExponentTable::operator()(const PanelArray& x) const {
  const auto panel = std::lower_bound(panels_.begin(), panels_.end(), x[0],
                                      [](const TransferPanel& one, double place) { return one.b < place; });
  PanelArray result;
  if (panel == panels_.end() || panel->b < x[kPanelNodes - 1]) {  // more than one panel
    for (int j = 0; j < kPanelNodes; ++j) result[j] = (*this)(x[j]);
    return result;
  }
  const std::size_t k = std::size_t(panel - panels_.begin());
  if (gone_[k]) return PanelArray::Constant(kInfinity);
  const PanelArray t = (2 * x - panel->a - panel->b) / (panel->b - panel->a);
  PanelArray before = PanelArray::Ones(), last = t;
  result = legendre_[k][0] + legendre_[k][1] * t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double back = l / (l + 1.0);
    const PanelArray next = (1 + back) * t * last - back * before;
    before = last;
    last = next;
    result += legendre_[k][l + 1] * next;
  }
  return result;
}

ExactTransfer::ExactTransfer(PupilField field,
                             const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                             double limit, SurfaceTransferOptions options)
    : field_(std::move(field)), halvings_(options.halvings), limit_(limit) {
  const double rho2 = std::pow(field_.outer() / field_.focal_length(), 2);
  order_ = interpolation_order(rho2 / (1 - rho2));
  focus_overlap_ = std::make_unique<PupilOverlap>(field_, 0, order_);
  focus_overlap_->set_correction();
  const PupilOverlap& overlap = *focus_overlap_;
  double most = 1;
  for (const double a : overlap.nodes()) {
    const double c = std::sqrt(1 - a * rho2), q = 0.5 * (1 + c);
    share_.push_back(q * q);
    for (const double b : overlap.nodes()) {
      stretch_.push_back(std::sqrt(1 + b * rho2 / (c * c)) / q);
      most = std::max(most, stretch_.back());
    }
  }
  options.cutoff = cutoff() * most * (1 + 1e-12);
  table_ = std::make_unique<const ExponentTable>(exponent, limit, options);
  whole_ = overlap(0);
  focus_ = moments(0);
}

ExactTransfer::~ExactTransfer() = default;

double ExactTransfer::part(int i, int j, double x) const {
  return std::exp(-share_[std::size_t(i)] * (*table_)(stretch_[std::size_t(i * order_ + j)] * x));
}

PanelArray ExactTransfer::part(int i, int j, const PanelArray& x, bool scattered_only) const {
  const double share = share_[std::size_t(i)];
  const PanelArray e = share * (*table_)(PanelArray(stretch_[std::size_t(i * order_ + j)] * x));
  if (!scattered_only) return (-e).exp();
  const double limit = share * limit_, core = std::exp(-limit);
  // Small differences from the core keep their digits; large limits have no core.
  if (limit < 30) return e.unaryExpr([&](double one) { return core * std::expm1(limit - one); });
  return (-e).exp() - core;
}

MomentPanels ExactTransfer::moments(double dz) const {
  // Shears beyond which the roughness has left no transfer anywhere in the aperture.
  const double least = *std::min_element(stretch_.begin(), stretch_.end());
  const double end = std::min(1.0, table_->end() / (least * cutoff()));
  PupilOverlap overlap(field_, dz, order_);
  overlap.copy_correction(*focus_overlap_);
  std::vector<double> breakpoints = kinks(field_);
  const double turn = overlap.turn(end * cutoff());
  if (turn > kFarDefocus && field_.has_departure())
    throw ComputationError(
        fmt::format("the aberrations of this mirror are {:.0f} waves in the plane {:.4g} m from the focus, "
                    "too many for its "
                    "mean spot in light (at most {:.0f})",
                    turn / kTurnsPerWave, dz, kFarDefocus / kTurnsPerWave));
  const double rho2 = std::pow(field_.outer() / field_.focal_length(), 2);
  const bool nearly_parabolic = turn > kDefocusOfMean && turn * rho2 < kParabolic;
  if (!field_.has_departure() && (turn > kFarDefocus || (!is_round() && nearly_parabolic)))
    return far_moments(dz, breakpoints, end);
  for (int h = 0; h < halvings_; ++h) {
    std::vector<double> finer;
    double from = 0;
    for (const double to : breakpoints) finer.insert(finer.end(), {0.5 * (from + to), to}), from = to;
    breakpoints = finer;
  }
  return moment_panels([&](double s, std::size_t* points) { return overlap(s * cutoff(), points); },
                       order_ * order_, breakpoints, end, moment_accuracy(), is_round());
}

// The area of a slender annulus is a small difference of two discs, and has their rounding.
double ExactTransfer::moment_accuracy() const {
  const double filled = 1 - std::pow(field_.inner() / field_.outer(), 2);
  return std::max(is_round() ? kRoundMoments : kMeanMoments, kRoundingOfDisc / filled);
}

// Of a disc or annulus that is so far out of focus that points of equal phase are everywhere: a parabolic
// phase, which has its overlap in closed form, with the roughness's mean over the aperture.
MomentPanels ExactTransfer::far_moments(double dz, const std::vector<double>& breakpoints, double end) const {
  const double f = field_.focal_length(), rho2 = std::pow(field_.outer() / f, 2);
  const auto shape = [&]() -> Aperture {
    if (field_.is_rectangle()) {  // in closed form over the azimuth, too
      const PupilField::Point& corner = field_.straight_corners().front();
      return RectangleAperture{2 * std::abs(corner[0]), 2 * std::abs(corner[1])};
    }
    if (!field_.corners().empty()) return PolygonAperture{field_.corners()};
    if (field_.inner() > 0) return AnnulusAperture{2 * field_.outer(), 2 * field_.inner()};
    return CircleAperture{2 * field_.outer()};
  };
  const ApertureOtf otf(shape());
  // Of 1 - c over (P/f)^2 / 2, at the mean of (P/f)^2.
  const double steeper = 1 / std::sqrt(1 - 0.5 * rho2);
  const double curvature = 2 * std::numbers::pi * dz * steeper / (field_.wavelength() * f * (f + dz));
  const auto closed = [&](double s, std::size_t*) {
    return Eigen::ArrayXd(otf(s * cutoff(), curvature) * whole_);
  };
  return moment_panels(closed, int(whole_.size()), breakpoints, end, moment_accuracy(), is_round());
}

void ExactTransfer::append(const MomentPanel& moments, double a, double b, int halvings, bool scattered_only,
                           std::vector<TransferPanel>* result) const {
  TransferPanel panel{a, b};
  const MomentPanel::Values moment = moments.restricted(a, b);
  const PanelArray x = cutoff() * panel.nodes();
  for (int i = 0; i < order_; ++i)
    for (int j = 0; j < order_; ++j)
      panel.value += moment.col(i * order_ + j) * part(i, j, x, scattered_only);
  if (panel.value.abs().maxCoeff() < 1e-17) return;
  if (tail(panel) <= kSpotResolved || halvings >= kMostHalvings || result->size() >= kMostPanels) {
    result->push_back(panel);
    return;
  }
  append(moments, a, 0.5 * (a + b), halvings + 1, scattered_only, result);
  append(moments, 0.5 * (a + b), b, halvings + 1, scattered_only, result);
}

std::vector<TransferPanel> ExactTransfer::panels(double dz, bool scattered_only) const {
  const MomentPanels own = dz == 0 ? MomentPanels{} : moments(dz);
  const MomentPanels& all = dz == 0 ? focus_ : own;
  const double middle = stretch_[stretch_.size() / 2] * cutoff();
  std::vector<double> edges = table_->edges();
  for (double& edge : edges) edge /= middle;
  std::vector<TransferPanel> result;
  std::size_t next = 0;
  for (const MomentPanel& panel : all.panels) {
    double from = panel.a;
    while (next < edges.size() && edges[next] <= from) ++next;
    // A table's edge next to an end of this panel is as good as that end.
    for (; next < edges.size() && edges[next] < panel.b - 0.1 * (panel.b - from); ++next)
      if (edges[next] > from * (1 + 1e-6)) {
        append(panel, from, edges[next], 0, scattered_only, &result);
        from = edges[next];
      }
    append(panel, from, panel.b, 0, scattered_only, &result);
  }
  return result;
}

double ExactTransfer::at(double x, double dz) const {
  PupilOverlap overlap(field_, dz, order_);
  overlap.copy_correction(*focus_overlap_);
  return interpolated(overlap(x), x);
}

double ExactTransfer::interpolated(const Eigen::ArrayXd& moment, double x) const {
  double sum = 0;
  for (int i = 0; i < order_; ++i)
    for (int j = 0; j < order_; ++j) sum += moment[i * order_ + j] * part(i, j, x);
  return sum;
}

Eigen::ArrayXd ExactTransfer::mean_over_overlap(const Eigen::ArrayXd& x) const {
  Eigen::ArrayXd result(x.size());
  auto panel = focus_.panels.begin(), known = focus_.panels.end();
  MomentPanel::Values legendre;  // of the panel that is known
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double s = x[k] / cutoff();
    while (panel != focus_.panels.end() && panel->b < s) ++panel;
    if (panel == focus_.panels.end() || s == 0) {
      result[k] = mean_surface_transfer(x[k]);
      continue;
    }
    if (known != panel) legendre = panel->legendre(), known = panel;
    const Eigen::ArrayXd moment = panel->at(s, legendre);
    const double all = moment.sum();
    if (!(all > kNoOverlap)) {
      result[k] = mean_surface_transfer(x[k]);
      continue;
    }
    result[k] = interpolated(moment, x[k]) / all;
  }
  return result;
}

double ExactTransfer::core_share() const {
  double sum = 0;
  for (int i = 0; i < order_; ++i)
    for (int j = 0; j < order_; ++j)
      sum += whole_[i * order_ + j] * std::exp(-share_[std::size_t(i)] * limit_);
  return sum;
}

}  // namespace aberfit::internal
