#pragma once
#include <string>

#include "aberfit/method/verify.h"

namespace aberfit::internal {

/// One way to make rays near the focus, with its statistics.
struct Branch {
  RayBundle rays;
  SurfaceField field;          ///< surface error of the pupil points; empty for perturbed rays
  Eigen::VectorXd statistics;  ///< in the order asked
};

/// Numbers that only a picture of the paper's own way gives: counted ring widths, phase gradients, mean
/// deflection.
void add_paper_quantities(const std::string& branch, const Task& task, const Groundwork& ground,
                          const PupilSample& pupil, const RayBundle& nominal, const Branch& rays,
                          Quantities* quantities);

/// The published phase synthesis (PHYSICS 9): gradient RMS per axis and expected, and the surface height its
/// phase really stands for. Returns its modes.
std::vector<FourierMode> add_published_phase(const Task& task, const PhaseSynthesis& published,
                                             const PupilSample& pupil, const RayBundle& nominal, int threads,
                                             Quantities* quantities);

/// Mean focal statistics of independently drawn Zernikes.
void add_independent_terms(const Task& task, const IndependentTerms& spec, int threads,
                           Quantities* quantities);

}  // namespace aberfit::internal
