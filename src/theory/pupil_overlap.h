#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "panel_rule.h"
#include "pupil_field.h"
#include "pupil_kernel.h"

namespace aberfit::internal {

/// Points of an overlap of the pupil with itself, in a frame whose first axis is the shear: midpoints of the
/// two pupil points, and weights [m^2].
struct OverlapPoints {
  std::vector<double> u, v, weight;
  void clear();
  /// By so many points; the first of them.
  std::size_t grow(std::size_t more);
};
/// How finely an overlap is sampled: the phase [rad] that turns along the shear and across it.
struct OverlapTurn {
  double along = 0, across = 0;
};

/// The overlap of two copies of an aperture, in pieces.
struct OverlapRegion {
  struct Arc {  ///< between a circle's upper half, from u1 to u2, and its diameter; added or taken off
    double radius, centre, u1, u2, sign;
  };
  struct Trapezoid {  ///< between two straight lines, from u1 to u2
    double u1, u2, low1, low2, high1, high2;
  };
  std::vector<Arc> arcs;
  std::vector<Trapezoid> trapezoids;
  double length = 0;  ///< of all trapezoids, along u
};
/// Of disc or annulus with itself at `shear` [m]: one quarter of it, u and v >= 0.
OverlapRegion round_overlap(double outer, double inner, double shear);
/// Of a simple polygon, all of it, cut where its outline or that of its copy has a corner or the two cross.
/// `corners` in the frame of the shear.
OverlapRegion polygon_overlap(const std::vector<PupilField::Point>& corners, double shear);
/// u >= 0 of a polygon's, which stands for all of it where aperture and wave are the same turned by half a
/// turn: the phase between the two pupil points changes its sign there, and its cosine does not.
OverlapRegion half_of(const OverlapRegion& region);
/// Gauss-Legendre points of a region; of_mean: fewer, for a mean over directions, which
/// is wanted to 1e-6 instead of 1e-11.
void append_points(const OverlapRegion& region, const OverlapTurn& turn, bool of_mean, OverlapPoints* points);
/// A few points that show how far a phase turns over it, three at each u; weights 0.
void append_probes(const OverlapRegion& region, OverlapPoints* points);

/// Points in a frame whose first axis has this direction [rad].
std::vector<PupilField::Point> in_frame(const std::vector<PupilField::Point>& corners, double direction);

/// Rule for a mean over the direction of the shear.
struct AzimuthRule {
  std::vector<double> direction, weight;  // [rad]; sums to 1
};
/// Gauss-Legendre between `edges` (ascending, less than `period` apart; none: equal steps), where the overlap
/// with the copy has a kink at every shear; about `wanted` directions in all.
AzimuthRule azimuth_rule(std::vector<double> edges, double period, int wanted);
inline constexpr int kDirectionsOfPolygon = 24;
/// Where the wave is none of a parabola in its focus, whose area alone a finer mean corrects: with 24
/// encircled energies of six apertures err by 3e-4 at half a wave and 3e-3 at ten, with 64 by 2e-6 and 2e-4.
inline constexpr int kDirectionsOfPhase = 64;
/// Where areas alone are averaged.
inline constexpr int kFineDirections = 96;
AzimuthRule polygon_azimuths(const std::vector<double>& edge_directions, int wanted);
/// Area of a polygon's overlap with itself, averaged over the azimuth [m^2].
double mean_overlap(const std::vector<PupilField::Point>& corners, const AzimuthRule& azimuths, double shear);

/// The autocorrelation of the pupil's field, split by where in the pupil: a function H of a = (|P| / outer)^2
/// of the midpoint and b = (its part along the shear / outer)^2 that is close to a polynomial has
///   int A(P + x/2) A*(P - x/2) H d2P / int |A|^2 d2P = sum_ij moment_ij(x) H(a_i, b_j),
/// averaged over the direction of the shear x, with a_i and b_j the `order` Chebyshev nodes of [0, 1]. The
/// moments hold no roughness: one set serves a plane. Real part, which is what encircled energy sees.
class PupilOverlap {
 public:
  /// `field` must outlive it. order 1 to kHighestMomentOrder.
  PupilOverlap(const PupilField& field, double dz, int order);

  /// For polygons: how a finer mean over azimuth differs, by the area alone. Tens of milliseconds; one set of
  /// them serves all planes whose mean is over the same directions.
  void set_correction();
  void copy_correction(const PupilOverlap& other) {
    if (other.azimuths_.direction == azimuths_.direction) correction_ = other.correction_;
  }

  int order() const { return order_; }
  const std::vector<double>& nodes() const { return nodes_; }
  /// order^2 moments at shear x >= 0 [m], i major. Safe from many threads. points: what it took is added.
  Eigen::ArrayXd operator()(double x, std::size_t* points = nullptr) const;
  /// How many points it takes at shear x >= 0 [m].
  std::size_t points(double x) const;
  /// Largest turn of the phase across the overlap at shears up to `end` [m], an estimate [rad].
  double turn(double end) const;
  double cutoff() const { return 2 * field_.outer(); }

 private:
  struct Work {  // of the two pupil points: places, product of amplitudes, difference of phases
    std::vector<double> x1, y1, x2, y2, amplitude, wave, scratch, cosine;
    void resize(std::size_t n);
  };
  OverlapRegion region(double x, double direction) const;
  void unfold(OverlapPoints* points) const;
  void sample(double x, double direction, OverlapPoints* points) const;
  void pupil_points(const OverlapPoints& points, double x, double direction, Work* work) const;
  void pupil_pairs(Work* work) const;
  OverlapTurn turn_of(const OverlapRegion& region, double x, double direction) const;
  Eigen::ArrayXd at_direction(double x, double direction, std::size_t* points = nullptr) const;
  Eigen::ArrayXd moments_of(const OverlapPoints& points) const;
  void set_directions();
  double correction_at(double x) const;

  const PupilField& field_;
  double dz_ = 0;
  int order_ = 1;
  bool has_phase_ = false;
  double scale_ = 1;  // 1 / int |A|^2 d2P
  std::vector<double> nodes_;
  Eigen::MatrixXd lagrange_;  // (i, p): of the Chebyshev polynomial p in the Lagrange polynomial of node i
  AzimuthRule azimuths_;
  std::vector<double> correction_;  // at equally spaced shears up to the cutoff; empty: none
};

/// Moments over [0, 1] of shear / cutoff as polynomials on panels.
struct MomentPanel {
  using Values = Eigen::Array<double, kPanelNodes, Eigen::Dynamic>;
  double a = 0, b = 0;
  Values value;  ///< (node, moment)

  /// At the nodes of [from, to] inside the panel.
  Values restricted(double from, double to) const;
  /// Legendre coefficients, (l, moment), and from them all moments at s inside the panel.
  Values legendre() const;
  Eigen::ArrayXd at(double s, const Values& legendre) const;
};
struct MomentPanels {
  std::vector<MomentPanel> panels;
  double unresolved = 0;  ///< largest Legendre tail left, of what the fading leaves, or share let go
  bool faded = false;     ///< the usual work did not suffice: they hold for their fading alone
};
/// How much of a mirror's transfer its roughness leaves at the shears of one set of moments.
class Fading {
 public:
  using Levels = std::array<double, 8>;
  static constexpr Levels kLevels{0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10};

  /// Nothing fades.
  Fading() { from_.fill(1); }
  /// Of the shares from which on at most kLevels of the transfer are left, over the cutoff, each rounded up.
  explicit Fading(const Levels& from) : from_(from) {}
  const Levels& from() const { return from_; }
  /// At most so much is left at shear / cutoff s and beyond.
  double left(double s) const;
  /// Shear / cutoff beyond which at most `share` is left.
  double beyond(double share) const;

 private:
  Levels from_;
};

/// How well moments are to be known, in Legendre tails.
struct MomentAccuracy {
  double tail;            ///< for the usual work, at every shear
  double enough;          ///< for more, of what the fading leaves
  std::size_t usual = 0;  ///< points of the pupil
};
inline constexpr std::size_t kUsualMomentPoints = 20'000'000;  // a third of a second
inline constexpr std::size_t kMostMomentPoints = 200'000'000;
inline constexpr double kMostUnresolved = 1e-4;  // of the light: a hundredth of a usual margin
/// Of `count` moments as a function of shear / cutoff, up to `end`, which is at most 1; panels bounded by the
/// overlap's kinks (`breakpoints`, ascending, the last one 1) and halved until the Legendre tail is small
/// enough, those first that miss most of what `fading` leaves; a mean over the azimuth (not `is_round`),
/// whose kinks are many and weak, only a few times. `moments` adds the points of the pupil that it took.
/// Where kMostMomentPoints of them are spent, shears that keep kMostUnresolved of the transfer at most are
/// let go. Throws ComputationError where they leave more than kMostUnresolved of the light.
using MomentFunction = std::function<Eigen::ArrayXd(double shear, std::size_t* points)>;
MomentPanels moment_panels(const MomentFunction& moments, int count, const std::vector<double>& breakpoints,
                           double end, const MomentAccuracy& accuracy, bool is_round,
                           const Fading& fading = {});

}  // namespace aberfit::internal
