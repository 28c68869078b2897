#include "moment_rays.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/forward/term_moments.h"

namespace aberfit::internal {

double with_scatter(const MeanScatter* scatter, const Statistic& moment, double of_terms) {
  if (!scatter) return of_terms;
  const double of_scatter =
      std::visit(Overloaded{[&](const RmsHeight&) { return scatter->rms_height(); },
                            [&](const ScatterRms&) { return scatter->scatter_rms(); },
                            [&](const ScatterMean&) { return 0.5 * std::sqrt(kPi) * scatter->scatter_rms(); },
                            [](const NoMoment auto&) { return kNaN; }},
                 moment);
  return std::hypot(of_terms, of_scatter);
}

MomentRays::MomentRays(const Mirror& mirror, PupilSample pupil, const TermSet& terms,
                       const OperatorOptions& how, const std::vector<Statistic>& moments)
    : pupil_(std::move(pupil)),
      surface_(terms.without_segments(), pupil_, how),
      rays_({mirror, pupil_, surface_}, moments, how.threads) {}

std::unique_ptr<MomentRays> make_moment_rays(const Mirror& mirror, const Aperture& aperture,
                                             const TermSet& terms, const std::vector<Statistic>& moments,
                                             int threads) {
  const bool mean = std::any_of(moments.begin(), moments.end(),
                                [](const Statistic& s) { return std::holds_alternative<ScatterMean>(s); });
  std::optional<PupilSample> pupil = mean ? mean_angle_pupil(aperture, terms) : moment_pupil(aperture, terms);
  if (!pupil) return nullptr;
  return std::make_unique<MomentRays>(mirror, *std::move(pupil), terms, OperatorOptions{threads, {}, {}},
                                      moments);
}

}  // namespace aberfit::internal
