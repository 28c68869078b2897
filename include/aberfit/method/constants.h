#pragma once

/// The constants of the method, each with its unit, the law it belongs to, the plateau over which results do
/// not change, and the program that showed it. Nothing else in the rooms `method` and `chart` decides by a
/// number of its own.
namespace aberfit::law {

/// Order of the Zernikes over 2 pi R f_c, f_c the cut: their own last frequency, (n + 1)/(2 pi R), lies a tenth
/// beyond the cut, so that the last bins below it keep their power. From 1.05 to 1.25 the surface has the
/// specification's PSD within the scatter of draws; below 1 its last bins fall short (tests/method/law_test.cpp).
inline constexpr double kOrderBeyondCut = 1.1;

/// Random surfaces of the roughness that a surface is compared with, and how many of one more draw lie inside
/// the band that they make. Student's t allows for their number: 99 % needs t = 2.74 with 32 of them, 3.2 with
/// 12 and 2.63 with 100, so that more make bands 4 % narrower at most (tests/method/character_test.cpp).
inline constexpr int kCharacterDraws = 32;
inline constexpr double kCharacterConfidence = 0.99;
/// Random surfaces whose light at other wavelengths is computed: the root of their mean square is known to
/// 30 %, and each costs a transform a wavelength.
inline constexpr int kOtherLightDraws = 6;

}  // namespace aberfit::law
