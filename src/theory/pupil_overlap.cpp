#include "pupil_overlap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// Phase in rad that a rule of 24 nodes integrates to 1e-10 beside the smooth rest: J_48(8) = 3e-34 leaves the
// rest 16 degrees.
constexpr double kTurnOfRule = 16;
constexpr int kLong = 24;           // nodes of a rule on which the phase turns
constexpr int kRound = 14;          // nodes along a lens without phase, in the angle of its rim
constexpr int kAcross = 6;          // nodes across it: amplitudes are smooth in v^2
constexpr int kTrapezoid = 4;       // nodes along and across a trapezoid
constexpr double kSmallTurn = 2.5;  // rad that the nodes without phase carry, too
constexpr int kFewestOfInterval = 4, kMostOfInterval = 12;    // directions between those of two edges
constexpr int kFewestDirections = 24, kMostDirections = 256;  // of a round aperture's departure
constexpr std::size_t kMostPoints = 1'000'000;                // of one overlap

const Quadrature& unit_rule(int n) {
  static const std::vector<Quadrature> rules = [] {
    std::vector<Quadrature> all(kLong + 1);
    for (int k = 1; k <= kLong; ++k) all[std::size_t(k)] = gauss_legendre(k, 0.0, 1.0);
    return all;
  }();
  return rules[std::size_t(n)];
}

// Nodes on [0, 1] for a smooth function times a phase that turns by `turn`.
struct Line {
  std::vector<double> t, weight;
};
Line line(int smooth, double turn) {
  Line result;
  const int pieces = turn <= kSmallTurn ? 1 : 1 + int(turn / kTurnOfRule);
  const Quadrature& rule = unit_rule(turn <= kSmallTurn ? smooth : std::min(kLong, smooth + 6 + int(turn)));
  for (int p = 0; p < pieces; ++p)
    for (Eigen::Index k = 0; k < rule.nodes.size(); ++k) {
      result.t.push_back((p + rule.nodes[k]) / pieces);
      result.weight.push_back(rule.weights[k] / pieces);
    }
  return result;
}

// Under the arc of a circle, u from u1 to u2 and v from 0 up.
void append_arc(double radius, double centre, double u1, double u2, double sign, const Line& along,
                const Line& across, OverlapPoints* points) {
  if (!(u1 < u2)) return;
  const double start = std::acos(std::clamp((u2 - centre) / radius, -1.0, 1.0));
  const double end = std::acos(std::clamp((u1 - centre) / radius, -1.0, 1.0));
  for (std::size_t i = 0; i < along.t.size(); ++i) {
    const double angle = start + (end - start) * along.t[i], height = radius * std::sin(angle);
    for (std::size_t j = 0; j < across.t.size(); ++j) {
      points->u.push_back(centre + radius * std::cos(angle));
      points->v.push_back(height * across.t[j]);
      points->weight.push_back(sign * (end - start) * along.weight[i] * height * height * across.weight[j]);
    }
  }
}

struct Edge {
  double u1, v1, u2, v2;  // u1 < u2
  bool second;            // of the copy
  double at(double u) const { return v1 + (v2 - v1) * (u - u1) / (u2 - u1); }
};

void append_crossings(const std::vector<Edge>& edges, std::vector<double>* places) {
  for (const Edge& one : edges)
    for (const Edge& two : edges) {
      if (one.second || !two.second) continue;
      const double from = std::max(one.u1, two.u1), to = std::min(one.u2, two.u2);
      if (!(from < to)) continue;
      const double before = one.at(from) - two.at(from), after = one.at(to) - two.at(to);
      if ((before < 0) != (after < 0)) places->push_back(from + (to - from) * before / (before - after));
    }
}

void append_trapezoid(const Edge& low, const Edge& high, double u1, double u2, const Line& along,
                      const Line& across, OverlapPoints* points) {
  for (std::size_t i = 0; i < along.t.size(); ++i) {
    const double u = u1 + (u2 - u1) * along.t[i], bottom = low.at(u), height = high.at(u) - bottom;
    for (std::size_t j = 0; j < across.t.size(); ++j) {
      points->u.push_back(u);
      points->v.push_back(bottom + height * across.t[j]);
      points->weight.push_back((u2 - u1) * along.weight[i] * height * across.weight[j]);
    }
  }
}

}  // namespace

void OverlapPoints::clear() {
  u.clear();
  v.clear();
  weight.clear();
}

void append_round_overlap(double outer, double inner, double shear, const OverlapTurn& turn,
                          OverlapPoints* points) {
  const Line along = line(kRound, turn.along), across = line(kAcross, turn.across);
  const double end = outer - 0.5 * shear;
  append_arc(outer, -0.5 * shear, 0, end, 1, along, across, points);
  if (!(inner > 0)) return;
  const double crossing = shear > 0 ? (outer - inner) * (outer + inner) / (2 * shear) : 2 * outer;
  const double low = std::max(0.0, 0.5 * shear - inner), high = std::min(0.5 * shear + inner, end);
  append_arc(inner, 0.5 * shear, low, std::min(high, crossing), -1, along, across, points);
  if (crossing < high)
    append_arc(outer, -0.5 * shear, std::max(low, crossing), high, -1, along, across, points);
}

void append_polygon_overlap(const std::vector<PupilField::Point>& corners, double shear,
                            const OverlapTurn& turn, OverlapPoints* points) {
  std::vector<Edge> edges;
  std::vector<double> places;
  double least = 1e300, most = -1e300;
  for (const PupilField::Point& corner : corners) {
    least = std::min(least, corner[0]);
    most = std::max(most, corner[0]);
  }
  const double from = least + 0.5 * shear, to = most - 0.5 * shear, same = 1e-12 * (most - least);
  if (!(from < to)) return;
  for (const bool second : {false, true})
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double move = second ? 0.5 * shear : -0.5 * shear;
      PupilField::Point a = corners[i], b = corners[(i + 1) % corners.size()];
      if (a[0] > b[0]) std::swap(a, b);
      if (a[0] + move > from && a[0] + move < to) places.push_back(a[0] + move);
      if (b[0] + move > from && b[0] + move < to) places.push_back(b[0] + move);
      if (b[0] - a[0] > same) edges.push_back({a[0] + move, a[1], b[0] + move, b[1], second});
    }
  append_crossings(edges, &places);
  places.push_back(from);
  places.push_back(to);
  std::sort(places.begin(), places.end());
  std::vector<std::pair<double, const Edge*>> crossed;
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double u1 = places[i], u2 = places[i + 1], middle = 0.5 * (u1 + u2);
    if (!(u2 - u1 > same)) continue;
    crossed.clear();
    for (const Edge& edge : edges)
      if (edge.u1 < middle && edge.u2 > middle) crossed.emplace_back(edge.at(middle), &edge);
    std::sort(crossed.begin(), crossed.end());
    const double part = (u2 - u1) / (to - from);
    const Line along = line(kTrapezoid, part * turn.along);
    bool inside[2] = {false, false};
    for (std::size_t k = 0; k + 1 < crossed.size(); ++k) {
      inside[crossed[k].second->second] ^= true;
      if (inside[0] && inside[1] && crossed[k + 1].first > crossed[k].first)
        append_trapezoid(*crossed[k].second, *crossed[k + 1].second, u1, u2, along,
                         line(kTrapezoid, turn.across), points);
    }
  }
}

std::vector<PupilField::Point> in_frame(const std::vector<PupilField::Point>& corners, double direction) {
  std::vector<PupilField::Point> turned;
  const double cosine = std::cos(direction), sine = std::sin(direction);
  for (const PupilField::Point& corner : corners)
    turned.push_back({cosine * corner[0] + sine * corner[1], cosine * corner[1] - sine * corner[0]});
  return turned;
}

PupilOverlap::PupilOverlap(const PupilField& field, double dz, int order)
    : field_(field), dz_(dz), order_(order), has_phase_(dz != 0 || field.has_departure()) {
  for (int i = 0; i < order; ++i) nodes_.push_back(0.5 - 0.5 * std::cos(pi * (i + 0.5) / order));
  for (int i = 0; i < order; ++i) {
    double product = 1;
    for (int k = 0; k < order; ++k)
      if (k != i) product *= nodes_[std::size_t(i)] - nodes_[std::size_t(k)];
    denominators_.push_back(1 / product);
  }
  azimuths_ = {{0}, {1}};
  scale_ = 1 / at_direction(0, 0, {}).moment.sum();
  set_directions();
}

AzimuthRule azimuth_rule(std::vector<double> edges, double period, int wanted) {
  AzimuthRule result;
  if (edges.empty()) {  // smooth and periodic
    for (int k = 0; k < wanted; ++k) {
      result.direction.push_back(period * (k + 0.5) / wanted);
      result.weight.push_back(1.0 / wanted);
    }
    return result;
  }
  edges.push_back(edges.front() + period);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double width = edges[i + 1] - edges[i];
    int n = std::max(kFewestOfInterval, int(std::lround(wanted * width / period)));
    const int pieces = 1 + (n - 1) / kMostOfInterval;
    n = (n + pieces - 1) / pieces;
    const Quadrature& rule = unit_rule(n);
    for (int p = 0; p < pieces; ++p)
      for (int k = 0; k < n; ++k) {
        result.direction.push_back(edges[i] + width * (p + rule.nodes[k]) / pieces);
        result.weight.push_back(rule.weights[k] * width / (period * pieces));
      }
  }
  return result;
}

AzimuthRule polygon_azimuths(const std::vector<double>& edge_directions, int wanted) {
  // Edges in ever so many directions are as good as none.
  const bool many = int(edge_directions.size()) * kFewestOfInterval > 2 * wanted;
  return azimuth_rule(many ? std::vector<double>() : edge_directions, pi, wanted);
}

void PupilOverlap::set_directions() {
  const bool polygon = !field_.corners().empty();
  if (!polygon && field_.is_round()) return;
  const int turn_of_departure =
      field_.is_round() ? 0 : int(std::min(turn(cutoff()), double(kMostDirections)));
  const int wanted =
      std::min((polygon ? kDirectionsOfPolygon : kFewestDirections) + turn_of_departure, kMostDirections);
  if (!polygon)
    azimuths_ = azimuth_rule({}, pi, wanted);
  else if (field_.is_rectangle() && field_.is_round())  // a quarter turn holds all
    azimuths_ = azimuth_rule({0}, 0.5 * pi, wanted / 2);
  else
    azimuths_ = polygon_azimuths(field_.edge_directions(), wanted);
}

void PupilOverlap::append_points(double x, double direction, const OverlapTurn& turn,
                                 OverlapPoints* points) const {
  if (field_.corners().empty()) {
    append_round_overlap(field_.outer(), field_.inner(), x, turn, points);
    if (field_.is_round()) return;  // the other quarters are alike
    const std::size_t quarter = points->u.size();
    for (const auto& [across, along] : {std::pair{-1, 1}, {1, -1}, {-1, -1}})
      for (std::size_t k = 0; k < quarter; ++k) {
        points->u.push_back(along * points->u[k]);
        points->v.push_back(across * points->v[k]);
        points->weight.push_back(points->weight[k]);
      }
    return;
  }
  append_polygon_overlap(in_frame(field_.corners(), direction), x, turn, points);
}

PupilOverlap::Sums PupilOverlap::at_direction(double x, double direction, const OverlapTurn& turn) const {
  thread_local OverlapPoints points;
  thread_local std::vector<double> work;
  points.clear();
  append_points(x, direction, turn, &points);
  const std::size_t n = points.u.size();
  if (n > kMostPoints)
    throw ComputationError(
        "the aberrations of this mirror in this plane are too many waves for its mean spot");
  work.resize(9 * n);
  double *x1 = work.data(), *y1 = x1 + n, *x2 = y1 + n, *y2 = x2 + n, *c1 = y2 + n, *c2 = c1 + n,
         *wave1 = c2 + n, *wave2 = wave1 + n, *sine = wave2 + n;
  const double cosine = std::cos(direction), sin_direction = std::sin(direction);
  for (std::size_t k = 0; k < n; ++k) {
    const double before = points.u[k] - 0.5 * x, after = points.u[k] + 0.5 * x, v = points.v[k];
    x1[k] = cosine * after - sin_direction * v;
    y1[k] = sin_direction * after + cosine * v;
    x2[k] = cosine * before - sin_direction * v;
    y2[k] = sin_direction * before + cosine * v;
  }
  field_.cosine(x1, y1, int(n), c1);
  field_.cosine(x2, y2, int(n), c2);
  for (std::size_t k = 0; k < n; ++k)
    points.weight[k] *= 4 * scale_ / ((1 + c1[k]) * (1 + c2[k]) * std::sqrt(c1[k] * c2[k]));
  Sums sums{Eigen::ArrayXd::Zero(order_ * order_), {}};
  if (has_phase_ && x > 0) {
    field_.phase(dz_, x1, y1, int(n), wave1);
    field_.phase(dz_, x2, y2, int(n), wave2);
    double low = 1e300, high = -1e300, across = 0;
    for (std::size_t k = 0; k < n; ++k) {
      wave1[k] -= wave2[k];
      low = std::min(low, wave1[k]);
      high = std::max(high, wave1[k]);
      if (k > 0 && points.u[k] == points.u[k - 1])
        across = std::max(across, std::abs(wave1[k] - wave1[k - 1]));
    }
    sums.turn = {high - low, across};
    sin_cos(wave1, int(n), sine, wave2);
    for (std::size_t k = 0; k < n; ++k) points.weight[k] *= wave2[k];
  }
  const double inverse = 1 / (field_.outer() * field_.outer());
  std::array<double, 6> first{}, second{};
  for (std::size_t k = 0; k < n; ++k) {
    const double b = points.u[k] * points.u[k] * inverse, a = b + points.v[k] * points.v[k] * inverse;
    for (int i = 0; i < order_; ++i) {
      double one = points.weight[k] * denominators_[std::size_t(i)], two = denominators_[std::size_t(i)];
      for (int j = 0; j < order_; ++j)
        if (j != i) one *= a - nodes_[std::size_t(j)], two *= b - nodes_[std::size_t(j)];
      first[std::size_t(i)] = one;
      second[std::size_t(i)] = two;
    }
    for (int i = 0; i < order_; ++i)
      for (int j = 0; j < order_; ++j)
        sums.moment[i * order_ + j] += first[std::size_t(i)] * second[std::size_t(j)];
  }
  return sums;
}

Eigen::ArrayXd PupilOverlap::refined(double x, double direction) const {
  Sums sums = at_direction(x, direction, {});
  if (!has_phase_) return sums.moment;
  // Between the ends of a line the phase may turn back: half as much again. Neighbours across a line are a
  // sixth of it apart or more.
  const OverlapTurn turn{(field_.is_round() ? 1.0 : 1.5) * sums.turn.along, 5 * sums.turn.across};
  if (turn.along <= kSmallTurn && turn.across <= kSmallTurn) return sums.moment;
  return at_direction(x, direction, turn).moment;
}

Eigen::ArrayXd PupilOverlap::operator()(double x) const {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(order_ * order_);
  if (x >= cutoff()) return sum;
  for (std::size_t d = 0; d < azimuths_.direction.size(); ++d)
    sum += azimuths_.weight[d] * refined(x, azimuths_.direction[d]);
  return sum;
}

double PupilOverlap::turn(double end) const {
  if (!has_phase_) return 0;
  double most = 0;
  for (const double x : {0.25 * end, 0.5 * end, 0.75 * end, 0.25 * cutoff(), 0.5 * cutoff()})
    for (const double direction : {0.2, 1.0, 1.7, 2.6})
      if (x <= end) most = std::max(most, at_direction(x, direction, {}).turn.along);
  return most;
}

MomentPanel::Values MomentPanel::restricted(double from, double to) const {
  if (from == a && to == b) return value;
  const PanelRule& rule = panel_rule();
  const Eigen::Array<double, kPanelNodes, Eigen::Dynamic> c =
      (rule.legendre * value.matrix()).array();  // (l, moment)
  const PanelArray t = (from + to - a - b) / (b - a) + (to - from) / (b - a) * rule.t;
  PanelRule::Matrix p;  // (node, l)
  p.col(0).setOnes();
  p.col(1) = t.matrix();
  for (int l = 1; l + 1 < kPanelNodes; ++l)
    p.col(l + 1) = (((2 * l + 1) * t * p.col(l).array() - l * p.col(l - 1).array()) / (l + 1.0)).matrix();
  return (p * c.matrix()).array();
}

namespace {

constexpr int kMostMomentPanels = 3000;
// Where means over the azimuth have kinks of high order at shears that nobody lists, halving on is of no use.
constexpr int kHalvingsOfMean = 6, kHalvingsOfRound = 40;

}  // namespace

MomentPanels moment_panels(const PupilOverlap& overlap, const std::vector<double>& breakpoints, double end,
                           double tolerance, bool is_round) {
  MomentPanels result;
  struct Piece {
    double a, b;
    int halvings;
  };
  std::vector<Piece> pending;
  double from = 0;
  for (double to : breakpoints) {
    to = std::min(to, end);
    if (to > from) pending.push_back({from, to, 0});
    from = std::max(from, to);
  }
  const int most = is_round ? kHalvingsOfRound : kHalvingsOfMean;
  const PanelRule& rule = panel_rule();
  while (!pending.empty()) {
    const Piece piece = pending.back();
    pending.pop_back();
    MomentPanel panel{piece.a, piece.b, MomentPanel::Values(kPanelNodes, overlap.order() * overlap.order())};
    const PanelArray nodes = 0.5 * (piece.a + piece.b) + 0.5 * (piece.b - piece.a) * rule.t;
    for (int j = 0; j < kPanelNodes; ++j)
      panel.value.row(j) = overlap(overlap.cutoff() * nodes[j]).transpose();
    if (!panel.value.isFinite().all())
      throw ComputationError("the transfer function of this mirror is not finite in this plane");
    double missed = 0;
    for (Eigen::Index k = 0; k < panel.value.cols(); ++k)
      missed = std::max(missed, std::abs((panel.value.col(k) * rule.last).sum()) +
                                    std::abs((panel.value.col(k) * rule.last_but_one).sum()));
    missed *= std::sqrt((piece.b - piece.a) / piece.b);
    if (missed <= tolerance || piece.halvings >= most ||
        int(result.panels.size() + pending.size()) >= kMostMomentPanels) {
      if (missed > tolerance) result.unresolved = std::max(result.unresolved, missed);
      result.panels.push_back(std::move(panel));
      continue;
    }
    const double middle = 0.5 * (piece.a + piece.b);
    pending.push_back({piece.a, middle, piece.halvings + 1});
    pending.push_back({middle, piece.b, piece.halvings + 1});
  }
  std::sort(result.panels.begin(), result.panels.end(),
            [](const MomentPanel& one, const MomentPanel& two) { return one.a < two.a; });
  return result;
}

}  // namespace aberfit::internal
