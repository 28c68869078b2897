#pragma once

/// The constants of the method, each with its unit, the law it belongs to, the plateau over which results do
/// not change, and the program that showed it. Nothing else in the rooms `method` and `chart` decides by a
/// number of its own.
namespace aberfit::law {

/// Order of the Zernikes over 2 pi R f_c, f_c the cut: their own last frequency, (n + 1)/(2 pi R), lies a
/// tenth beyond the cut, so that the last bins below it keep their power. From 1.05 to 1.25 the surface has
/// the specification's PSD within the scatter of draws; below 1 its last bins fall short
/// (tests/method/law_test.cpp).
inline constexpr double kOrderBeyondCut = 1.1;

/// Iterations of a fit, from few to many, that `check` and `fit` tell the time by where nothing else is
/// known. A convention for the reader, which decides nothing.
inline constexpr int kFewIterations = 10, kManyIterations = 40;

}  // namespace aberfit::law
