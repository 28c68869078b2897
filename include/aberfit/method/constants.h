#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <numbers>

/// The constants of the method, each with its unit, the law it belongs to, the plateau over which results do
/// not change, and the program that showed it. Nothing else in the rooms `method` and `chart` decides by a
/// number of its own. A constant without a plateau says how it is derived, or that it is a convention.
namespace aberfit::law {

// How many terms.

/// Order of the Zernikes over 2 pi R f_c, f_c the cut: their own last frequency, (n + 1)/(2 pi R), lies a
/// tenth beyond the cut, so that the last bins below it keep their power: from 1.05 on the last quarter of an
/// octave has 0.999 of it and more, at 0.75 less than 0.7 (tests/method/plan_test.cpp). What truncation
/// leaves is too little to be given to the scatter.
inline constexpr double kOrderBeyondCut = 1.1;
/// Highest order that the law takes: up to there the polar operator and the full covariance take seconds.
/// Beyond it plane waves on the frequency grid are as good and faster.
inline constexpr int kLargestOrder = 100;
/// Most plane waves of the frequency grid that the law takes: 252 cycles across.
inline constexpr double kMostWaves = 1e5;
/// Growth of the order where a set turns out too few, a third more terms, and how often. A cut that is named
/// may lie as far from the end of the terms before a warning tells of it.
inline constexpr double kGrowth = 1.15;
inline constexpr int kMostGrowths = 2;
/// The fewest terms are found to within this factor of the order.
inline constexpr double kFewestWithin = 1.1;
/// Plane waves on log-uniform rings where a study names no number. A convention of study files.
inline constexpr int kUsualWaves = 400;
/// Order of the Zernikes of a map without a specification where a study names none: 231 terms, as many as
/// OpticStudio's Zernike surfaces take. A convention.
inline constexpr int kMapOrder = 20;
/// Points of a map at most, in the square around its aperture: 8,000 across. It bounds the memory of a map's
/// light, not its accuracy.
inline constexpr double kMostMapCells = 6.4e7;
/// Share of the slope variance that terms of a whole roughness may leave out: where a roughness without f_max
/// ends. Of a band the order does not depend on it, by less than 0.03 at n = 100; of a Gaussian PSD, whose
/// tail falls as exp(-(pi l f)^2), it moves by a quarter from 1e-2 to 1e-4 (tests/method/plan_test.cpp).
inline constexpr double kSlopeBeyondTerms = 1e-3;

// What is asked of a surface.

/// Fractions of the light and planes, in depths of focus, of the encircled energies that are fitted by
/// default, and those that are held out from the fit. A convention; the guides of rays lie in the middles
/// between the fitted ones.
inline constexpr double kFittedShares[] = {0.20, 0.35, 0.50, 0.65, 0.80, 0.90, 0.95};
inline constexpr double kFittedPlanes[] = {0, -1, 1, -2, 2, -3.5, 3.5, -5, 5};
inline constexpr double kHeldOutShares[] = {0.25, 0.30, 0.40, 0.60, 0.70, 0.75, 0.875, 0.925};
inline constexpr double kHeldOutPlanes[] = {0, -0.25, 0.25, -0.75, 0.75, -1.75, 1.75, -3.1, 3.1, -4.6, 4.6};
/// Tolerance of what guides a fit by waves between its targets, as a share of the margin (by rays a third of
/// it, of the usual margin): less than all of it, so that what lies between two guides is met as well. At
/// 0.5, 0.7 and 0.9 as many fits of README's mirror are equivalent to within one of 36 (guides 2 margins
/// apart, twelve margins, seeds 1 to 3, `fit`), in 173, 128 and 149 s.
inline constexpr double kGuideShareOfMargin = 0.9;
/// Guides of light lie so far apart that the grains of the pattern keep the light between two rings steady to
/// this many margins; and planes so far that the cone of light widens by this many such steps. README's
/// mirror at twelve margins from 0.3 to 10 %, seeds 1 to 7: 77 of 84 fits are equivalent at 2 and 4, 82
/// at 1.4 and 2.8, for 1.09 times the time; at 1 and 2 all 36 of seeds 1 to 3, as at 1.4 and 2.8
/// (`Along/Continuity` has one seed of them).
inline constexpr double kSteadyRing = 1.4, kSteadyPlane = 2.8;
/// Scales of the core (Groundwork::core_sigma) beyond which a ring is one of scattered light: it fades as far
/// out of focus, where terms have no say in it, while the grid has to follow the whole cone of light. A ring
/// takes 3 to 46 of them in mirrors whose rings are of use; without the rule two of eighteen scenes took 2.4
/// and 2.9 times as long.
inline constexpr double kHalo = 60;
/// Modes (N_eff) below which the mean light is no mirror's of the mean height: light is not linear in the
/// square of the height (Jensen), and its relative variance over mirrors is 1/N_eff.
inline constexpr double kFewModes = 10;
/// Closed forms are of first order in the slope; exact rays leave them by this times slope^2 of a radius
/// (PHYSICS 5; tests/stability/fast_mirror_edge_test.cpp).
inline constexpr double kSecondOrder = 4.6;
/// Light that no verdict sees: a tenth of the usual margin. So much of a mean transfer function half the
/// aperture away is no core; so much light may lie beyond the rays that a grid makes room for.
inline constexpr double kUnseenLight = 1e-3;
/// 4 pi sigma/lambda of a surface that stands for none: it scatters the square of this, the rounding of
/// double precision.
inline constexpr double kSmoothG = 0x1p-26;

// What approximations may take of the margin.

/// What an approximation may take of the margin of a verdict: rays instead of light, the mean of mirrors
/// instead of one, half the interval of a mean of draws. Three of them together fill it.
inline constexpr double kShareOfMargin = 1.0 / 3;
/// What the gap between the fit's rays and fresh ones, and the sampling error of those, may take of the
/// margin.
inline constexpr double kRayShareOfMargin = 0.5;
/// What the gap between a fit's grid and the one that judges it may take of the margin.
inline constexpr double kGridShareOfMargin = 0.15;

// Rays and grids.

/// A term bends single rays where there are fewer rays than this per term: 1,593 terms follow 37,000 rays.
inline constexpr std::int64_t kRaysPerTerm = 30;
/// Fewest and most rays of a fit that chooses their number. The most take half a minute a set.
inline constexpr std::int64_t kFewestRays = 16384, kMostRays = std::int64_t(1) << 20;
/// Independent groups of rays or of random surfaces that give a standard error, known to 18 % by 16 of them.
inline constexpr int kGroups = 16;
/// Light is kept inside the field of view out to this times the largest radius that is asked for.
inline constexpr double kReach = 1.5;
/// Cells across at least: Airy radii have errors of 3e-5 on 128.
inline constexpr int kLeastCells = 128;
/// Cells to a cycle of the terms: a phase screen sampled twice a cycle folds its own side orders.
inline constexpr double kCellsPerCycle = 3.0;
/// Cells across at most of a grid that the program lays without being asked to: 8e5 cells, some ten seconds
/// for the default statistics. Where there are dozens of surfaces a quarter of the cells.
inline constexpr int kMostCells = 1024;
/// Cells across of the grid that a verdict looks at first, where the safe one has more: a look takes 150
/// focused planes, some seconds. Its error is in the interval, and what it leaves open goes to the safe grid.
inline constexpr int kCellsOfALook = 640;
/// A fit by waves starts on a grid that is coarser than the safe one by this factor, three steps of sqrt 2.
inline constexpr double kFirstCoarsening = 2 * std::numbers::sqrt2;
/// The finest grid of a fit has this times the safe pitch.
inline constexpr double kLeastCoarsening = 0.6;
/// Cells from which waves work in single precision: its rounding, 1e-7 of the light, is hundreds of times
/// below any tolerance, and below this number it saves nothing.
inline constexpr Eigen::Index kManyCells = 20000;

// How a fit goes on and ends.

/// A fit rests, and ends, where so many iterations have not brought the worst mismatch below this share of
/// what it was.
inline constexpr int kPatience = 12;
inline constexpr double kWorthwhile = 0.9;
/// Weight of the prior in a fit by waves, of its own standard deviations: targets pull, the prior chooses
/// among the surfaces that meet them.
inline constexpr double kWavePriorWeight = 0.1;
/// RMS height [m] of the terms that no roughness specifies. A convention of study files.
inline constexpr double kUnspecifiedRms = 1e-6;
/// Iterations of a fit, from few to many, that `check` and `fit` tell the time by where nothing else is
/// known. A convention for the reader, which decides nothing.
inline constexpr int kFewIterations = 10, kManyIterations = 40;

// Random surfaces.

/// Random surfaces of the roughness that a surface is compared with, and how many of one more draw lie inside
/// the band that they make. Student's t allows for their number: 99 % needs t = 2.74 with 32 of them, 3.11
/// with 12 and 2.63 with 100. With the mean's own error, sqrt(1 + 1/n), bands are 8 % wider than those of
/// endlessly many. Derived, not measured.
inline constexpr int kCharacterDraws = 32;
inline constexpr double kCharacterConfidence = 0.99;
/// Random surfaces whose light at other wavelengths is computed: the root of their mean square is known to
/// 30 %, and each costs a transform a wavelength.
inline constexpr int kOtherLightDraws = 6;
/// Cycles across the aperture up to which a random mirror without terms is a surface; above it mirrors differ
/// by less than a tolerance, and its mean stands for it.
inline constexpr double kDrawnCycles = 24;
/// Random mirrors at most behind a verdict without terms, four groups; and those of which only heights and
/// slopes are looked at, each of which takes a thirtieth of the time.
inline constexpr int kMostDraws = 4 * kGroups, kMostSurfaces = 32 * kMostDraws;
/// Rays of one random mirror of `verify`, and groups of such mirrors at most: a minute of one thread.
inline constexpr std::int64_t kRaysOfDraw = 4096;
inline constexpr int kMostGroupDraws = 36;

// What is worth a word.

/// A share of something that is worth a warning: of an aperture without measured heights, of a radius that is
/// sharper than diffraction.
inline constexpr double kNoteworthy = 0.05;
/// Ratio of two RMS heights that should be alike: a few hundred independent points know one to some percent,
/// a model of a PSD is off by more.
inline constexpr double kNoticedRatio = 1.5;
/// RMS height of a fitted surface over that of its specification beyond which it is no such mirror: a normal
/// variate of two modes exceeds it once in 10^4.
inline constexpr double kAbsurdRatio = 3;

// The pictures of a surface's character.

/// Cycles across of the lowest bin of a PSD: below, a window as wide as the aperture tells no frequencies
/// apart. From there on it resolves so many bins an octave.
inline constexpr double kLeastCycles = 1.5;
inline constexpr double kBinsPerOctave = 4;
/// Zones of equal width that slopes are compared in. A convention.
inline constexpr int kSlopeZones = 4;

}  // namespace aberfit::law
