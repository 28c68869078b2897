#include "pupil_overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// Phase in rad that a rule of 24 nodes, exact to degree 47, integrates beside a smooth rest of degree 8:
// J_40(14) = 5e-15.
constexpr double kTurnOfRule = 28;
constexpr int kLong = 24;           // nodes of a rule on which the phase turns
constexpr int kRound = 14;          // nodes along a lens without phase, in the angle of its rim
constexpr int kAcross = 6;          // nodes across it: amplitudes are smooth in v^2
constexpr int kTrapezoid = 4;       // nodes along and across a trapezoid
constexpr double kSmallTurn = 2.5;  // rad that the nodes without phase carry, too
// A finer mean over the azimuth of a polygon's area, at so many shears.
constexpr int kCorrections = 200;
constexpr std::size_t kMostCornersOfFine = 24;                // beyond, the outline is nearly round
constexpr double kTurnOfFew = 0.3;                            // rad that two or three nodes carry
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

// Nodes on [0, 1] for a smooth function times a phase that turns by `turn`. Of a mean over azimuth, which is
// wanted to 1e-6, those that leave J_k(turn / 2) near 1e-8, k = 2 n - 1 - 2 smooth: k = 11 at 1.3, 29 at 13;
// of all it is kLong at most, which for 14 nodes along a lens holds to a turn of 14: turns are overestimated
// by half (turn_of), and no mean has been seen to differ by more than 3e-6 of a radius.
struct Line {
  std::vector<double> t, weight;
};
Line line(int smooth, double turn, bool of_mean) {
  Line result;
  const double small = smooth >= kTrapezoid ? kSmallTurn : kTurnOfFew;
  const int pieces = turn <= small ? 1 : 1 + int(turn / kTurnOfRule);
  const double each = turn / pieces;
  const int turning = of_mean ? 4 + int(std::ceil(0.41 * each)) : 6 + int(turn);
  const Quadrature& rule = unit_rule(turn <= small ? smooth : std::min(kLong, smooth + turning));
  for (int p = 0; p < pieces; ++p)
    for (Eigen::Index k = 0; k < rule.nodes.size(); ++k) {
      result.t.push_back((p + rule.nodes[k]) / pieces);
      result.weight.push_back(rule.weights[k] / pieces);
    }
  return result;
}

// Points `across` a line of one u, of which v goes from `bottom` on; where the next ones begin.
std::size_t set_line(std::size_t at, double u, double bottom, double height, double weight,
                     const Line& across, OverlapPoints* points) {
  const std::size_t n = across.t.size();
  double *const to_u = &points->u[at], *const to_v = &points->v[at], *const to_weight = &points->weight[at];
  for (std::size_t j = 0; j < n; ++j) {
    to_u[j] = u;
    to_v[j] = bottom + height * across.t[j];
    to_weight[j] = weight * across.weight[j];
  }
  return at + n;
}

// Under the arc of a circle, u from u1 to u2 and v from 0 up.
void append_arc(const OverlapRegion::Arc& arc, const Line& along, const Line& across, OverlapPoints* points) {
  const double start = std::acos(std::clamp((arc.u2 - arc.centre) / arc.radius, -1.0, 1.0));
  const double end = std::acos(std::clamp((arc.u1 - arc.centre) / arc.radius, -1.0, 1.0));
  std::size_t at = points->grow(along.t.size() * across.t.size());
  for (std::size_t i = 0; i < along.t.size(); ++i) {
    const double angle = start + (end - start) * along.t[i], height = arc.radius * std::sin(angle);
    const double u = arc.centre + arc.radius * std::cos(angle);
    const double weight = arc.sign * (end - start) * along.weight[i] * height * height;
    at = set_line(at, u, 0, height, weight, across, points);
  }
}

void append_trapezoid(const OverlapRegion::Trapezoid& one, const Line& along, const Line& across,
                      OverlapPoints* points) {
  std::size_t at = points->grow(along.t.size() * across.t.size());
  for (std::size_t i = 0; i < along.t.size(); ++i) {
    const double t = along.t[i], bottom = one.low1 + t * (one.low2 - one.low1);
    const double height = one.high1 + t * (one.high2 - one.high1) - bottom;
    const double weight = (one.u2 - one.u1) * along.weight[i] * height;
    at = set_line(at, one.u1 + t * (one.u2 - one.u1), bottom, height, weight, across, points);
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

constexpr int kMostMomentPanels = 3000;
// Where means over the azimuth have kinks of high order at shears that nobody lists, halving on is of no use.
constexpr int kHalvingsOfMean = 5, kHalvingsOfRound = 40;

}  // namespace

void OverlapPoints::clear() {
  u.clear();
  v.clear();
  weight.clear();
}

std::size_t OverlapPoints::grow(std::size_t more) {
  const std::size_t before = u.size();
  for (std::vector<double>* one : {&u, &v, &weight}) one->resize(before + more);
  return before;
}

void PupilOverlap::Work::resize(std::size_t n) {
  for (std::vector<double>* one : {&x1, &y1, &x2, &y2, &amplitude, &wave, &scratch, &cosine}) one->resize(n);
}

OverlapRegion round_overlap(double outer, double inner, double shear) {
  OverlapRegion region;
  const auto add = [&](double radius, double centre, double u1, double u2, double sign) {
    if (u1 < u2) region.arcs.push_back({radius, centre, u1, u2, sign});
  };
  const double end = outer - 0.5 * shear;
  add(outer, -0.5 * shear, 0, end, 1);
  if (!(inner > 0)) return region;
  const double crossing = shear > 0 ? (outer - inner) * (outer + inner) / (2 * shear) : 2 * outer;
  const double low = std::max(0.0, 0.5 * shear - inner), high = std::min(0.5 * shear + inner, end);
  add(inner, 0.5 * shear, low, std::min(high, crossing), -1);
  if (crossing < high) add(outer, -0.5 * shear, std::max(low, crossing), high, -1);
  return region;
}

OverlapRegion polygon_overlap(const std::vector<PupilField::Point>& corners, double shear) {
  // A mean spot takes millions of these, and half of each would be memory.
  thread_local std::vector<Edge> edges;
  thread_local std::vector<double> places;
  thread_local std::vector<std::pair<double, const Edge*>> crossed;
  edges.clear();
  places.clear();
  OverlapRegion region;
  double least = 1e300, most = -1e300;
  for (const PupilField::Point& corner : corners) {
    least = std::min(least, corner[0]);
    most = std::max(most, corner[0]);
  }
  const double from = least + 0.5 * shear, to = most - 0.5 * shear, same = 1e-12 * (most - least);
  if (!(from < to)) return region;
  for (const bool second : {false, true})
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double move = second ? 0.5 * shear : -0.5 * shear;
      PupilField::Point a = corners[i], b = corners[(i + 1) % corners.size()];
      if (a[0] > b[0]) std::swap(a, b);
      if (a[0] + move > from && a[0] + move < to) places.push_back(a[0] + move);
      if (b[0] - a[0] > same) edges.push_back({a[0] + move, a[1], b[0] + move, b[1], second});
    }
  for (const PupilField::Point& corner : corners)  // right ends that no other edge begins at
    for (const double move : {-0.5 * shear, 0.5 * shear})
      if (corner[0] + move > from && corner[0] + move < to) places.push_back(corner[0] + move);
  append_crossings(edges, &places);
  places.push_back(from);
  places.push_back(to);
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end(), [&](double a, double b) { return b - a < same; }),
               places.end());
  region.trapezoids.reserve(places.size());
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double u1 = places[i], u2 = places[i + 1], middle = 0.5 * (u1 + u2);
    crossed.clear();
    for (const Edge& edge : edges)
      if (edge.u1 < middle && edge.u2 > middle) crossed.emplace_back(edge.at(middle), &edge);
    std::sort(crossed.begin(), crossed.end());
    bool inside[2] = {false, false};
    for (std::size_t k = 0; k + 1 < crossed.size(); ++k) {
      const Edge &low = *crossed[k].second, &high = *crossed[k + 1].second;
      inside[low.second] ^= true;
      if (inside[0] && inside[1])
        region.trapezoids.push_back({u1, u2, low.at(u1), low.at(u2), high.at(u1), high.at(u2)});
    }
  }
  region.length = to - from;
  return region;
}

OverlapRegion half_of(const OverlapRegion& region) {
  OverlapRegion half;
  half.length = 0.5 * region.length;
  for (OverlapRegion::Trapezoid one : region.trapezoids) {
    if (one.u2 <= 0) continue;
    if (one.u1 < 0) {
      const double part = -one.u1 / (one.u2 - one.u1);
      one.low1 += part * (one.low2 - one.low1);
      one.high1 += part * (one.high2 - one.high1);
      one.u1 = 0;
    }
    half.trapezoids.push_back(one);
  }
  return half;
}

void append_points(const OverlapRegion& region, const OverlapTurn& turn, bool of_mean,
                   OverlapPoints* points) {
  if (!region.arcs.empty()) {
    const Line along = line(kRound, turn.along, of_mean), across = line(kAcross, turn.across, of_mean);
    for (const OverlapRegion::Arc& arc : region.arcs) append_arc(arc, along, across, points);
  }
  if (region.trapezoids.empty()) return;
  const Line across = line(kTrapezoid, turn.across, of_mean);
  for (const OverlapRegion::Trapezoid& one : region.trapezoids) {
    const double part = (one.u2 - one.u1) / region.length;
    const int smooth = part > 0.3 ? kTrapezoid : part > 0.03 ? kTrapezoid - 1 : kTrapezoid - 2;
    append_trapezoid(one, line(smooth, part * turn.along, of_mean), across, points);
  }
}

void append_probes(const OverlapRegion& region, OverlapPoints* points) {
  const auto add = [&](double u, double v) {
    points->u.push_back(u);
    points->v.push_back(v);
  };
  if (!region.arcs.empty()) {
    const OverlapRegion::Arc& rim = region.arcs.front();
    for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const double u = part * rim.u2,
                   height = std::sqrt(std::max(0.0, rim.radius * rim.radius - std::pow(u - rim.centre, 2)));
      for (const double up : {0.0, 0.5, 0.9}) add(u, up * height);
    }
  }
  for (const OverlapRegion::Trapezoid& one : region.trapezoids)
    for (const double up : {0.0, 0.5, 1.0}) add(one.u1, one.low1 + up * (one.high1 - one.low1));
  if (!region.trapezoids.empty()) {
    const OverlapRegion::Trapezoid& last = region.trapezoids.back();
    for (const double up : {0.0, 0.5, 1.0}) add(last.u2, last.low2 + up * (last.high2 - last.low2));
  }
  points->weight.assign(points->u.size(), 0);
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
  // Lagrange's polynomials of these nodes are sums of Chebyshev's.
  lagrange_.resize(order, order);
  for (int i = 0; i < order; ++i)
    for (int p = 0; p < order; ++p)
      lagrange_(i, p) = (p == 0 ? 1.0 : 2.0) / order * std::cos(p * (pi - pi * (i + 0.5) / order));
  azimuths_ = {{0}, {1}};
  scale_ = 1 / at_direction(0, 0).sum();
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
  // A round wave does not tell the directions of a disc apart; those of a polygon it does.
  double turn_of_departure = 0;
  if (!field_.is_round()) {
    PupilOverlap in_focus = *this;
    in_focus.dz_ = 0;
    turn_of_departure = std::min(in_focus.turn(cutoff()), double(kMostDirections));
  }
  int wanted = (polygon ? kDirectionsOfPolygon : kFewestDirections) + int(turn_of_departure);
  if (polygon && has_phase_) wanted = std::max(wanted, kDirectionsOfPhase);
  wanted = std::min(wanted, kMostDirections);
  if (!polygon)
    azimuths_ = azimuth_rule({}, pi, wanted);
  else if (field_.is_rectangle() && field_.is_round())  // a quarter turn holds all
    azimuths_ = azimuth_rule({0}, 0.5 * pi, wanted / 2);
  else
    azimuths_ = polygon_azimuths(field_.edge_directions(), wanted);
}

double mean_overlap(const std::vector<PupilField::Point>& corners, const AzimuthRule& azimuths,
                    double shear) {
  double sum = 0;
  for (std::size_t d = 0; d < azimuths.direction.size(); ++d)
    for (const OverlapRegion::Trapezoid& one :
         polygon_overlap(in_frame(corners, azimuths.direction[d]), shear).trapezoids)
      sum += azimuths.weight[d] * 0.5 * (one.u2 - one.u1) * (one.high1 - one.low1 + one.high2 - one.low2);
  return sum;
}

// Between the directions of the edges the overlap's second derivative jumps wherever a corner crosses an
// edge, which a coarse mean takes for 1e-4 of the light in the focus. The area alone is cheap enough for a
// fine one, and the two means of it tell the error of the coarse one.
void PupilOverlap::set_correction() {
  const std::vector<PupilField::Point>& corners = field_.straight_corners();
  if (corners.empty() || corners.size() > kMostCornersOfFine) return;
  const AzimuthRule fine = field_.is_rectangle()
                               ? azimuth_rule({0}, 0.5 * pi, kFineDirections)
                               : polygon_azimuths(field_.edge_directions(), kFineDirections);
  correction_.assign(kCorrections + 1, 1);
  for (int k = 1; k < kCorrections; ++k) {
    const double x = cutoff() * k / kCorrections, coarse = mean_overlap(corners, azimuths_, x);
    correction_[std::size_t(k)] = coarse > 0 ? mean_overlap(corners, fine, x) / coarse : 1;
  }
  for (double& one : correction_) one = std::clamp(one, 0.5, 2.0);  // next to nothing is left at the cutoff
}

double PupilOverlap::correction_at(double x) const {
  const double place = std::min(x / cutoff() * kCorrections, kCorrections - 1e-9);
  const std::size_t k = std::size_t(place);
  return correction_[k] + (place - double(k)) * (correction_[k + 1] - correction_[k]);
}

OverlapRegion PupilOverlap::region(double x, double direction) const {
  if (field_.corners().empty()) return round_overlap(field_.outer(), field_.inner(), x);
  const OverlapRegion all = polygon_overlap(in_frame(field_.corners(), direction), x);
  return field_.is_round() && field_.is_point_symmetric() ? half_of(all) : all;
}

// The other quarters of a round region, where the field differs there.
void PupilOverlap::unfold(OverlapPoints* points) const {
  if (!field_.corners().empty() || field_.is_round()) return;
  const std::size_t quarter = points->u.size();
  for (const auto& [along, across] : {std::pair{1, -1}, {-1, 1}, {-1, -1}})
    for (std::size_t k = 0; k < quarter; ++k) {
      points->u.push_back(along * points->u[k]);
      points->v.push_back(across * points->v[k]);
      points->weight.push_back(points->weight[k]);
    }
}

void PupilOverlap::pupil_points(const OverlapPoints& points, double x, double direction, Work* work) const {
  const std::size_t n = points.u.size();
  if (n > kMostPoints)
    throw ComputationError(
        "the aberrations of this mirror in this plane are too many waves for its mean spot in light; take a "
        "mirror nearer to its parabola, or `\"theory\": \"geometric\"` in `target`");
  work->resize(n);
  if (field_.is_round()) {  // all directions are one
    for (std::size_t k = 0; k < n; ++k) {
      work->x1[k] = points.u[k] + 0.5 * x;
      work->x2[k] = points.u[k] - 0.5 * x;
    }
    work->y1 = points.v;
    work->y2 = points.v;
    return;
  }
  const double cosine = std::cos(direction), sine = std::sin(direction);
  for (std::size_t k = 0; k < n; ++k) {
    const double before = points.u[k] - 0.5 * x, after = points.u[k] + 0.5 * x, v = points.v[k];
    work->x1[k] = cosine * after - sine * v;
    work->y1[k] = sine * after + cosine * v;
    work->x2[k] = cosine * before - sine * v;
    work->y2[k] = sine * before + cosine * v;
  }
}

void PupilOverlap::pupil_pairs(Work* work) const {
  field_.pairs(dz_, work->x1.data(), work->y1.data(), work->x2.data(), work->y2.data(), int(work->x1.size()),
               work->amplitude.data(), work->wave.data(), work->scratch.data());
}

OverlapTurn PupilOverlap::turn_of(const OverlapRegion& region, double x, double direction) const {
  thread_local OverlapPoints points;
  thread_local Work work;
  points.clear();
  append_probes(region, &points);
  unfold(&points);
  pupil_points(points, x, direction, &work);
  pupil_pairs(&work);
  // Each quarter of a round region has points of its own.
  const std::size_t quarters = field_.corners().empty() && !field_.is_round() ? 4 : 1;
  const std::size_t block = points.u.size() / quarters;
  double along = 0, across = 0;
  for (std::size_t q = 0; q < quarters; ++q) {
    double low = 1e300, high = -1e300;
    for (std::size_t k = q * block; k < (q + 1) * block; ++k) {
      low = std::min(low, work.wave[k]);
      high = std::max(high, work.wave[k]);
      if (k % 3 == 2)  // probes come by three of one u
        across = std::max({across, std::abs(work.wave[k] - work.wave[k - 1]),
                           std::abs(work.wave[k - 1] - work.wave[k - 2])});
    }
    along = block > 0 ? std::max(along, high - low) : 0;
  }
  if (!std::isfinite(along)) throw ComputationError("the wave in the pupil of this mirror is not finite");
  // Between the probes a phase without symmetry may turn back: half as much again.
  return {(field_.is_round() ? 1.1 : 1.5) * along, 2 * across};
}

void PupilOverlap::sample(double x, double direction, OverlapPoints* points) const {
  const OverlapRegion here = region(x, direction);
  points->clear();
  append_points(here, has_phase_ && x > 0 ? turn_of(here, x, direction) : OverlapTurn{},
                azimuths_.direction.size() > 1, points);
  unfold(points);
}

Eigen::ArrayXd PupilOverlap::at_direction(double x, double direction, std::size_t* taken) const {
  thread_local OverlapPoints points;
  thread_local Work work;
  const bool waves = has_phase_ && x > 0;
  sample(x, direction, &points);
  pupil_points(points, x, direction, &work);
  const std::size_t n = points.u.size();
  if (taken) *taken += n;
  pupil_pairs(&work);
  for (std::size_t k = 0; k < n; ++k) points.weight[k] *= scale_ * work.amplitude[k];
  if (waves) {
    sin_cos(work.wave.data(), int(n), work.scratch.data(), work.cosine.data());
    for (std::size_t k = 0; k < n; ++k) points.weight[k] *= work.cosine[k];
  }
  return moments_of(points);
}

Eigen::ArrayXd PupilOverlap::moments_of(const OverlapPoints& points) const {
  const double inverse = 1 / (field_.outer() * field_.outer());
  std::array<double, std::size_t(kHighestMomentOrder * kHighestMomentOrder)> sums;
  chebyshev_moments(best_instruction_set(), order_, points.u.data(), points.v.data(), points.weight.data(),
                    int(points.u.size()), inverse, sums.data());
  // i major, as the moments are: the transpose.
  const Eigen::Map<const Eigen::MatrixXd> by_chebyshev(sums.data(), order_, order_);
  const Eigen::MatrixXd by_lagrange = lagrange_ * by_chebyshev * lagrange_.transpose();
  return by_lagrange.reshaped().array();
}

Eigen::ArrayXd PupilOverlap::operator()(double x, std::size_t* points) const {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(order_ * order_);
  if (x >= cutoff()) return sum;
  for (std::size_t d = 0; d < azimuths_.direction.size(); ++d)
    sum += azimuths_.weight[d] * at_direction(x, azimuths_.direction[d], points);
  return correction_.empty() ? sum : Eigen::ArrayXd(sum * correction_at(x));
}

std::size_t PupilOverlap::points(double x) const {
  OverlapPoints points;
  std::size_t sum = 0;
  for (const double direction : azimuths_.direction) {
    sample(x, direction, &points);
    sum += points.u.size();
  }
  return sum;
}

double PupilOverlap::turn(double end) const {
  if (!has_phase_) return 0;
  double most = 0;
  const double longest = field_.across();
  end = std::min(end, longest);
  for (const double x : {0.25 * end, 0.5 * end, 0.75 * end, 0.25 * longest, 0.5 * longest})
    for (const double direction : {0.2, 1.0, 1.7, 2.6})
      if (x <= end) most = std::max(most, turn_of(region(x, direction), x, direction).along);
  return most;
}

MomentPanel::Values MomentPanel::restricted(double from, double to) const {
  if (from == a && to == b) return value;
  const PanelArray t = (from + to - a - b) / (b - a) + (to - from) / (b - a) * panel_rule().t;
  return (legendre_polynomials(t, kPanelNodes).matrix() * legendre().matrix()).array();
}

MomentPanel::Values MomentPanel::legendre() const { return (panel_rule().legendre * value.matrix()).array(); }

Eigen::ArrayXd MomentPanel::at(double s, const Values& c) const {
  const double t = (2 * s - a - b) / (b - a);
  double before = 1, last = t;
  Eigen::ArrayXd sum = c.row(0).transpose() + t * c.row(1).transpose();
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double next = ((2 * l + 1) * t * last - l * before) / (l + 1);
    before = last;
    last = next;
    sum += next * c.row(l + 1).transpose();
  }
  return sum;
}

double Fading::left(double s) const {
  double left = 1;
  for (std::size_t k = 0; k < kLevels.size(); ++k)
    if (s >= from_[k]) left = kLevels[k];
  return left;
}

double Fading::beyond(double share) const {
  for (std::size_t k = 0; k < kLevels.size(); ++k)
    if (kLevels[k] <= share) return from_[k];
  return 1;
}

MomentPanels moment_panels(const MomentFunction& moments, int count, const std::vector<double>& breakpoints,
                           double end, const MomentAccuracy& accuracy, bool is_round, const Fading& fading) {
  MomentPanels result;
  std::size_t points = 0;
  struct Piece {
    double a, b;
    int halvings;
    double missed;  // of the light, by the panel that it is a half of
    // What misses least comes last: where the work is spent, little is left.
    bool operator<(const Piece& other) const { return std::tie(missed, a) < std::tie(other.missed, other.a); }
  };
  std::priority_queue<Piece> pending;
  double from = 0;
  for (double to : breakpoints) {
    to = std::min(to, end);
    if (to > from) pending.push({from, to, 0, fading.left(from)});
    from = std::max(from, to);
  }
  const int most = is_round ? kHalvingsOfRound : kHalvingsOfMean;
  const PanelRule& rule = panel_rule();
  while (!pending.empty()) {
    const Piece piece = pending.top();
    pending.pop();
    MomentPanel panel{piece.a, piece.b, MomentPanel::Values(kPanelNodes, count)};
    const double left = fading.left(piece.a);
    if (points >= kMostMomentPoints && left <= kMostUnresolved) {
      panel.value.setZero();
      result.unresolved = std::max(result.unresolved, left);
      result.panels.push_back(std::move(panel));
      continue;
    }
    const PanelArray nodes = 0.5 * (piece.a + piece.b) + 0.5 * (piece.b - piece.a) * rule.t;
    for (int j = 0; j < kPanelNodes; ++j) panel.value.row(j) = moments(nodes[j], &points).transpose();
    if (!panel.value.isFinite().all())
      throw ComputationError("the transfer function of this mirror is not finite in this plane");
    double missed = 0;
    for (Eigen::Index k = 0; k < panel.value.cols(); ++k)
      missed = std::max(missed, std::abs((panel.value.col(k) * rule.last).sum()) +
                                    std::abs((panel.value.col(k) * rule.last_but_one).sum()));
    missed *= std::sqrt((piece.b - piece.a) / piece.b);
    const double of_light = missed * left;
    const bool spent = points >= kMostMomentPoints;
    if (spent && of_light > kMostUnresolved)
      throw ComputationError(
          "the mean spot in light is not known to 1e-4 with the work that it may take: the aperture is too "
          "slender, the aberrations of the mirror are too many waves, or the plane is too far out of its "
          "focus; take a simpler aperture or mirror, or `\"theory\": \"geometric\"` in `target`");
    const bool done = missed <= accuracy.tail || (points >= accuracy.usual && of_light <= accuracy.enough);
    if (done || piece.halvings >= most || spent ||
        int(result.panels.size() + pending.size()) >= kMostMomentPanels) {
      if (!done) result.unresolved = std::max(result.unresolved, of_light);
      result.panels.push_back(std::move(panel));
      continue;
    }
    const double middle = 0.5 * (piece.a + piece.b);
    pending.push({piece.a, middle, piece.halvings + 1, of_light});
    pending.push({middle, piece.b, piece.halvings + 1, of_light});
  }
  result.faded = points >= std::min(accuracy.usual, kMostMomentPoints);
  std::sort(result.panels.begin(), result.panels.end(),
            [](const MomentPanel& one, const MomentPanel& two) { return one.a < two.a; });
  return result;
}

}  // namespace aberfit::internal
