#include "exact_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

constexpr double kGone = 45;                    // exponent from which exp(-E) counts as 0: 3e-20
constexpr double kAccuracyOfTable = 1e-12;      // Legendre tail of E, times exp(-E)
constexpr std::size_t kMostTablePanels = 3000;  // takes a few milliseconds for a closed form
constexpr double kSpotResolved = 1e-11;
constexpr double kNoOverlap = 1e-7;  // fraction of the aperture; below it a mean is rounding error
constexpr double kSeen = 1e-10;      // largest transfer allowed beyond the last shear
constexpr int kMostHalvings = 40;
constexpr std::size_t kMostPanels = 100'000;

double tail(const TransferPanel& panel) {
  return internal::unresolved(panel) * std::sqrt((panel.b - panel.a) / panel.b);
}

}  // namespace

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
  if (function_.panels[k].b < x[kPanelNodes - 1]) {  // the nodes lie on more than one panel
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

ExactTransfer::ExactTransfer(std::shared_ptr<const PupilMoments> pupil,
                             const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                             double limit, double uneven, SurfaceTransferOptions options)
    : pupil_(std::move(pupil)), limit_(limit), uneven_(uneven), smallest_(options.smallest) {
  options.cutoff = cutoff() * pupil_->most_stretch() * (1 + 1e-12);
  table_ = std::make_unique<const ExponentTable>(exponent, limit, options);
}

std::shared_ptr<const MomentPanels> ExactTransfer::moments(double dz) const {
  return pupil_->panels(dz, end());
}

// Shear, over the cutoff, beyond which the roughness leaves almost no transfer anywhere in the aperture.
double ExactTransfer::end() const {
  const double least_share = *std::min_element(pupil_->share().begin(), pupil_->share().end());
  return std::min(1.0, table_->beyond(-std::log(kSeen) / least_share) / (pupil_->least_stretch() * cutoff()));
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

// Panels of the moments, cut at `edges` [m on the mirror].
std::vector<TransferPanel> ExactTransfer::resolved(double dz, std::vector<double> edges,
                                                   const Part& part) const {
  const std::shared_ptr<const MomentPanels> all = moments(dz);
  const std::vector<double>& stretch = pupil_->stretch();
  const double middle = stretch[stretch.size() / 2] * cutoff();
  for (double& edge : edges) edge /= middle;
  std::vector<TransferPanel> result;
  std::size_t next = 0;
  for (const MomentPanel& panel : *all) {
    double from = panel.a;
    while (next < edges.size() && edges[next] <= from) ++next;
    // An edge of the table that is close to the end of this panel may be replaced by that end.
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
  auto panel = focus->begin(), known = focus->end();
  MomentPanel::Values legendre;  // coefficients of the panel `known`
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double s = x[k] / cutoff();
    while (panel != focus->end() && panel->b < s) ++panel;
    if (panel == focus->end() || s == 0) {
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
