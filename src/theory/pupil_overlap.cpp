#include "pupil_overlap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "pupil_kernel.h"

namespace aberfit::internal {
namespace {

// Phase [rad] for 24 nodes, exact to degree 47, with a smooth factor of degree 8: J_40(14) = 5e-15.
constexpr double kTurnOfRule = 28;
constexpr int kLong = 24;           // nodes of a rule over which the phase changes
constexpr int kRound = 14;          // nodes along a lens without phase, in the angle of its rim
constexpr int kAcross = 6;          // nodes across it: amplitudes are smooth in v^2
constexpr double kSmallTurn = 2.5;  // phase [rad] that these nodes carry, too
constexpr double kTurnBetweenProbes = 1.1;

const Quadrature& unit_rule(int n) {
  static const std::vector<Quadrature> rules = [] {
    std::vector<Quadrature> all(kLong + 1);
    for (int k = 1; k <= kLong; ++k) all[std::size_t(k)] = gauss_legendre(k, 0.0, 1.0);
    return all;
  }();
  return rules[std::size_t(n)];
}

// Nodes on [0, 1] for a smooth function times a phase that changes by `turn` [rad].
Quadrature line(int smooth, double turn) {
  const int pieces = turn <= kSmallTurn ? 1 : 1 + int(turn / kTurnOfRule);
  const Quadrature& rule = unit_rule(turn <= kSmallTurn ? smooth : std::min(kLong, smooth + 6 + int(turn)));
  const Eigen::Index n = rule.nodes.size();
  Quadrature result{Eigen::ArrayXd(pieces * n), Eigen::ArrayXd(pieces * n)};
  for (int p = 0; p < pieces; ++p) {
    result.nodes.segment(p * n, n) = (p + rule.nodes) / pieces;
    result.weights.segment(p * n, n) = rule.weights / pieces;
  }
  return result;
}

}  // namespace

void PupilOverlap::Points::resize(std::size_t count) {
  for (std::vector<double>* one : {&u, &v, &weight}) one->resize(count);
}

PupilOverlap::PupilOverlap(const PupilField& field, double dz, const MomentBasis& basis)
    : field_(field), basis_(basis), dz_(dz) {
  scale_ = 1 / (*this)(0).sum();
}

// One quarter of the overlap of disc or annulus with its copy, u and v >= 0.
std::vector<PupilOverlap::Arc> PupilOverlap::arcs(double shear) const {
  const double outer = field_.outer(), inner = field_.inner();
  std::vector<Arc> all;
  const auto add = [&](double radius, double centre, double u1, double u2, double sign) {
    if (u1 < u2) all.push_back({radius, centre, u1, u2, sign});
  };
  const double end = outer - 0.5 * shear;
  add(outer, -0.5 * shear, 0, end, 1);
  if (!(inner > 0)) return all;
  const double crossing = shear > 0 ? (outer - inner) * (outer + inner) / (2 * shear) : 2 * outer;
  const double low = std::max(0.0, 0.5 * shear - inner), high = std::min(0.5 * shear + inner, end);
  add(inner, 0.5 * shear, low, std::min(high, crossing), -1);
  if (crossing < high) add(outer, -0.5 * shear, std::max(low, crossing), high, -1);
  return all;
}

void PupilOverlap::set_points(const std::vector<Arc>& arcs, const Turn& turn, Points* points) const {
  const Quadrature along = line(kRound, turn.along), across = line(kAcross, turn.across);
  points->resize(arcs.size() * std::size_t(along.nodes.size() * across.nodes.size()));
  std::size_t k = 0;
  for (const Arc& arc : arcs) {
    const double start = std::acos(std::clamp((arc.u2 - arc.centre) / arc.radius, -1.0, 1.0));
    const double end = std::acos(std::clamp((arc.u1 - arc.centre) / arc.radius, -1.0, 1.0));
    for (Eigen::Index i = 0; i < along.nodes.size(); ++i) {
      const double angle = start + (end - start) * along.nodes[i], height = arc.radius * std::sin(angle);
      const double u = arc.centre + arc.radius * std::cos(angle);
      const double weight = arc.sign * (end - start) * along.weights[i] * height * height;
      for (Eigen::Index j = 0; j < across.nodes.size(); ++j, ++k) {
        points->u[k] = u;
        points->v[k] = height * across.nodes[j];
        points->weight[k] = weight * across.weights[j];
      }
    }
  }
}

void PupilOverlap::set_pairs(const Points& points, double x, Pairs* pairs) const {
  const std::size_t n = points.u.size();
  for (std::vector<double>* one :
       {&pairs->x1, &pairs->x2, &pairs->amplitude, &pairs->wave, &pairs->scratch, &pairs->cosine})
    one->resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    pairs->x1[k] = points.u[k] + 0.5 * x;
    pairs->x2[k] = points.u[k] - 0.5 * x;
  }
  field_.pairs(dz_, pairs->x1.data(), points.v.data(), pairs->x2.data(), points.v.data(), int(n),
               pairs->amplitude.data(), pairs->wave.data(), pairs->scratch.data());
}

// We estimate the turn from a few points, three at each u.
PupilOverlap::Turn PupilOverlap::turn_of(const std::vector<Arc>& arcs, double x) const {
  const Arc& rim = arcs.front();
  thread_local Points probes;
  probes.resize(15);
  std::size_t at = 0;
  for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double u = part * rim.u2,
                 height = std::sqrt(std::max(0.0, rim.radius * rim.radius - std::pow(u - rim.centre, 2)));
    for (const double up : {0.0, 0.5, 0.9}) probes.u[at] = u, probes.v[at++] = up * height;
  }
  thread_local Pairs pairs;
  set_pairs(probes, x, &pairs);
  const auto [low, high] = std::minmax_element(pairs.wave.begin(), pairs.wave.end());
  Turn turn{*high - *low, 0};
  for (std::size_t k = 2; k < pairs.wave.size(); k += 3)
    turn.across = std::max({turn.across, std::abs(pairs.wave[k] - pairs.wave[k - 1]),
                            std::abs(pairs.wave[k - 1] - pairs.wave[k - 2])});
  if (!std::isfinite(turn.along))
    throw ComputationError("the wave in the pupil of this mirror is not finite");
  return {kTurnBetweenProbes * turn.along, 2 * turn.across};
}

Eigen::ArrayXd PupilOverlap::operator()(double x) const {
  const int order = basis_.order;
  if (x >= 2 * field_.outer()) return Eigen::ArrayXd::Zero(order * order);
  const std::vector<Arc> lens = arcs(x);
  const bool waves = x > 0 && (dz_ != 0 || field_.has_departure());
  thread_local Points all;
  set_points(lens, waves ? turn_of(lens, x) : Turn{}, &all);
  const std::size_t n = all.u.size();
  thread_local Pairs pairs;
  set_pairs(all, x, &pairs);
  for (std::size_t k = 0; k < n; ++k) all.weight[k] *= scale_ * pairs.amplitude[k];
  if (waves) {
    sin_cos(pairs.wave.data(), int(n), pairs.scratch.data(), pairs.cosine.data());
    for (std::size_t k = 0; k < n; ++k) all.weight[k] *= pairs.cosine[k];
  }
  Eigen::MatrixXd by_chebyshev(order, order);
  chebyshev_moments(best_instruction_set(), order, all.u.data(), all.v.data(), all.weight.data(), int(n),
                    1 / (field_.outer() * field_.outer()), by_chebyshev.data());
  return basis_.at_nodes(by_chebyshev.transpose());  // i major
}

double PupilOverlap::turn(double end) const {
  if (dz_ == 0 && !field_.has_departure()) return 0;
  const double longest = 2 * field_.outer();
  end = std::min(end, longest);
  double most = 0;
  for (const double x : {0.25 * end, 0.5 * end, 0.75 * end, 0.25 * longest, 0.5 * longest})
    if (x <= end) most = std::max(most, turn_of(arcs(x), x).along);
  return most;
}

}  // namespace aberfit::internal
