#include "aberfit/method/ray_count.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "aberfit/method/constants.h"

namespace aberfit {

std::int64_t first_rays(Eigen::Index terms) {
  const auto needed = std::uint64_t(law::kRaysPerTerm * std::max<std::int64_t>(1, terms));
  return std::clamp(std::int64_t(std::bit_ceil(needed)), law::kFewestRays, law::kMostRays);
}

std::int64_t more_rays(std::int64_t rays) { return 2 * rays; }

bool explain_rays(std::int64_t rays, Verdict verdict, RayChoice* choice) {
  const bool steady = choice->gap <= choice->allowed && choice->sampling_error <= choice->allowed;
  const bool open = verdict == Verdict::kUndecided;
  choice->reason = fmt::format(
      "{} rays: fresh rays change the fitted statistics by up to {:.2g} %, with a standard error of up to "
      "{:.2g} %; {} {:.2g} % ({:.0f} % of the margin)",
      rays, 100 * choice->gap, 100 * choice->sampling_error, steady ? "both are below" : "not both are below",
      100 * choice->allowed, 100 * law::kRayShareOfMargin);
  if (!std::isfinite(choice->gap)) choice->reason = kNoValueToCompare;
  if (steady && open) choice->reason += "; the verdict is undecided and more rays could decide it";
  return (steady && !open) || !std::isfinite(choice->gap) || rays >= law::kMostRays;
}

bool explain_cells(Eigen::Index cells, double share, RayChoice* choice) {
  const bool steady = choice->gap <= choice->allowed;
  choice->reason = fmt::format(
      "{} grid points: the finer judging grid changes the fitted statistics by up to {:.2g} %, {} the "
      "allowed {:.2g} % ({:.0f} % of the margin)",
      cells, 100 * choice->gap, steady ? "below" : "above", 100 * choice->allowed, 100 * share);
  if (!std::isfinite(choice->gap)) choice->reason = kNoValueToCompare;
  return steady;
}

}  // namespace aberfit
