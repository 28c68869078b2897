#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <numbers>

/// The constants of the method, each with its unit, its law, the plateau over which results do not change,
/// and the program that shows it. A constant without a plateau is derived, or is marked as a convention. The
/// rooms `method` and `chart` decide by no other numbers.
namespace aberfit::law {

// Number of terms.

/// Order of the Zernikes over 2 pi R f_c, with f_c the cut. The last frequency of the Zernikes, (n + 1)/(2 pi
/// R), then lies a tenth beyond the cut, so that the last bins below the cut keep their power. From 1.05 on,
/// the last quarter of an octave keeps at least 0.999 of it; at 0.75, less than 0.7
/// (tests/method/plan_test.cpp). The power lost to truncation is too small to be added to the scatter.
inline constexpr double kOrderBeyondCut = 1.1;
/// Highest order of automatic Zernikes: up to it the polar operator and the full covariance take seconds.
/// Beyond it, plane waves on the frequency grid are as good and faster.
inline constexpr int kLargestOrder = 100;
/// Most plane waves of an automatic frequency grid: 252 cycles across.
inline constexpr double kMostWaves = 1e5;
/// Growth of the order where a set has too few terms (a third more terms), and how often it may grow. A named
/// cut may differ from the end of the terms by the same factor before a warning.
inline constexpr double kGrowth = 1.15;
inline constexpr int kMostGrowths = 2;
/// The search for the fewest terms ends within this factor of the order.
inline constexpr double kFewestWithin = 1.1;
/// Number of plane waves on log-uniform rings where a study names none. A convention of study files.
inline constexpr int kUsualWaves = 400;
/// Order of the Zernikes of a map without a specification, where a study names none: 231 terms, the limit of
/// OpticStudio's Zernike surfaces. A convention.
inline constexpr int kMapOrder = 20;
/// Most points of a map in the square around its aperture: 8,000 across. It bounds memory, not accuracy.
inline constexpr double kMostMapCells = 6.4e7;
/// Fraction of the slope variance that terms of a roughness without f_max may leave out. The order for a band
/// depends on it by less than 0.03 at n = 100. For a Gaussian PSD, whose tail falls as exp(-(pi l f)^2), the
/// order changes by a quarter from 1e-2 to 1e-4 (tests/method/plan_test.cpp).
inline constexpr double kSlopeBeyondTerms = 1e-3;

// Statistics that a surface has to meet.

/// Fractions and planes, in depths of focus, of the default encircled energies: fitted, and held out from the
/// fit. A convention. The guides of rays lie midway between the fitted fractions.
inline constexpr double kFittedShares[] = {0.20, 0.35, 0.50, 0.65, 0.80, 0.90, 0.95};
inline constexpr double kFittedPlanes[] = {0, -1, 1, -2, 2, -3.5, 3.5, -5, 5};
inline constexpr double kHeldOutShares[] = {0.25, 0.30, 0.40, 0.60, 0.70, 0.75, 0.875, 0.925};
inline constexpr double kHeldOutPlanes[] = {0, -0.25, 0.25, -0.75, 0.75, -1.75, 1.75, -3.1, 3.1, -4.6, 4.6};
/// Tolerance of the guides of a fit by waves, as a fraction of the margin. It is below 1 so that the curve
/// between two guides is met as well. By rays, kShareOfMargin of the usual margin replaces the margin.
/// Plateau: from 0.5 to 0.9 equally many fits of README's mirror are equivalent, to within one of 36 (`fit`).
inline constexpr double kGuideShareOfMargin = 0.9;
/// Spacing of the guides of a fit by waves: the step between two rings, and the widening of the cone of rays
/// between two planes. The unit is the ring width in which speckle changes the energy by the margin. README's
/// mirror at margins from 0.3 to 10 %: 82 of 84 fits are equivalent at these values, and 77 at 2 and 4.
/// Values of 1 and 2 change no verdict (`fit`; `Along/Continuity` repeats one seed).
inline constexpr double kSteadyRing = 1.4, kSteadyPlane = 2.8;
/// Radius in units of Groundwork::core_sigma beyond which a ring lies in the scattered halo. Such a ring
/// fades so far out of focus that terms do not affect it, while the grid has to contain the whole cone of
/// rays. Rings of practical use lie at 3 to 46.
inline constexpr double kHalo = 60;
/// Number of modes (N_eff) below which the mean irradiance is not that of a mirror of mean height: irradiance
/// is not linear in the squared height (Jensen), and its relative variance over mirrors is 1/N_eff.
inline constexpr double kFewModes = 10;
/// Closed forms are of first order in the slope. A radius from exact rays differs from them by this constant
/// times slope^2 (PHYSICS 5; tests/stability/fast_mirror_edge_test.cpp).
inline constexpr double kSecondOrder = 4.6;
/// Fraction of the energy that cannot change a verdict: a tenth of the usual margin. A spot has no core when
/// its mean transfer function half an aperture apart is below it. It is also the energy that may lie beyond
/// the rays for which a grid makes room.
inline constexpr double kUnseenLight = 1e-3;
/// Value of 4 pi sigma/lambda of a nearly perfect surface. It scatters the square of this fraction, which is
/// the rounding of doubles.
inline constexpr double kSmoothG = 0x1p-26;

// Fractions of the margin that approximations may use.

/// Fraction of the margin that one approximation may use: rays instead of wave optics, the mean of mirrors
/// instead of one mirror, or half the interval of a mean over realisations. Three of them fill the margin.
inline constexpr double kShareOfMargin = 1.0 / 3;
/// Fraction of the margin for the difference between the fit's rays and fresh rays, and for their sampling
/// error.
inline constexpr double kRayShareOfMargin = 0.5;
/// Fraction of the margin for the difference between the grid of the fit and the grid that judges it.
inline constexpr double kGridShareOfMargin = 0.15;

// Rays and grids.

/// Rays per term. With fewer rays, a term fits single rays instead of the statistic.
inline constexpr std::int64_t kRaysPerTerm = 30;
/// Fewest and most rays of a fit with automatic rays. The most take half a minute per set of terms.
inline constexpr std::int64_t kFewestRays = 16384, kMostRays = std::int64_t(1) << 20;
/// Number of independent groups of rays or of random surfaces: 16 give a standard error to 18 %.
inline constexpr int kGroups = 16;
/// The field of view contains this times the largest radius of any statistic.
inline constexpr double kReach = 1.5;
/// Fewest grid cells across: Airy radii have errors of 3e-5 on 128.
inline constexpr int kLeastCells = 128;
/// Grid cells per cycle of the terms. A phase screen with two cells per cycle aliases its own side orders.
inline constexpr double kCellsPerCycle = 3.0;
/// Most grid cells across of an automatic grid: 8e5 cells, some ten seconds for the default statistics. Where
/// dozens of surfaces are computed, a quarter of the cells.
inline constexpr int kMostCells = 1024;
/// Grid cells across of the first judging grid, where the safe grid has more. One judgement takes 150 focused
/// planes, some seconds. The grid's error widens the interval; statistics left undecided go to the safe grid.
inline constexpr int kCellsOfALook = 640;
/// Pitch of the first grid of a fit by waves over the safe pitch of wave_pitch: three steps of sqrt 2.
inline constexpr double kFirstCoarsening = 2 * std::numbers::sqrt2;
/// Pitch of the finest grid of a fit over the safe pitch.
inline constexpr double kLeastCoarsening = 0.6;
/// Number of grid cells from which wave optics uses single precision. Its rounding, 1e-7 of the energy, is
/// hundreds of times below any tolerance; on fewer cells it saves no time.
inline constexpr Eigen::Index kManyCells = 20000;

// Progress and end of a fit.

/// A fit ends when kPatience iterations have not reduced the worst mismatch below kWorthwhile of its value.
inline constexpr int kPatience = 12;
inline constexpr double kWorthwhile = 0.9;
/// Weight of the prior in a fit by waves, in its own standard deviations. It is small so that targets decide,
/// and the prior chooses among the surfaces that meet them.
inline constexpr double kWavePriorWeight = 0.1;
/// RMS height [m] of terms without a specified roughness. A convention of study files.
inline constexpr double kUnspecifiedRms = 1e-6;
/// Few and many iterations, for the expected time reported before a fit. A convention.
inline constexpr int kFewIterations = 10, kManyIterations = 40;

// Random surfaces.

/// Number of random surfaces that a surface is compared with, and the probability that their band contains
/// one more realisation. Derived, not measured. Student's t allows for their number: 99 % needs t = 2.74 with
/// 32 surfaces, 3.11 with 12 and 2.63 with 100. With the error of the mean, sqrt(1 + 1/n), bands are 8 %
/// wider than those of infinitely many surfaces.
inline constexpr int kCharacterDraws = 32;
inline constexpr double kCharacterConfidence = 0.99;
/// Number of random surfaces whose encircled energies at other wavelengths are computed. Their root mean
/// square is known to 30 %; each costs one transform per wavelength.
inline constexpr int kOtherLightDraws = 6;
/// Cycles across the aperture up to which a random mirror without terms is a surface. Above it, mirrors
/// differ by less than a tolerance, and their mean scatter represents them.
inline constexpr double kDrawnCycles = 24;
/// Most random mirrors behind a verdict without terms: four groups. kMostSurfaces applies where only heights
/// and slopes are computed, which takes a thirtieth of the time.
inline constexpr int kMostDraws = 4 * kGroups, kMostSurfaces = 32 * kMostDraws;
/// Rays of one random mirror of `verify`, and most mirrors in a group. Together they take a minute on one
/// thread.
inline constexpr std::int64_t kRaysOfDraw = 4096;
inline constexpr int kMostGroupDraws = 36;

// Limits for warnings.

/// Fraction from which a warning is given: of an aperture without measured heights, or of a radius that is
/// smaller than diffraction allows.
inline constexpr double kNoteworthy = 0.05;
/// Ratio of two RMS heights that should agree, from which a warning is given. A few hundred independent
/// points give a height to a few percent; a model of a PSD has a larger error.
inline constexpr double kNoticedRatio = 1.5;
/// RMS height of a fitted surface over that of its specification beyond which the surface is implausible. A
/// normal variate of two modes exceeds it once in 10^4.
inline constexpr double kAbsurdRatio = 3;

// Pictures of the character of a surface.

/// Lowest bin of a PSD [cycles across] and bins per octave. Below it, a window as wide as the aperture
/// resolves no frequencies; above it, the window resolves this many bins per octave.
inline constexpr double kLeastCycles = 1.5;
inline constexpr double kBinsPerOctave = 4;
/// Number of zones of equal width for the comparison of slopes. A convention.
inline constexpr int kSlopeZones = 4;

}  // namespace aberfit::law
