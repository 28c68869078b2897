#include "ring_through.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/parallel.h"
#include "aberfit/core/root.h"
#include "kernel.h"
#include "ray_blocks.h"

namespace aberfit::internal {
namespace {

constexpr int kPlanes = 4096;
constexpr double kFirstRange =
    8;  // half range over ring / RMS ray slope; the half maximum of a Gaussian focus is near 1
constexpr double kLastRange = 128;
constexpr std::size_t kPlaneSlots = kPlanes + 3;  // planes 0 .. kPlanes, one beyond, one for misses

struct Profile {
  double first = 0, pitch = 0;       // dz of plane 0, and spacing of the planes [m]
  const std::vector<double>& share;  // N at every plane
  double at(std::size_t k) const { return first + pitch * double(k); }
};

// A ray is inside the ring between the two roots of |X0 + z T|^2 = ring^2. It enters at the first plane at or
// above the lower root and leaves at the first plane above the upper root.
Profile count_planes(const RayBundle& rays, const Ring& ring, double half_range, int threads,
                     RingBuffers* buffers) {
  const RayGroups groups(rays.size());
  const FocusKernels& kernels = focus_kernels(best_instruction_set());
  const Profile profile{-half_range, 2 * half_range / kPlanes, buffers->share};
  buffers->enter.assign(std::size_t(groups.count) * kPlaneSlots, 0.0);
  buffers->leave.assign(std::size_t(groups.count) * kPlaneSlots, 0.0);
  parallel_for(std::size_t(groups.count), threads, [&](std::size_t g) {
    alignas(64) std::int32_t in[kBlockRays], out[kBlockRays];
    double* enter = buffers->enter.data() + g * kPlaneSlots;
    double* leave = buffers->leave.data() + g * kPlaneSlots;
    for_each_block(rays, groups.begin(int(g)), groups.begin(int(g) + 1),
                   [&](const RayBlock& block, Eigen::Index, int) {
                     kernels.intervals(block, ring.centre_x, ring.centre_y, ring.radius * ring.radius,
                                       profile.first, 1.0 / profile.pitch, kPlanes, in, out);
                     for (int i = 0; i < block.count; ++i) {
                       enter[in[i]] += block.weight[i];
                       leave[out[i]] += block.weight[i];
                     }
                   });
  });
  buffers->share.resize(kPlanes + 1);
  double inside = 0;
  for (std::size_t k = 0; k <= kPlanes; ++k) {
    for (std::size_t g = 0; g < std::size_t(groups.count); ++g)
      inside += buffers->enter[g * kPlaneSlots + k] - buffers->leave[g * kPlaneSlots + k];
    buffers->share[k] = inside;
  }
  return profile;
}

std::optional<RingWidth> width_of(const Profile& profile) {
  const std::vector<double>& n = profile.share;
  RingWidth width;
  // The centre of the range of planes with the largest count; an aberration-free focus has a plateau.
  const auto highest = std::max_element(n.begin(), n.end());
  auto plateau_end = highest;
  while (plateau_end + 1 != n.end() && *(plateau_end + 1) == *highest) ++plateau_end;
  const auto first = std::size_t(highest - n.begin()), last = std::size_t(plateau_end - n.begin());
  width.peak = 0.5 * (profile.at(first) + profile.at(last));
  width.peak_share = *highest;
  const double half = 0.5 * *highest;
  const auto crossing = [&](std::size_t inside, std::size_t outside) {
    return profile.at(inside) +
           (profile.at(outside) - profile.at(inside)) * (n[inside] - half) / (n[inside] - n[outside]);
  };
  std::size_t k = first;
  while (k > 0 && n[k - 1] >= half) --k;
  if (k == 0) return std::nullopt;
  width.lower = crossing(k, k - 1);
  for (k = last; k + 1 < n.size() && n[k + 1] >= half;) ++k;
  if (k + 1 == n.size()) return std::nullopt;
  width.upper = crossing(k, k + 1);
  width.fwhm = width.upper - width.lower;
  width.crossings = 0;
  for (k = 1; k < n.size(); ++k) width.crossings += (n[k] >= half) != (n[k - 1] >= half);
  return width;
}

// N(z) and its derivatives with the smooth indicator. It uses the rays that the kernel may touch in a window
// of planes, and the weight of those inside the ring throughout the window.
class SmoothShare {
 public:
  SmoothShare(const RayBundle& rays, double total, const Ring& ring, double width, int threads,
              RingBuffers* buffers)
      : rays_(rays),
        total_(total),
        groups_(rays.size()),
        disc_(ring.radius, width),
        shape_{ring.centre_x, ring.centre_y, disc_.radius2, disc_.scale},
        threads_(threads),
        buffers_(*buffers),
        kernels_(focus_kernels(best_instruction_set())) {
    buffers_.shells.resize(kMostWindows * std::size_t(groups_.count));
    buffers_.inside.resize(kMostWindows * std::size_t(groups_.count));
  }

  // Collects the rays of `count` windows in one pass. They become windows first, first + 1, ...
  void collect(int first, int count, const PlaneWindow* windows) {
    for (int w = 0; w < count; ++w) windows_[first + w] = windows[w];
    parallel_for(std::size_t(groups_.count), threads_, [&](std::size_t g) {
      alignas(64) std::int32_t flags[kBlockRays];
      int hits[kBlockRays];
      double inside[kMostWindows] = {};
      for (int w = 0; w < count; ++w) shell(first + w, int(g)).used = 0;
      for_each_block(rays_, groups_.begin(int(g)), groups_.begin(int(g) + 1),
                     [&](const RayBlock& block, Eigen::Index at, int used) {
                       kernels_.classify(block, shape_.centre_x, shape_.centre_y, disc_.inside2,
                                         disc_.outside2, count, windows, flags, inside);
                       int found = 0;
                       for (int i = 0; i < used; ++i) {
                         hits[found] = i;
                         found += flags[i] != 0;
                       }
                       for (int k = 0; k < found; ++k)
                         for (int w = 0; w < count; ++w)
                           if (flags[hits[k]] >> w & 1)
                             append(block, hits[k], std::uint32_t(at + hits[k]), &shell(first + w, int(g)));
                     });
      for (int w = 0; w < count; ++w) {
        buffers_.inside[g * kMostWindows + std::size_t(first + w)] = inside[w];
        finish(&shell(first + w, int(g)));
      }
    });
  }

  struct Value {
    double share, d_z, d_ring;
  };
  // z must lie inside window w.
  Value operator()(int w, double z) const {
    double sums[3] = {};
    for (int g = 0; g < groups_.count; ++g) {
      sums[0] += buffers_.inside[std::size_t(g) * kMostWindows + std::size_t(w)];
      kernels_.share(shell(w, g).block(0, shell(w, g).used), z, shape_, sums);
    }
    return {sums[0] / total_, sums[1] / total_, sums[2] / (disc_.radius * total_)};
  }

  // Adds scale * dN(z) over the rays, either as new entries or to a dense gradient.
  void add_gradient(int w, double z, double scale, RayGradient* gradient) const {
    alignas(64) double density[kBlockRays];
    for (int g = 0; g < groups_.count; ++g) {
      const RingShell& s = shell(w, g);
      for (std::size_t first = 0; first < s.used; first += kBlockRays) {
        const RayBlock block = s.block(first, kBlockRays);
        kernels_.share_density(block, z, shape_, density);
        const int used = int(std::min<std::size_t>(kBlockRays, s.used - first));
        for (int i = 0; i < used; ++i) {
          if (!(density[i] > 0.0)) continue;
          const double share = -2 * scale / total_ * density[i];
          const double d_x = share * (block.x[i] + z * block.tx[i] - shape_.centre_x);
          const double d_y = share * (block.y[i] + z * block.ty[i] - shape_.centre_y);
          const std::uint32_t ray = s.ray[first + std::size_t(i)];
          if (gradient->all_rays) {
            gradient->d_x[ray] += d_x;
            gradient->d_y[ray] += d_y;
            gradient->d_tx[ray] += z * d_x;
            gradient->d_ty[ray] += z * d_y;
          } else {
            gradient->rays.push_back(ray);
            gradient->d_x.push_back(d_x);
            gradient->d_y.push_back(d_y);
            gradient->d_tx.push_back(z * d_x);
            gradient->d_ty.push_back(z * d_y);
          }
        }
      }
    }
  }

  const PlaneWindow& window(int w) const { return windows_[w]; }

 private:
  RingShell& shell(int w, int g) { return buffers_.shells[std::size_t(w * groups_.count + g)]; }
  const RingShell& shell(int w, int g) const { return buffers_.shells[std::size_t(w * groups_.count + g)]; }

  static void room(RingShell* s, std::size_t needed) {
    for (std::vector<double>* v : {&s->x, &s->y, &s->tx, &s->ty, &s->weight}) make_room(*v, needed);
    make_room(s->ray, needed);
  }
  static void append(const RayBlock& block, int i, std::uint32_t ray, RingShell* s) {
    const std::size_t at = s->used++;
    if (at >= s->x.size()) room(s, at + 1);
    s->x[at] = block.x[i];
    s->y[at] = block.y[i];
    s->tx[at] = block.tx[i];
    s->ty[at] = block.ty[i];
    s->weight[at] = block.weight[i];
    s->ray[at] = ray;
  }
  static void finish(RingShell* s) {
    room(s, s->used + s->used / 8 + kRayPadding);  // spare room; the next evaluation may find a few more rays
    for (std::size_t i = s->used; i % kRayPadding != 0; ++i)
      s->x[i] = s->y[i] = s->tx[i] = s->ty[i] = s->weight[i] = 0.0;
  }

  const RayBundle& rays_;
  double total_;
  RayGroups groups_;
  SmoothDisc disc_;
  DiscShape shape_;
  int threads_;
  RingBuffers& buffers_;
  const FocusKernels& kernels_;
  PlaneWindow windows_[kMostWindows] = {};
};

enum Window { kPeak, kLower, kUpper };
constexpr double kPeakWindow = 0.02, kLastPeakWindow = 0.4;  // half widths over the counted FWHM
constexpr double kCrossingWindow = 0.003, kLastCrossingWindow = 1.3;
constexpr int kScan = 17;  // planes of a scan for the highest one
constexpr int kMiddle = kScan / 2;
constexpr int kRefinements = 4;  // scans, each about the highest plane of the previous one

// The plane with the largest N within `half` of `centre`; nothing when it lies at the edge. N has many local
// peaks, because single rays make it irregular. Following the peak next to the counted one would make the
// width jump (by 1e-5 of itself) when two peaks change order. The largest N is continuous there.
std::optional<double> highest_plane(const SmoothShare& share, double centre, double half) {
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    const double pitch = 2 * half / (kScan - 1);
    SmoothShare::Value value[kScan];
    int best = 0;
    for (int k = 0; k < kScan; ++k) {
      value[k] = share(kPeak, centre + pitch * (k - kMiddle));
      if (value[k].share > value[best].share) best = k;
    }
    if (best == 0 || best == kScan - 1) return std::nullopt;
    const double z = centre + pitch * (best - kMiddle);
    const double before = value[best - 1].d_z, after = value[best + 1].d_z;
    if (before == 0 && after == 0) return z;  // a plateau
    const double from = z - 2 * pitch;  // the peak may lie at z = 0, so we solve for a positive distance
    if (before >= 0 && after <= 0)
      return from + root_between([&](double on) { return share(kPeak, from + on).d_z; }, pitch, 3 * pitch,
                                 before, after);
    centre = z;
    half = pitch;
  }
  return std::nullopt;
}

}  // namespace

RayBlock RingShell::block(std::size_t first, std::size_t most) const {
  const std::size_t count = std::min(most, used - first);
  return {x.data() + first,      y.data() + first,
          tx.data() + first,     ty.data() + first,
          weight.data() + first, int((count + kRayPadding - 1) / kRayPadding * kRayPadding)};
}

std::optional<RingWidth> exact_ring_width(const RayBundle& rays, const RaySums& sums, const Ring& ring,
                                          int threads, RingBuffers* buffers) {
  const double slope = std::sqrt(sums.slope2 / sums.weight);
  if (!(ring.radius > 0) || !(slope > 0)) return std::nullopt;
  for (double range = kFirstRange; range <= kLastRange; range *= 4) {
    const auto width = width_of(count_planes(rays, ring, range * ring.radius / slope, threads, buffers));
    if (width) {
      RingWidth result = *width;
      result.peak_share /= sums.weight;
      return result;
    }
  }
  return std::nullopt;
}

std::optional<RingWidth> smooth_ring_width(const RayBundle& rays, const RaySums& sums, const Ring& ring,
                                           double width, int threads, RingBuffers* buffers, bool dense,
                                           RayGradient* gradient, double* d_ring) {
  const auto start = exact_ring_width(rays, sums, ring, threads, buffers);
  if (!start || !(ring.radius > kSmallestSpotInWidths * width)) return std::nullopt;
  SmoothShare share(rays, sums.weight, ring, width, threads, buffers);
  RingWidth result = *start;
  // Counted and smooth crossings differ by the noise of the rays in the kernel, ~ 1/sqrt(N).
  const double reach =
      start->fwhm * std::min(kLastCrossingWindow, kCrossingWindow + 0.5 / std::sqrt(double(rays.size())));
  const PlaneWindow first[kMostWindows] = {
      {start->peak, 2 * kPeakWindow * start->fwhm}, {start->lower, reach}, {start->upper, reach}};
  share.collect(kPeak, kMostWindows, first);
  std::optional<double> peak;
  for (double half = kPeakWindow * start->fwhm; half <= kLastPeakWindow * start->fwhm && !peak; half *= 2) {
    if (half > share.window(kPeak).half) {
      const PlaneWindow wider{start->peak, 2 * half};
      share.collect(kPeak, 1, &wider);
    }
    peak = highest_plane(share, start->peak, half);
  }
  if (!peak) return std::nullopt;
  result.peak = *peak;
  const SmoothShare::Value top = share(kPeak, result.peak);
  result.peak_share = top.share;
  const auto crossing = [&](Window w, double counted, double outward) -> std::optional<double> {
    const auto excess = [&](double z) { return share(w, z).share - 0.5 * top.share; };
    // Wide kernels move crossings far from the counted ones. Windows then grow, but not past the peak.
    for (double half = reach; half <= kLastCrossingWindow * start->fwhm; half *= 2) {
      if (half > share.window(w).half) {
        const PlaneWindow wider{counted, 2 * half};
        share.collect(w, 1, &wider);
      }
      const double outer = counted + outward * half;
      double inner = counted - outward * half;
      if (outward * (counted - result.peak) > 0 && outward * (inner - result.peak) < 0) inner = result.peak;
      const double f_inner = excess(inner), f_outer = excess(outer);
      if (f_inner >= 0 && f_outer <= 0) return root_between(excess, inner, outer, f_inner, f_outer);
    }
    return std::nullopt;
  };
  const auto lower = crossing(kLower, start->lower, -1), upper = crossing(kUpper, start->upper, +1);
  if (!lower || !upper) return std::nullopt;
  result.lower = *lower;
  result.upper = *upper;
  result.fwhm = *upper - *lower;
  if (!gradient && !d_ring) return result;
  // Implicit function theorem on N(z) = N(peak)/2 at both crossings; N is stationary at the peak.
  const SmoothShare::Value at_lower = share(kLower, *lower), at_upper = share(kUpper, *upper);
  if (at_lower.d_z == 0.0 || at_upper.d_z == 0.0) return std::nullopt;
  const double for_upper = -1.0 / at_upper.d_z, for_lower = 1.0 / at_lower.d_z;
  const double for_peak = -0.5 * (for_upper + for_lower);
  if (gradient) {
    gradient->clear();
    if (dense) {
      gradient->all_rays = true;
      for (std::vector<double>* d : {&gradient->d_x, &gradient->d_y, &gradient->d_tx, &gradient->d_ty})
        d->assign(std::size_t(rays.size()), 0.0);
    }
    share.add_gradient(kUpper, *upper, for_upper, gradient);
    share.add_gradient(kLower, *lower, for_lower, gradient);
    share.add_gradient(kPeak, result.peak, for_peak, gradient);
  }
  if (d_ring) *d_ring = for_upper * at_upper.d_ring + for_lower * at_lower.d_ring + for_peak * top.d_ring;
  return result;
}

}  // namespace aberfit::internal
