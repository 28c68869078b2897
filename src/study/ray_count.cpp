#include "ray_count.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace aberfit {
namespace {

constexpr std::int64_t kFirstRays = 16384, kFirstScreeningRays = 4096;
constexpr std::int64_t kMostAutomaticRays = std::int64_t(1) << 20;

}  // namespace

std::int64_t first_rays(Eigen::Index terms) {
  const auto needed = std::uint64_t(kRaysPerTerm * std::max<std::int64_t>(1, terms));
  return std::clamp(std::int64_t(std::bit_ceil(needed)), kFirstRays, kMostAutomaticRays);
}

std::int64_t screening_rays(Eigen::Index terms) {
  return std::max(kFirstScreeningRays, kRaysPerTerm * std::int64_t(terms));
}

std::int64_t more_rays(std::int64_t rays) { return 2 * rays; }

bool explain_rays(std::int64_t rays, RayChoice* choice) {
  const bool enough = choice->gap <= choice->allowed && choice->sampling_error <= choice->allowed;
  choice->reason = fmt::format(
      "{} rays: fresh rays change the fitted statistics by up to {:.2g} % and have a standard error of "
      "{:.2g} "
      "%, {} {:.2g} %, {:.0f} % of the margin",
      rays, 100 * choice->gap, 100 * choice->sampling_error, enough ? "both below" : "not both below",
      100 * choice->allowed, 100 * kRayShareOfMargin);
  return enough || rays >= kMostAutomaticRays;
}

}  // namespace aberfit
