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

/// Share of the slope variance that terms of a whole roughness may leave out: where a roughness without f_max
/// ends. Of a band the order does not depend on it, by less than 0.03 at n = 100; of a Gaussian PSD, whose
/// tail falls as exp(-(pi l f)^2), it moves by a quarter from 1e-2 to 1e-4 (tests/method/plan_test.cpp).
inline constexpr double kSlopeBeyondTerms = 1e-3;

}  // namespace aberfit::law
