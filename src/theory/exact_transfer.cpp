#include "exact_transfer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "far_overlap.h"

namespace aberfit::internal {
namespace {

constexpr double kGone = 45;                    // exponent whose transfer shows nowhere: 3e-20
constexpr double kAccuracyOfTable = 1e-12;      // Legendre tail of E, times exp(-E)
constexpr std::size_t kMostTablePanels = 3000;  // some milliseconds of a closed form
constexpr double kInterpolation = 2e-6;         // of H over the aperture, at the shear where it is largest
constexpr double kRoundMoments = 1e-11, kMeanMoments = 1e-6;
// Of the light, out of focus, where the mean would take more than the usual work.
constexpr double kMeanEnough = 2e-5;
constexpr double kRoundingOfDisc = 1e-14;  // of a sum over the points of a disc, over its area
constexpr double kSpotResolved = 1e-11;
constexpr double kNoOverlap = 1e-7;  // share of the aperture: a mean over less of it is rounding
constexpr int kMostHalvings = 40;
constexpr std::size_t kMostPanels = 100'000;
constexpr std::size_t kMostKnown = 100;  // planes of a pupil
constexpr double kEndsPerOctave = 4;
constexpr double kSameKink = 3e-3;  // of the cutoff
constexpr std::size_t kMostKinks = 8;
// Turn of the phase [rad] from which moments come by `FarOverlap`.
constexpr double kFarDefocus = 1500;
// Phase across the whole overlap of a wave of defocus: 2 W pi (1 - x/D) x/D at most.
constexpr double kTurnsPerWave = std::numbers::pi * 2;
// Means over the azimuth, which cost much, come by it wherever it errs by less; and all by less than the
// second where their integral would take too long.
constexpr double kErrorOfFar = 1e-4, kMostErrorOfFar = 1e-3;
// Of its phase a panel and its share of those that were halved carry so much [rad]: 4 to 9 for discs from f/8
// to f/1.3 and 100 to 1300 rad, 1 to 4 for annuli, 13 to 50 for hexagon and rectangle, whose tolerance is
// larger.
constexpr double kTurnOfDisc = 5, kTurnOfAnnulus = 2, kTurnOfMean = 25;
constexpr double kLargestOverlap = 0.3;  // of the longest shear, where the overlap takes most points or so
constexpr std::size_t kFewCorners = 24;  // whose overlap in closed form takes milliseconds
constexpr double kFarMean = 3e-5;        // means over azimuth are known to 2e-5 far out
// Turn of the overlap's phase, half of that from one end of the shears to the other, that a panel halved five
// times resolves to 1e-6: 15 rad for each of 32.
constexpr double kTurnOfHalved = 240;

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

// Two points of the pupil, lengths over the focal length: the square of their midpoint, that of its part
// along the shear, and the shear.
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

}  // namespace

void PanelFunction::set_coefficients() {
  for (const TransferPanel& panel : panels)
    legendre.push_back((panel_rule().legendre * panel.value.matrix()).array());
}

std::size_t PanelFunction::panel_at(double x) const {
  const auto panel = std::lower_bound(panels.begin(), panels.end(), x,
                                      [](const TransferPanel& one, double place) { return one.b < place; });
  return panel == panels.end() ? panels.size() - 1 : std::size_t(panel - panels.begin());
}

double PanelFunction::at(double x, std::size_t panel) const {
  const TransferPanel& here = panels[panel];
  const PanelArray& c = legendre[panel];
  const double t = std::clamp((2 * x - here.a - here.b) / (here.b - here.a), -1.0, 1.0);
  double sum = c[0] + c[1] * t, before = 1, last = t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double next = ((2 * l + 1) * t * last - l * before) / (l + 1);
    before = last;
    last = next;
    sum += c[l + 1] * next;
  }
  return sum;
}

PanelArray PanelFunction::at(const PanelArray& x, std::size_t panel) const {
  const TransferPanel& here = panels[panel];
  const PanelArray& c = legendre[panel];
  const PanelArray t = (2 * x - here.a - here.b) / (here.b - here.a);
  PanelArray before = PanelArray::Ones(), last = t;
  PanelArray result = c[0] + c[1] * t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double back = l / (l + 1.0);
    const PanelArray next = (1 + back) * t * last - back * before;
    before = last;
    last = next;
    result += c[l + 1] * next;
  }
  return result;
}

ExponentTable::ExponentTable(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                             double limit, const SurfaceTransferOptions& options) {
  const std::vector<double> edges = transfer_edges(exponent, limit, options);
  std::vector<TransferPanel> pending;
  const Eigen::ArrayXd at_edges =
      exponent(Eigen::Map<const Eigen::ArrayXd>(edges.data(), Eigen::Index(edges.size())));
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    int pieces = 1;
    const bool shows = edges[i] < options.widest_until && at_edges[Eigen::Index(i)] < kGone;
    while (shows && edges[i + 1] - edges[i] > pieces * options.widest) pieces *= 2;
    const double width = (edges[i + 1] - edges[i]) / pieces;
    for (int p = 0; p < pieces; ++p)
      pending.push_back({edges[i] + p * width, p + 1 == pieces ? edges[i + 1] : edges[i] + (p + 1) * width});
  }
  const auto missing = [&](TransferPanel* panel) {
    if (!panel->value.isFinite().all())
      throw ComputationError("the structure function of this PSD is not finite");
    const double least = panel->value.minCoeff(), core = std::exp(-least);
    const bool matters = least < kGone && panel->b - panel->a > options.smallest;
    return matters && tail(*panel) * core > kAccuracyOfTable ? internal::unresolved(*panel) * core : 0;
  };
  unresolved_ = refine(std::move(pending), kMostTablePanels, exponent, missing, &function_.panels);
  function_.set_coefficients();
  for (const TransferPanel& panel : function_.panels) {
    gone_.push_back(panel.value.minCoeff() >= kGone);
    if (!gone_.back()) end_ = panel.b;
  }
  if (!gone_.back()) end_ = kInfinity;
}

double ExponentTable::beyond(double exponent) const {
  double beyond = kInfinity;
  for (auto panel = function_.panels.rbegin(); panel != function_.panels.rend(); ++panel) {
    const PanelArray x = panel->nodes();
    for (int k = kPanelNodes - 1; k >= 0; --k) {
      if (panel->value[k] < exponent) return beyond;
      beyond = x[k];
    }
  }
  return beyond;
}

std::vector<double> ExponentTable::edges() const {
  std::vector<double> result;
  for (const TransferPanel& panel : function_.panels) result.push_back(panel.b);
  return result;
}

double ExponentTable::operator()(double x) const {
  const std::size_t k = function_.panel_at(x);
  return gone_[k] ? kInfinity : function_.at(x, k);
}

PanelArray ExponentTable::operator()(const PanelArray& x) const {
  const std::size_t k = function_.panel_at(x[0]);
  if (function_.panels[k].b < x[kPanelNodes - 1]) {  // more than one panel
    PanelArray result;
    for (int j = 0; j < kPanelNodes; ++j) result[j] = (*this)(x[j]);
    return result;
  }
  return gone_[k] ? PanelArray(PanelArray::Constant(kInfinity)) : function_.at(x, k);
}

ExponentChange::ExponentChange(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& change,
                               double uneven, const ExponentTable& table, double smallest)
    : uneven_(uneven) {
  std::vector<TransferPanel> pending;
  for (std::size_t k = 0; k < table.gone_.size(); ++k) {
    const TransferPanel& panel = table.function_.panels[k];
    pending.push_back({panel.a, panel.b});
  }
  const auto missing = [&](TransferPanel* panel) {
    if (!panel->value.isFinite().all())
      throw ComputationError("the structure function of this PSD has no finite derivative");
    const std::size_t k = table.function_.panel_at(0.5 * (panel->a + panel->b));
    const double core = std::exp(-table.function_.panels[k].value.minCoeff());
    const bool matters = !table.gone_[k] && panel->b - panel->a > smallest;
    return matters && tail(*panel) * core > kAccuracyOfTable ? internal::unresolved(*panel) * core : 0;
  };
  refine(std::move(pending), kMostTablePanels, change, missing, &function_.panels);
  function_.set_coefficients();
}

ExponentChange::ExponentChange(double proportion, double uneven, const ExponentTable& table)
    : function_(table.function_), uneven_(uneven) {
  for (TransferPanel& panel : function_.panels) panel.value *= proportion;
  for (PanelArray& coefficients : function_.legendre) coefficients *= proportion;
}

std::vector<double> ExponentChange::edges() const {
  std::vector<double> result;
  for (const TransferPanel& panel : function_.panels) result.push_back(panel.b);
  return result;
}

PanelArray ExponentChange::operator()(const PanelArray& x) const {
  const std::size_t k = function_.panel_at(x[0]);
  if (function_.panels[k].b >= x[kPanelNodes - 1]) return function_.at(x, k);
  return x.unaryExpr([&](double one) { return function_.at(one, function_.panel_at(one)); });
}

struct PupilMoments::Known {
  std::mutex mutex;
  struct Key {
    double dz, end;
    Fading::Levels fading;
    // NOLINTNEXTLINE(modernize-use-nullptr): the 0 that such a comparison is compared with is no pointer
    auto operator<=>(const Key&) const = default;
  };
  // Of the usual work, by from where roughness blurs alone; of more, by all of its fading.
  std::map<Key, std::shared_ptr<const MomentPanels>> usual, faded;
};

PupilMoments::PupilMoments(PupilField field, int halvings)
    : field_(std::move(field)), halvings_(halvings), known_(std::make_unique<Known>()) {
  const double rho2 = std::pow(field_.outer() / field_.focal_length(), 2);
  order_ = interpolation_order(rho2 / (1 - rho2));
  focus_overlap_ = std::make_unique<PupilOverlap>(field_, 0, order_);
  focus_overlap_->set_correction();
  // What a shear makes of a pair: of lengths from one so short that the next order does not show and rounding
  // neither, of coherence, which the rest of the aperture counts in, from one half of the longest where both
  // points are mirror still.
  constexpr double kShort = 0.01, kSteepest = 0.95;  // of the focal length; sine
  const double rho = std::sqrt(rho2), far = std::clamp(2 * (kSteepest - rho), kShort, std::max(rho, kShort));
  const double per_f2 = 1 / std::pow(field_.focal_length(), 2);
  for (const double a : focus_overlap_->nodes()) {
    const double c = std::sqrt(1 - a * rho2), q = 0.5 * (1 + c);
    share_.push_back(q * q);
    for (const double b : focus_overlap_->nodes()) {
      stretch_.push_back(std::sqrt(1 + b * rho2 / (c * c)) / q);
      const PairOfAngles near(a * rho2, b * rho2, kShort), apart(a * rho2, b * rho2, far);
      bend_.push_back((near.distance() / (kShort * stretch_.back()) - 1) * per_f2 / (kShort * kShort));
      apart_.push_back(0.5 * std::pow(near.q1 - near.q2, 2) * per_f2 / (kShort * kShort));
      fall_.push_back(-std::log(apart.q1 * apart.q2 / (q * q)) * per_f2 / (far * far));
    }
  }
  whole_ = (*focus_overlap_)(0);
}

PupilMoments::~PupilMoments() = default;

double PupilMoments::least_stretch() const { return *std::min_element(stretch_.begin(), stretch_.end()); }

double PupilMoments::most_stretch() const {
  double most = 1;
  for (std::size_t k = 0; k < stretch_.size(); ++k)
    most = std::max(most, stretch_[k] * (1 + bend_[k] * cutoff() * cutoff()));
  return most;
}

std::shared_ptr<const MomentPanels> PupilMoments::panels(double dz, double end, Fading::Levels fading) const {
  const auto rounded_up = [](double share) {
    const double step = std::ceil(kEndsPerOctave * std::log2(std::min(share, 1.0)) - 1e-9);
    return std::min(1.0, std::exp2(step / kEndsPerOctave));
  };
  const bool never_far = dz == 0 || field_.has_departure();
  for (double& from : fading) from = rounded_up(from);
  const Known::Key of_fading{dz, rounded_up(end), fading};
  Known::Key of_blurred{dz, rounded_up(end), {}};
  of_blurred.fading.fill(never_far ? 1 : Fading(fading).beyond(FarOverlap::kBlurred));
  {
    const std::lock_guard lock(known_->mutex);
    if (const auto found = known_->usual.find(of_blurred); found != known_->usual.end()) return found->second;
    if (const auto found = known_->faded.find(of_fading); found != known_->faded.end()) return found->second;
  }
  auto made = std::make_shared<const MomentPanels>(make(dz, of_fading.end, Fading(fading)));
  const std::lock_guard lock(known_->mutex);
  if (known_->usual.size() + known_->faded.size() < kMostKnown)
    (made->faded ? known_->faded : known_->usual).emplace(made->faded ? of_fading : of_blurred, made);
  return made;
}

Eigen::ArrayXd PupilMoments::at(double x, double dz) const {
  PupilOverlap overlap(field_, dz, order_);
  overlap.copy_correction(*focus_overlap_);
  return overlap(x);
}

// Without aberrations.
bool PupilMoments::is_far(const PupilOverlap& overlap, double turn, double dz, double end,
                          double blurred) const {
  if (turn > kFarDefocus) return true;
  const double error = FarOverlap::error(field_, dz, blurred * cutoff());
  if (error > kMostErrorOfFar || field_.straight_corners().size() > kFewCorners) return false;
  if (!is_round() && error < kErrorOfFar) return true;
  const double each = !is_round() ? kTurnOfMean : field_.inner() > 0 ? kTurnOfAnnulus : kTurnOfDisc;
  const double points = double(overlap.points(kLargestOverlap * std::min(end * cutoff(), field_.across())));
  return kPanelNodes * points * turn / each > double(kMostMomentPoints);
}

MomentPanels PupilMoments::make(double dz, double end, const Fading& fading) const {
  PupilOverlap overlap(field_, dz, order_);
  overlap.copy_correction(*focus_overlap_);
  std::vector<double> breakpoints = kinks(field_);
  double turn = overlap.turn(end * cutoff());
  const double whole_turn = turn;
  bool let_go = false;
  if (turn > kFarDefocus && field_.has_departure()) {
    const double seen = std::min(end, fading.beyond(kMostUnresolved));
    let_go = seen < end;
    end = seen;
    turn = overlap.turn(end * cutoff());
  }
  if (turn > kFarDefocus && field_.has_departure())
    throw ComputationError(fmt::format(
        "the aberrations of this mirror are {:.0f} waves in {}, too many for its mean spot in light (at most "
        "{:.0f}); take a mirror nearer to its parabola, or `\"theory\": \"geometric\"` in `target`",
        whole_turn / kTurnsPerWave,
        dz == 0 ? "the focus"
                : fmt::format("the plane {} from the focus", format_quantity(dz, Dimension::kLength)),
        kFarDefocus / kTurnsPerWave));
  if (!field_.has_departure() && is_far(overlap, turn, dz, end, fading.beyond(FarOverlap::kBlurred)))
    return far_moments(dz, end);
  int halvings = halvings_;
  if (!is_round())  // what is halved a few times only must turn little before
    for (double width = 1; width * turn > kTurnOfHalved; width *= 0.5) ++halvings;
  for (int h = 0; h < halvings; ++h) {
    std::vector<double> finer;
    double from = 0;
    for (const double to : breakpoints) finer.insert(finer.end(), {0.5 * (from + to), to}), from = to;
    breakpoints = finer;
  }
  MomentPanels made =
      moment_panels([&](double s, std::size_t* points) { return overlap(s * cutoff(), points); },
                    order_ * order_, breakpoints, end, accuracy(dz), is_round(), fading);
  if (let_go) {
    made.faded = true;
    made.unresolved = std::max(made.unresolved, kMostUnresolved);
  }
  return made;
}

// The area of a slender annulus is a small difference of two discs, and has their rounding.
// In the focus, where little light may be all that there is on the axis, the work is what it takes.
MomentAccuracy PupilMoments::accuracy(double dz) const {
  const double filled = 1 - std::pow(field_.inner() / field_.outer(), 2);
  const double tail = std::max(is_round() ? kRoundMoments : kMeanMoments, kRoundingOfDisc / filled);
  return {tail, std::max(tail, is_round() ? kRoundMoments : kMeanEnough),
          dz == 0 ? kMostMomentPoints : kUsualMomentPoints};
}

MomentPanels PupilMoments::far_moments(double dz, double end) const {
  const FarOverlap overlap(field_, dz, focus_overlap_->nodes(), whole_);
  std::vector<double> breakpoints = overlap.breakpoints();
  for (double& one : breakpoints) one /= cutoff();
  return moment_panels([&](double s, std::size_t*) { return overlap(s * cutoff()); }, order_ * order_,
                       breakpoints, std::min(end, breakpoints.back()),
                       is_round() ? accuracy(dz) : MomentAccuracy{kFarMean, kFarMean, kMostMomentPoints},
                       is_round());
}

ExactTransfer::ExactTransfer(std::shared_ptr<const PupilMoments> pupil,
                             const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                             double limit, double uneven, SurfaceTransferOptions options)
    : pupil_(std::move(pupil)), limit_(limit), uneven_(uneven), smallest_(options.smallest) {
  options.cutoff = cutoff() * pupil_->most_stretch() * (1 + 1e-12);
  table_ = std::make_unique<const ExponentTable>(exponent, limit, options);
}

std::shared_ptr<const MomentPanels> ExactTransfer::moments(double dz) const {
  const std::vector<double>& share = pupil_->share();
  const double least_share = *std::min_element(share.begin(), share.end());
  Fading::Levels fading;
  for (std::size_t k = 0; k < fading.size(); ++k)
    fading[k] =
        table_->beyond(-std::log(Fading::kLevels[k]) / least_share) / (pupil_->least_stretch() * cutoff());
  return pupil_->panels(dz, end(), fading);
}

// Shear beyond which the roughness has left no transfer anywhere in the aperture.
double ExactTransfer::end() const {
  return std::min(1.0, table_->end() / (pupil_->least_stretch() * cutoff()));
}

double ExactTransfer::part(int i, int j, double x, double shear) const {
  const PairOfPoints<double> pair = pair_at<double>(i, j, shear);
  return std::exp(-pair.exponent((*table_)(pair.stretch * x), uneven_));
}

PanelArray ExactTransfer::part(int i, int j, const PanelArray& x, bool scattered_only) const {
  const PairOfPoints<PanelArray> pair = pair_at<PanelArray>(i, j, x);
  const PanelArray e = pair.exponent((*table_)(PanelArray(pair.stretch * x)), uneven_);
  if (!scattered_only) return (-e).exp();
  const PanelArray limit = pair.exponent(PanelArray::Constant(limit_), uneven_);
  // Small differences from the core keep their digits; large limits have no core.
  if (limit.maxCoeff() < 30)
    return (-limit).exp() * (limit - e).unaryExpr([](double one) { return std::expm1(one); });
  return (-e).exp() - (-limit).exp();
}

void ExactTransfer::append(const MomentPanel& moments, double a, double b, int halvings, const Part& part,
                           std::vector<TransferPanel>* result) const {
  TransferPanel panel{a, b};
  const MomentPanel::Values moment = moments.restricted(a, b);
  const PanelArray x = cutoff() * panel.nodes();
  const int order = pupil_->order();
  for (int i = 0; i < order; ++i)
    for (int j = 0; j < order; ++j) panel.value += moment.col(i * order + j) * part(i, j, x);
  if (panel.value.abs().maxCoeff() < 1e-17) return;
  if (tail(panel) <= kSpotResolved || halvings >= kMostHalvings || result->size() >= kMostPanels) {
    result->push_back(panel);
    return;
  }
  append(moments, a, 0.5 * (a + b), halvings + 1, part, result);
  append(moments, 0.5 * (a + b), b, halvings + 1, part, result);
}

// On the moments' panels, cut at `edges` [m on the mirror].
std::vector<TransferPanel> ExactTransfer::resolved(double dz, std::vector<double> edges,
                                                   const Part& part) const {
  const std::shared_ptr<const MomentPanels> all = moments(dz);
  const std::vector<double>& stretch = pupil_->stretch();
  const double middle = stretch[stretch.size() / 2] * cutoff();
  for (double& edge : edges) edge /= middle;
  std::vector<TransferPanel> result;
  std::size_t next = 0;
  for (const MomentPanel& panel : all->panels) {
    double from = panel.a;
    while (next < edges.size() && edges[next] <= from) ++next;
    // A table's edge next to an end of this panel is as good as that end.
    for (; next < edges.size() && edges[next] < panel.b - 0.1 * (panel.b - from); ++next)
      if (edges[next] > from * (1 + 1e-6)) {
        append(panel, from, edges[next], 0, part, &result);
        from = edges[next];
      }
    append(panel, from, panel.b, 0, part, &result);
  }
  return result;
}

std::vector<TransferPanel> ExactTransfer::panels(double dz, bool scattered_only) const {
  return resolved(dz, table_->edges(),
                  [&](int i, int j, const PanelArray& x) { return part(i, j, x, scattered_only); });
}

std::vector<TransferPanel> ExactTransfer::change_panels(double dz, const ExponentChange& change) const {
  return resolved(dz, change.edges(), [&](int i, int j, const PanelArray& x) {
    const PairOfPoints<PanelArray> pair = pair_at<PanelArray>(i, j, x);
    const PanelArray r = pair.stretch * x, e = pair.exponent((*table_)(r), uneven_);
    return PanelArray(-pair.exponent(change(r), change.uneven()) * (-e).exp());
  });
}

ExponentChange ExactTransfer::change_of(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& change,
                                        double uneven) const {
  return ExponentChange(change, uneven, *table_, smallest_);
}

double ExactTransfer::at(double x, double dz) const { return interpolated(pupil_->at(x, dz), x, x); }

double ExactTransfer::interpolated(const Eigen::ArrayXd& moment, double x, double shear) const {
  double sum = 0;
  const int order = pupil_->order();
  for (int i = 0; i < order; ++i)
    for (int j = 0; j < order; ++j) sum += moment[i * order + j] * part(i, j, x, shear);
  return sum;
}

Eigen::ArrayXd ExactTransfer::mean_over_overlap(const Eigen::ArrayXd& x) const {
  Eigen::ArrayXd result(x.size());
  const std::shared_ptr<const MomentPanels> focus = moments(0);
  auto panel = focus->panels.begin(), known = focus->panels.end();
  MomentPanel::Values legendre;  // of the panel that is known
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double s = x[k] / cutoff();
    while (panel != focus->panels.end() && panel->b < s) ++panel;
    if (panel == focus->panels.end() || s == 0) {
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
    result[k] = interpolated(moment, x[k], x[k]) / all;
  }
  return result;
}

double ExactTransfer::core_share() const {
  double sum = 0;
  const int order = pupil_->order();
  for (int i = 0; i < order; ++i)
    for (int j = 0; j < order; ++j)
      sum += pupil_->whole()[i * order + j] * std::exp(-pupil_->share()[std::size_t(i)] * limit_);
  return sum;
}

double ExactTransfer::core_slope() const {
  double sum = 0;
  const int order = pupil_->order();
  for (int i = 0; i < order; ++i) {
    const double share = pupil_->share()[std::size_t(i)];
    sum += pupil_->whole().segment(i * order, order).sum() * share * std::exp(-share * limit_);
  }
  return sum;
}

}  // namespace aberfit::internal
