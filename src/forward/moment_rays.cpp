#include "moment_rays.h"

#include <algorithm>

#include "aberfit/forward/term_moments.h"

namespace aberfit::internal {
namespace {

PupilSample pupil_for(const Aperture& aperture, const TermSet& terms, const std::vector<Statistic>& moments) {
  const bool mean = std::any_of(moments.begin(), moments.end(),
                                [](const Statistic& s) { return std::holds_alternative<ScatterMean>(s); });
  return mean ? mean_angle_pupil(aperture, terms) : moment_pupil(aperture, terms);
}

}  // namespace

MomentRays::MomentRays(const Mirror& mirror, const Aperture& aperture, const TermSet& terms,
                       const std::vector<Statistic>& moments, int threads)
    : pupil_(pupil_for(aperture, terms, moments)),
      surface_(terms, pupil_, {threads, {}, {}}),
      rays_({mirror, pupil_, surface_}, moments, threads) {}

}  // namespace aberfit::internal
