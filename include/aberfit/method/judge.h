#pragma once
#include <optional>

#include "aberfit/method/attempt.h"

namespace aberfit {

/// Judges a fitted surface by wave optics where its own metrics come from rays. Diffraction on a grid that is
/// fine enough is compared with GHS (of half the heights in convention `paper`) or with the given values.
/// Statistics: the fitted ones that exist for waves, and the held-out ones where wave optics decides. No
/// metrics without a wave theory, or where the grid would exceed law::kMostCells; `obstacle` then gives the
/// reason. least_reach: as in wave_pitch, for a surface that may be rougher than specified.
LightJudgement judge_in_light(const FitCase& of, const TermSet& terms, const Eigen::VectorXd& coefficients,
                              Warnings* warnings, double least_reach = 0);

/// The perfect mirror against the targets by wave optics: fitted and held-out encircled energies from GHS
/// without roughness. Planes out of focus are computed only if it passes in the focus, because those of a
/// rough mirror are thousands of wavelengths of defocus for it. Empty where the scene has no GHS.
std::optional<PerfectMirror> judge_perfect_mirror(const FitCase& of);

}  // namespace aberfit
