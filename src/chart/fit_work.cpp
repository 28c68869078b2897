#include "aberfit/chart/fit_work.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/forward/height_block_side.h"
#include "aberfit/forward/term_moments.h"
#include "aberfit/method/all_scatter.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judge.h"
#include "aberfit/method/prior_draws.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/term_search.h"
#include "aberfit/terms/operator_cost.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

// CPU seconds of `aberfit fit` on two AVX-512 cores, differences of runs of 2 and of 12 iterations and of
// whole fits of the studies of fits/ with 65536 to 262144 rays.
// Rays: one statistic, per ray, smooth with its gradient and exact; and what it costs however few rays.
constexpr double kSmoothStatistic = 1.7e-9, kExactStatistic = 3e-9, kStatistic = 1.5e-5;
constexpr double kTouched = 0.05;  // share of the rays that a gradient lists: `aberfit chart`
// Waves, divided by M^2 log2 M: a plane and a gradient in fits of the README's study (M = 274). A ring that
// is followed takes nine planes, one that is searched for some 45, without radii.
constexpr double kWavePlane = 1.5e-9, kWaveGradient = 6e-10, kFollowedRing = 9, kSearchedRing = 40;
// Of wide circles: transforms of half the length either way; of what is beside them, in single precision,
// 0.49 to 0.7 on 400 to 1500 cells. The width of a ring over its radius f/R (PHYSICS 5).
constexpr double kWidePlane = 0.26, kSinglePlane = 0.65, kGaussianRing = 2.80675977;
// Planes of a ring between which the mean spot of light beside the terms is interpolated.
constexpr double kRingMeans = 5;
// Of a draw, whose ring is followed from another mirror's [planes] (tests/stability).
constexpr double kDrawnRing = 15;
// Searches of radii and what else does not grow with the grid, per statistic: fits on 45 cells across with 20
// to 500 terms (tests/stability).
constexpr double kWaveStatistic = 8e-5;
// L^T of heights, per weight, point and term: a quarter of the terms at a quarter of the points.
constexpr double kHeightProduct = 5e-11, kFourierHeightProduct = 2e-10;
// Dense algebra, one thread: a QR with as many unknowns as statistics, and products with the terms.
constexpr double kQr = 1.6e-9, kProducts = 0.3e-9;  // per statistics^3, per statistics^2 terms
// Per statistic of the geometric theory; per plane of a mean spot, and a ring's planes.
constexpr double kTarget = 1.4e-4, kSpotPlane = 5e-4, kSpotRing = 45;
constexpr double kRaysOfTheory = 16 * 131072.0;  // theory `rays`, targets.cpp
constexpr double kPriorTerms = 432, kPrior = 5e-4;
// Fits by rays before one by waves on very many cells, each looked at in light, and their steps (seven scenes
// of tests/stability: 1 to 6, of 5 to 16).
constexpr double kFitsByRays = 4, kStepsByRays = 12;
constexpr double kScatterFunction = 0.25;               // with its ABg fits, one thread
constexpr int kRealisations = 32;                       // judge.cpp
constexpr double kZonePoint = 3e-9, kDrawnTerm = 6e-8;  // per draw

/// Statistics, and the planes they are looked at in; those of wide circles count as the share of their work.
struct Asked {
  double count = 0, dz = 0, rings = 0, gradients = 0;
  double moments = 0;       // of the terms' own points
  bool mean_angle = false;  // among them
  double means = 0;         // planes whose mean spot comes from narrow ones, where circles are wide
  double planes(double ring) const { return dz + ring * rings; }
};

// Radius of the circle that a target is about [m]; 0: something else. A ring's, from its width by the law of
// a Gaussian spot.
double circle_of(const Task& task, const Target& target) {
  if (std::holds_alternative<EncircledEnergyRadius>(target.statistic)) return target.value;
  if (const auto* circle = std::get_if<RingThrough>(&target.statistic)) return circle->ring_radius;
  if (std::holds_alternative<RingFwhm>(target.statistic))
    return target.value * aperture_radius(task.aperture) / (kGaussianRing * task.mirror.focal_length);
  return 0;
}

// wide: angle from which on circles are wide [rad]. single: in single precision.
Asked asked(const Task& task, double wide, bool single, const std::vector<const std::vector<Target>*>& sets) {
  struct Plane {
    double statistics = 0;
    bool wide = true;
  };
  std::map<double, Plane> planes;
  const double narrow_plane = single ? kSinglePlane : 1;
  Asked sum;
  for (const std::vector<Target>* targets : sets)
    for (const Target& target : *targets) {
      ++sum.count;
      const double dz = plane_of_light(target.statistic).value_or(0);
      const bool is_wide = circle_of(task, target) >= wide * (task.mirror.focal_length + dz);
      if (plane_of_light(target.statistic)) {
        Plane& plane = planes[dz];
        ++plane.statistics;
        plane.wide &= is_wide;
      } else if (kind_of(target.statistic).is_moment) {
        ++sum.moments;
        sum.mean_angle |= std::holds_alternative<ScatterMean>(target.statistic);
      } else {
        ++sum.gradients;
      }
      if (std::holds_alternative<RingFwhm>(target.statistic)) {
        sum.rings += is_wide ? kWidePlane : narrow_plane;
        if (is_wide) sum.means += kRingMeans * narrow_plane;
      }
    }
  for (const auto& [dz, plane] : planes) {
    const double share = plane.wide ? kWidePlane : narrow_plane;
    sum.dz += share;
    sum.gradients += share * plane.statistics;
    if (plane.wide && (dz == 0 || planes.size() <= kMostPlanesOfTheirOwn)) sum.means += narrow_plane;
  }
  return sum;
}

/// Points of height and angles, where light is by waves, and L there, one thread [s].
struct MomentWork {
  double points = 0, forward = 0, adjoint = 0;
};

/// What a surface goes through on the way to its statistics.
struct Optics {
  FocusModel model = FocusModel::kRays;
  double points = 0;                // of L
  double transform = 0;             // waves: M_x M_y log2, padded, times the pace
  double forward = 0, adjoint = 0;  // of L, one thread [s]
  double listed = 0;                // L^T at the rays that a ray statistic lists
  double height_product = 0;        // waves: L^T of one among many height weights
  double products = 1;              // WavePace
  MomentWork moments = {};
};

// Work of a transform of so many cells, padded to twice as many either way.
double transform_of(double columns, double rows) {
  return 2 * columns * rows * std::log2(4 * columns * rows);
}

double pace_of(const WavePace& pace, double transform) {
  const double small = transform_of(kSmallGrid, kSmallGrid), large = transform_of(kLargeGrid, kLargeGrid);
  const double part = std::log(transform / small) / std::log(large / small);
  return std::pow(pace.large, std::clamp(part, 0.0, 1.0));
}

// pace: of the terms.
Optics with_operator(Optics optics, const TermSet& terms, const PointLayout& layout, double pace = 1) {
  const OperatorChoice whole = choose_operator(terms, layout);
  const OperatorChoice scattered = choose_operator(terms, PointLayout{layout.points});
  optics.points = double(layout.points);
  optics.forward = pace * whole.forward_seconds;
  optics.adjoint = pace * whole.adjoint_seconds;
  optics.listed = pace * std::min(whole.adjoint_seconds, kTouched * scattered.adjoint_seconds);
  return optics;
}

Optics on_grid(const Task& task, const TermSet& terms, double pitch, const WavePace& pace) {
  Optics optics;
  optics.model = FocusModel::kWaves;
  const ApertureBox box = bounding_box(task.aperture);
  const double columns = std::max(2.0, std::ceil((box.x1 - box.x0) / pitch)),
               rows = std::max(2.0, std::ceil((box.y1 - box.y0) / pitch));
  optics.transform = transform_of(columns, rows);  // fast ones are up to 5 % longer
  optics.transform *= pace_of(pace, optics.transform);
  optics.products = pace.products;
  PointLayout layout;
  layout.rows = Eigen::Index(rows);
  layout.columns = Eigen::Index(columns);
  layout.points = std::max<Eigen::Index>(1, Eigen::Index(aperture_area(task.aperture) / (pitch * pitch)));
  const double side = height_block_side(terms, pitch, layout.points);
  // Of the cells, those within three blocks of the rim of Zernikes.
  const double at_rim =
      side > 1 && !terms.zernike.empty() ? std::min(1.0, 6 * side * pitch / terms.radius) : 0;
  optics.height_product =
      pace.products * double(layout.points) * (at_rim + (1 - at_rim) / (side * side)) *
      (kHeightProduct * double(terms.zernike.size()) + kFourierHeightProduct * double(terms.fourier.size()));
  return with_operator(optics, terms, layout, pace.terms);
}

// As WaveForward decides: on points of their own (moment_rays.h), which for plane waves in a polygon are
// fifty times the cells and the dearest part of a step, or on the cells.
MomentWork moment_work(const Task& task, const TermSet& terms, const Optics& optics, const Asked& wanted,
                       const WavePace& pace) {
  if (optics.model != FocusModel::kWaves || wanted.moments == 0) return {};
  const std::optional<PupilSample> pupil =
      wanted.mean_angle ? mean_angle_pupil(task.aperture, terms) : moment_pupil(task.aperture, terms);
  if (!pupil) return {optics.points, optics.forward, optics.adjoint};
  const OperatorChoice choice = choose_operator(terms, *pupil);
  return {double(pupil->size()), pace.terms * choice.forward_seconds, pace.terms * choice.adjoint_seconds};
}

double moments(const Optics& optics, const Asked& wanted) {
  return wanted.moments > 0
             ? optics.moments.forward + wanted.moments * optics.moments.points * kExactStatistic
             : 0;
}

// Values alone, of one surface, CPU seconds.
double values(const Optics& optics, const Asked& wanted) {
  if (optics.model == FocusModel::kWaves)
    return optics.forward + wanted.planes(kFollowedRing) * optics.transform * kWavePlane +
           moments(optics, wanted);
  return optics.forward + wanted.count * optics.points * kExactStatistic;
}

// Values and all gradients over the coefficients.
double linearisation(const Optics& optics, const Asked& wanted) {
  if (optics.model == FocusModel::kWaves)  // planes stay focused for the gradients
    return values(optics, wanted) + wanted.gradients * optics.transform * kWaveGradient +
           wanted.moments * optics.moments.adjoint +
           (wanted.count - wanted.moments) * (optics.height_product + kWaveStatistic);
  return optics.forward + wanted.count * (optics.points * kSmoothStatistic + kStatistic + optics.listed);
}

double algebra(const Optics& optics, double statistics, double terms) {
  const double pace = optics.products;
  if (terms > statistics + 1) return pace * statistics * statistics * (kQr * statistics + kProducts * terms);
  return pace * kQr * statistics * terms * terms;
}

// Once on each grid.
double mean_spots(const Groundwork& ground, const Optics& optics, const Asked& wanted) {
  const bool has_rest = ground.split && ground.split->has_rest();
  return has_rest ? wanted.means * optics.transform * kWavePlane : 0;
}

// The grid of `pitch`, three coarser ones, and one for the search of the rings.
double judged_by_waves(const Task& task, const Groundwork& ground, const TermSet& terms, const Asked& wanted,
                       double pitch, const WavePace& pace) {
  const Asked rings{0, 0, wanted.rings, 0};
  const Optics search = on_grid(task, terms, kSearchGrid * pitch, pace);
  Optics coarser = on_grid(task, terms, kCoarserGrid * pitch, pace),
         finest = on_grid(task, terms, pitch, pace);
  coarser.moments = finest.moments = moment_work(task, terms, finest, wanted, pace);
  return rings.planes(kSearchedRing) * search.transform * kWavePlane + 3 * values(coarser, wanted) +
         values(finest, wanted) + 3 * mean_spots(ground, coarser, wanted) +
         mean_spots(ground, finest, wanted);
}

// Scrambles and all of them together.
double judged_by_rays(const TermSet& terms, const Asked& wanted, double rays) {
  const auto points = Eigen::Index(std::min(rays, double(kMostFreshRays)));
  const Optics optics = with_operator({}, terms, PointLayout{points});
  return 2 * values(optics, wanted) - optics.forward;
}

// As judge_in_light (judge.cpp) decides.
double judgement(const Task& task, const Groundwork& ground, const TermSet& terms, const TargetSets& targets,
                 const WavePace& pace) {
  const bool given = targets.theory == "given";
  if (ground.use.in_light(given) || !ground.use.obstacle.empty()) return 0;
  const Asked wanted = asked(task, HUGE_VAL, false, {&targets.fitted});
  const double theory = given ? 0 : wanted.planes(kSpotRing) * kSpotPlane;
  try {
    const double pitch = wave_pitch(task, terms, targets.fitted, ground.split.get());
    const bool no_grid = 2 * ground.radius / pitch > kMostJudgedCells;
    return theory + (no_grid ? 0 : judged_by_waves(task, ground, terms, wanted, pitch, pace));
  } catch (const ComputationError&) {  // no grid holds the light: rays judge themselves
    return theory;
  }
}

// As realisation_of (judge.cpp) decides.
double realisations(const Task& task, const Groundwork& ground, const TermSet& terms, const Optics& optics) {
  const double share = ground.psd ? ground.numbers.realisation_spread / task.equivalence.margin : 0;
  if (!(share >= 0.5) || (share > 2 && optics.model == FocusModel::kRays) || !terms.fourier.empty()) return 0;
  return kRealisations * values(optics, {1, 1, 0, 1});
}

// How many draws make an interval as narrow as all_scatter.cpp asks for, where what is judged spreads by so
// many margins: Student's t of kScatterDraws over a quarter, squared.
double number_of_draws(double spread, double most) {
  constexpr double kPerSpread = 1.753 / 0.25;
  const double draws = kPerSpread * kPerSpread * spread * spread;
  return std::clamp(std::isfinite(draws) ? draws : 0.0, double(kScatterDraws), most);
}

// Height and angles, by default, but where few modes carry the roughness.
bool judges_moments(const TargetSets& targets) {
  const auto has = [](const std::vector<Target>& some) {
    return std::any_of(some.begin(), some.end(),
                       [](const Target& target) { return kind_of(target.statistic).is_moment; });
  };
  return has(targets.fitted) || has(targets.held_out);
}

// Light of drawn mirrors on many cells also takes mean spots of what lies beside the circles: three scenes of
// tests/stability took 2 to 4.3 times as long as their transforms.
constexpr double kBesideDrawn = 3;

double draws(const Task& task, const Groundwork& ground, const TargetSets& targets, const WavePace& pace) {
  if (!ground.all_scatters()) return 0;
  const std::shared_ptr<const BandSplit> split = drawn_split(task, ground);
  const TermSet waves = drawn_waves(task, ground, *split);
  const double wide = wide_circles(task, ground, targets, kWideShareOfVerdict);
  Optics optics = on_grid(task, waves, judging_pitch(task, waves, all_targets(targets), split.get()), pace);
  const bool single = in_single_precision(FocusModel::kWaves, targets, Eigen::Index(optics.points));
  const Asked judged = asked(task, wide, single, {&targets.fitted, &targets.held_out});
  optics.moments = moment_work(task, waves, optics, judged, pace);
  const double light = optics.forward + judged.planes(kDrawnRing) * optics.transform * kWavePlane +
                       judged.count * kWaveStatistic;
  const double surface = moments(optics, judged);
  const double mirrors = number_of_draws(ground.shares->spread, kMostScatterDraws);
  double surfaces = mirrors;
  if (judges_moments(targets))
    for (const double spread : {ground.shares->height_spread, ground.shares->slope_spread})
      surfaces = std::max(surfaces, number_of_draws(spread / task.equivalence.margin, kMostDrawnSurfaces));
  const bool beside = Eigen::Index(optics.points) >= kVeryManyCells && std::isfinite(wide);
  return mirrors * light * (beside ? kBesideDrawn : 1) + surfaces * surface;
}

double zones(const Task& task, const TermSet& terms) {
  const double points = zone_points(terms);
  if (points == 0) return 0;
  PointLayout layout{Eigen::Index(points)};
  if (task.aperture.index() < 2) {  // a polar rule, about twice as many spokes as rings
    layout.rings = std::max<Eigen::Index>(1, Eigen::Index(std::sqrt(points / 2) / 2));
    layout.spokes = 8 * std::max<Eigen::Index>(1, layout.points / (8 * layout.rings));
  }
  return double(law::kCharacterDraws) * (choose_operator(terms, layout).forward_seconds +
                                         points * kZonePoint + double(terms.size()) * kDrawnTerm);
}

double theory(const Task& task, const Groundwork& ground, const TargetSets& targets) {
  if (targets.theory == "given") return 0;
  const Asked wanted = asked(task, HUGE_VAL, false, {&targets.fitted, &targets.guides, &targets.held_out});
  if (ground.mean_spot) return wanted.planes(kSpotRing) * kSpotPlane;
  if (ground.use.theory == Theory::kRays) return wanted.count * kRaysOfTheory * kExactStatistic;
  return wanted.count * kTarget;
}

}  // namespace

double zone_points(const TermSet& terms) {
  if (terms.zernike.empty() && terms.fourier.empty()) return 0;
  const double order = terms.zernike.empty() ? 0 : terms.zernike.back().n;
  return std::clamp(4 * order * order, 4096.0, 65536.0);
}

double product_seconds(Eigen::Index points, Eigen::Index terms, int weights) {
  return kHeightProduct * double(points) * double(terms) * weights;
}

double wave_seconds(int across, int statistics) {
  return transform_of(across, across) * (kWavePlane + statistics * kWaveGradient);
}

FitWork fit_work(const Task& task, const Groundwork& ground, const TermSet& terms, const PupilOptions& rays,
                 const TargetSets& targets, int threads, const WavePace& pace) {
  const bool waves = ground.use.model == FocusModel::kWaves;
  Optics optics =
      waves
          ? on_grid(task, terms,
                    wave_pitch(task, terms, all_targets(targets), ground.split.get(), kFirstCoarsening), pace)
          : with_operator({}, terms, point_layout(make_pupil(task.aperture, rays)));
  const double wide = wide_circles(task, ground, targets, kWideShareOfFit),
               wide_for_verdict = wide_circles(task, ground, targets, kWideShareOfVerdict);
  const bool single = in_single_precision(ground.use.model, targets, Eigen::Index(optics.points));
  const Asked fitted = asked(task, wide, single, {&targets.fitted, &targets.guides});
  const Asked reported = asked(task, HUGE_VAL, single, {&targets.fitted}),
              judged = asked(task, wide_for_verdict, judged_in_single_precision(wide_for_verdict, targets),
                             {&targets.fitted, &targets.held_out});
  optics.moments = moment_work(task, terms, optics, fitted, pace);
  FitWork work;
  work.targets = theory(task, ground, targets) / threads;
  work.prior = kPrior * std::pow(double(terms.size()) / kPriorTerms, 1.5);
  // By waves each step has an evaluation for its bend.
  work.iteration = (linearisation(optics, fitted) + (waves ? values(optics, fitted) : 0)) / threads +
                   algebra(optics, fitted.count, double(terms.size()));
  if (begins_by_rays(task, ground, targets, Eigen::Index(optics.points), wide)) {
    const Optics by_rays = with_operator({}, terms, PointLayout{Eigen::Index(rays_that_lead(terms.size()))});
    work.led = kFitsByRays * (values(optics, fitted) / threads +
                              kStepsByRays * (pace.terms * linearisation(by_rays, fitted) / threads +
                                              algebra(optics, fitted.count, double(terms.size()))));
  }
  work.ends =
      (linearisation(optics, fitted) + 2 * values(optics, reported) + mean_spots(ground, optics, fitted)) /
      threads;
  work.fresh =
      (waves ? judged_by_waves(task, ground, terms, judged,
                               judging_pitch(task, terms, all_targets(targets), ground.split.get()), pace)
             : judged_by_rays(terms, judged, 4 * double(rays_of(rays)))) /
      threads;
  work.realisations = realisations(task, ground, terms, optics) / threads;
  work.judgement = judgement(task, ground, terms, targets, pace) / threads;
  work.zones = (waves ? pace.terms : 1) * zones(task, terms) / threads;
  work.draws = draws(task, ground, targets, pace) / threads;
  work.scatter = ground.split && ground.split->has_rest() ? kScatterFunction : 0;
  return work;
}

}  // namespace aberfit
