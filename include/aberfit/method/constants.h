#pragma once
#include <Eigen/Core>

/// The constants of the method, each with its unit, the law it belongs to, the plateau over which results do
/// not change, and the program that showed it. Nothing else in the rooms `method` and `chart` decides by a
/// number of its own.
namespace aberfit::law {

/// Order of the Zernikes over 2 pi R f_c, f_c the cut: their own last frequency, (n + 1)/(2 pi R), lies a
/// tenth beyond the cut, so that the last bins below it keep their power. From 1.05 to 1.25 the surface has
/// the specification's PSD within the scatter of draws; below 1 its last bins fall short
/// (tests/method/law_test.cpp).
inline constexpr double kOrderBeyondCut = 1.1;

/// Highest order that the law takes: up to there the polar operator and the full covariance take seconds.
/// Beyond it plane waves on the frequency grid are as good and faster.
inline constexpr int kLargestOrder = 100;
/// Most plane waves of the frequency grid that the law takes: 260 cycles across, some seconds an iteration.
inline constexpr double kMostWaves = 1e5;
/// Growth of the order where a set turns out too few, a third more terms, and how often.
inline constexpr double kGrowth = 1.15;
inline constexpr int kMostGrowths = 2;
/// The fewest terms are found to within this factor of the order.
inline constexpr double kFewestWithin = 1.1;

/// A fit rests, and ends, where so many iterations have not brought the worst mismatch below this share of
/// what it was.
inline constexpr int kPatience = 12;
inline constexpr double kWorthwhile = 0.9;
/// Weight of the prior in a fit by waves, of its own standard deviations: targets pull, the prior chooses
/// among the surfaces that meet them.
inline constexpr double kWavePriorWeight = 0.1;
/// Cells from which waves work in single precision: its rounding, 1e-7 of the light, is hundreds of times
/// below any tolerance, and below this number it saves nothing.
inline constexpr Eigen::Index kManyCells = 20000;
/// What the gap between a fit's grid and the one that judges it may take of the margin.
inline constexpr double kGridShareOfMargin = 0.15;
/// The finest grid of a fit has this times the safe pitch.
inline constexpr double kLeastCoarsening = 0.6;

/// Iterations of a fit, from few to many, that `check` and `fit` tell the time by where nothing else is
/// known. A convention for the reader, which decides nothing.
inline constexpr int kFewIterations = 10, kManyIterations = 40;

/// Share of the slope variance that terms of a whole roughness may leave out: where a roughness without f_max
/// ends. Of a band the order does not depend on it, by less than 0.03 at n = 100; of a Gaussian PSD, whose
/// tail falls as exp(-(pi l f)^2), it moves by a quarter from 1e-2 to 1e-4 (tests/method/plan_test.cpp).
inline constexpr double kSlopeBeyondTerms = 1e-3;

/// Random surfaces of the roughness that a surface is compared with, and how many of one more draw lie inside
/// the band that they make. Student's t allows for their number: 99 % needs t = 2.74 with 32 of them, 3.2 with
/// 12 and 2.63 with 100, so that more make bands 4 % narrower at most (tests/method/character_test.cpp).
inline constexpr int kCharacterDraws = 32;
inline constexpr double kCharacterConfidence = 0.99;
/// Random surfaces whose light at other wavelengths is computed: the root of their mean square is known to
/// 30 %, and each costs a transform a wavelength.
inline constexpr int kOtherLightDraws = 6;

}  // namespace aberfit::law
