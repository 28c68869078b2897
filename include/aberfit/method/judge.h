#pragma once
#include <optional>

#include "aberfit/method/attempt.h"

namespace aberfit {

/// Light's answer about a fitted surface whose own metrics are not light's: by diffraction on a grid as fine
/// as its light needs, against GHS (of half the heights in convention `paper`) or the given values.
/// Statistics: the fitted ones that exist for waves; the held-out ones too where light decides. Nothing
/// without a theory of light (`obstacle` then says why) or where the grid would be larger than
/// law::kMostCells. least_reach: as wave_pitch has it, of a surface that may be rougher than specified.
LightJudgement judge_in_light(const FitCase& of, const TermSet& terms, const Eigen::VectorXd& coefficients,
                              Warnings* warnings, double least_reach = 0);

/// What the perfect mirror would have come to against the targets, in light: the encircled energies
/// of the fitted and held-out targets by GHS without roughness. Those beside the focus are asked only where
/// it would pass at the focus: the planes of a rough mirror are thousands of waves from a perfect one's
/// focus. Nothing where the scene has no GHS.
std::optional<PerfectMirror> judge_perfect_mirror(const FitCase& of);

}  // namespace aberfit
