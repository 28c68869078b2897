#include "encircled_radii.h"

#include <bit>
#include <numeric>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "kernel.h"
#include "ray_blocks.h"

namespace aberfit::internal {
namespace {

constexpr int kBins = 32 << kBinBits;  // 32 octaves of r^2 about the median; the end bins hold rays beyond
constexpr int kLanes = 4;  // separate sums per bin, because neighbouring rays often fall into one bin
constexpr Eigen::Index kChunk = 8192;  // rays that stay in the second-level cache from plane to plane
constexpr int kMostBoundBins = 160;    // bounds from the bins save time while the kernel spans few of them
constexpr int kBoundSteps = 6;         // leaves 1/64 of the bracket, less than a bin
constexpr double kShellMemory = 2e8;   // [bytes] of collected rays, about 5 per ray and plane

double from_leading_bits(std::int64_t leading) {
  return std::bit_cast<double>(std::uint64_t(leading) << (52 - kBinBits));
}

class RadiusSolver {
 public:
  RadiusSolver(const RayBundle& rays, const RaySums& sums, bool about_centroid, double width,
               RayGroups groups, std::vector<RadiusRequest>* requests)
      : rays_(rays),
        sums_(sums),
        about_centroid_(about_centroid),
        width_(width),
        groups_(groups),
        requests_(*requests),
        kernels_(focus_kernels(best_instruction_set())) {}

  // Computes the radii of the planes [begin, end). Threads divide the groups of rays, then the radii.
  void run(RadiusPlane* begin, RadiusPlane* end, int threads) const {
    for (RadiusPlane* plane = begin; plane != end; ++plane) prepare(plane);
    const auto groups = std::size_t(groups_.count);
    parallel_for(groups, threads, [&](std::size_t g) { fill_bins(begin, end, int(g)); });
    parallel_for(std::size_t(end - begin), threads, [&](std::size_t k) { choose_bins(begin + k); });
    parallel_for(groups, threads, [&](std::size_t g) { collect(begin, end, int(g)); });
    for (RadiusPlane* plane = begin; plane != end; ++plane)
      parallel_for(plane->searches.size(), threads,
                   [&](std::size_t k) { solve(*plane, plane->searches[k]); });
  }

 private:
  // Sets the centre and bins about the median of a few rays, because distant rays do not affect a median.
  void prepare(RadiusPlane* plane) const {
    BinnedPlane& b = plane->binned;
    b.centre_x = about_centroid_ ? (sums_.x + b.dz * sums_.tx) / sums_.weight : 0.0;
    b.centre_y = about_centroid_ ? (sums_.y + b.dz * sums_.ty) / sums_.weight : 0.0;
    constexpr Eigen::Index kSample = 63;
    double sample[kSample];
    int seen = 0;
    const Eigen::Index stride = std::max<Eigen::Index>(1, rays_.size() / kSample);
    for (Eigen::Index i = 0; i < rays_.size() && seen < kSample; i += stride) {
      const double x = rays_.x[i] + b.dz * rays_.tx[i] - b.centre_x,
                   y = rays_.y[i] + b.dz * rays_.ty[i] - b.centre_y, r2 = x * x + y * y;
      if (rays_.weight[i] > 0 && r2 > 0 && std::isfinite(r2)) sample[seen++] = r2;
    }
    double middle = 1.0;
    if (seen > 0) {
      std::nth_element(sample, sample + seen / 2, sample + seen);
      middle = sample[seen / 2];
    }
    const std::int64_t leading = std::int64_t(std::bit_cast<std::uint64_t>(middle) >> (52 - kBinBits));
    b.offset = std::clamp<std::int64_t>(leading - kBins / 2, 1, (std::int64_t(2046) << kBinBits) - kBins);
    b.low = from_leading_bits(b.offset);
    b.high = from_leading_bits(b.offset + kBins - 1);
    plane->histogram.assign(std::size_t(groups_.count) * kBins * kLanes, 0.0);
    plane->bins.resize(kBins);
    plane->before.resize(kBins + 1);
    plane->slot.assign(kBins, 0);
  }

  // Visits the blocks of a group, plane by plane within a chunk.
  template <typename Visit>
  void visit_blocks(RadiusPlane* begin, RadiusPlane* end, int group, const Visit& visit) const {
    const Eigen::Index last = groups_.begin(group + 1);
    for (Eigen::Index first = groups_.begin(group); first < last; first += kChunk)
      for (RadiusPlane* plane = begin; plane != end; ++plane)
        for_each_block(
            rays_, first, std::min(last, first + kChunk),
            [&](const RayBlock& block, Eigen::Index at, int used) { visit(plane, block, at, used); });
  }

  void fill_bins(RadiusPlane* begin, RadiusPlane* end, int group) const {
    alignas(64) double r2[kBlockRays];
    alignas(64) std::int32_t bin[kBlockRays];
    visit_blocks(begin, end, group, [&](RadiusPlane* plane, const RayBlock& block, Eigen::Index, int) {
      kernels_.bins(block, plane->binned, r2, bin);
      double* histogram = plane->histogram.data() + std::size_t(group) * kBins * kLanes;
      for (int i = 0; i < block.count; i += kLanes) {
        histogram[kLanes * bin[i]] += block.weight[i];
        histogram[kLanes * bin[i + 1] + 1] += block.weight[i + 1];
        histogram[kLanes * bin[i + 2] + 2] += block.weight[i + 2];
        histogram[kLanes * bin[i + 3] + 3] += block.weight[i + 3];
      }
    });
  }

  static double edge2(const RadiusPlane& plane, int bin) {
    if (bin <= 0) return 0.0;
    return bin >= kBins ? kInfinity : from_leading_bits(plane.binned.offset + bin);
  }
  static int bin_of(const RadiusPlane& plane, double r2) {
    const double inside = std::clamp(r2, plane.binned.low, plane.binned.high);
    return int(std::int64_t(std::bit_cast<std::uint64_t>(inside) >> (52 - kBinBits)) - plane.binned.offset);
  }

  void choose_bins(RadiusPlane* plane) const {
    for (int b = 0; b < kBins; ++b) plane->bins[std::size_t(b)] = 0.0;
    for (int g = 0; g < groups_.count; ++g) {
      const double* h = plane->histogram.data() + std::size_t(g) * kBins * kLanes;
      for (int b = 0; b < kBins; ++b, h += kLanes)
        plane->bins[std::size_t(b)] += (h[0] + h[1]) + (h[2] + h[3]);
    }
    double sum = 0;
    for (int b = 0; b < kBins; ++b) {
      plane->before[std::size_t(b)] = sum;
      sum += plane->bins[std::size_t(b)];
    }
    plane->before[kBins] = sum;
    for (RadiusPlane::Search& search : plane->searches) {
      if (requests_[search.request].of_share)
        touched(*plane, &search);
      else
        width_ > 0 ? bracket(*plane, &search) : partners(*plane, &search);
    }
    unite(plane);
  }

  // The bin in which the cumulative weight passes `wanted`.
  static int quantile_bin(const RadiusPlane& plane, double wanted) {
    int bin =
        int(std::upper_bound(plane.before.begin(), plane.before.end(), wanted) - plane.before.begin()) - 1;
    bin = std::clamp(bin, 0, kBins - 1);
    while (bin > 0 && plane.bins[std::size_t(bin)] == 0.0) --bin;  // only when `wanted` reaches all weight
    return bin;
  }

  // Exact search: a ray counts half at its radius, so a neighbouring bin's ray may be needed.
  void partners(const RadiusPlane& plane, RadiusPlane::Search* search) const {
    const int bin = quantile_bin(plane, requests_[search->request].fraction * sums_.weight);
    search->first_bin = std::max(0, bin - 1);
    while (search->first_bin > 0 && plane.bins[std::size_t(search->first_bin)] == 0.0) --search->first_bin;
    search->last_bin = std::min(kBins - 1, bin + 1);
    while (search->last_bin < kBins - 1 && plane.bins[std::size_t(search->last_bin)] == 0.0)
      ++search->last_bin;
  }

  // Smooth search: brackets the root between two radii, then takes the bins that the kernel reaches.
  void bracket(const RadiusPlane& plane, RadiusPlane::Search* search) const {
    const double wanted = requests_[search->request].fraction * sums_.weight;
    const int bin = quantile_bin(plane, wanted);
    search->too_small = false;
    search->every_bin = bin == 0 || bin == kBins - 1 || !(sums_.weight > 0);
    if (search->every_bin) {
      search->first_bin = 0;
      search->last_bin = kBins - 1;
      return;
    }
    // By SmoothDisc, a ray counts fully below inside2 and not at all above outside2.
    search->too_small = !(std::sqrt(edge2(plane, bin + 1)) > kSmallestSpotInWidths * width_);
    search->low = std::sqrt(width_ * width_ + edge2(plane, bin)) - width_;
    search->high = std::sqrt(width_ * width_ + edge2(plane, bin + 1)) + width_;
    const auto reach = [&](double radius, int* first, int* last) {
      *first = bin_of(plane, radius > width_ ? radius * (radius - 2 * width_) : 0.0);
      *last = bin_of(plane, radius * (radius + 2 * width_));
    };
    int unused;
    reach(search->low, &search->first_bin, &unused);
    reach(search->high, &unused, &search->last_bin);
    if (search->last_bin - search->first_bin > kMostBoundBins || !(search->low > 0)) return;
    // far = 0 puts each bin's weight at its near edge, which gives the upper bound of the count. far = 1 puts
    // it at the far edge, which gives the lower bound.
    const auto bound = [&](double radius, int far) {
      const SmoothDisc disc(radius, width_);
      int first, last;
      reach(radius, &first, &last);
      double count = plane.before[std::size_t(first)];
      for (int b = first; b <= last; ++b)
        count += plane.bins[std::size_t(b)] * disc.share(edge2(plane, b + far));
      return count;
    };
    double below = search->low, above = search->high;
    for (int step = 0; step < kBoundSteps; ++step) {
      const double middle = 0.5 * (below + above);
      (bound(middle, 0) < wanted ? below : above) = middle;
    }
    search->low = below;
    above = search->high;
    for (int step = 0; step < kBoundSteps; ++step) {
      const double middle = 0.5 * (below + above);
      (bound(middle, 1) > wanted ? above : below) = middle;
    }
    search->high = above;
    reach(search->low, &search->first_bin, &unused);
    reach(search->high, &unused, &search->last_bin);
  }

  static bool is_disc(double radius) { return radius > 0 && std::isfinite(radius * radius); }
  // Finds, for a given radius, the bins within the kernel's reach, or the bin of the radius.
  void touched(const RadiusPlane& plane, RadiusPlane::Search* search) const {
    const double radius = requests_[search->request].radius;
    search->every_bin = false;
    search->first_bin = search->last_bin = 0;
    if (!is_disc(radius)) return;
    const SmoothDisc disc(radius, width_);
    search->first_bin = bin_of(plane, disc.inside2);
    search->last_bin = bin_of(plane, disc.outside2);
  }

  void unite(RadiusPlane* plane) const {
    plane->intervals.clear();
    std::sort(plane->searches.begin(), plane->searches.end(), [](const auto& a, const auto& b) {
      return a.first_bin != b.first_bin ? a.first_bin < b.first_bin : a.request < b.request;
    });
    for (RadiusPlane::Search& search : plane->searches) {
      if (plane->intervals.empty() || search.first_bin > plane->intervals.back().last_bin)
        plane->intervals.push_back({search.first_bin, search.last_bin});
      else
        plane->intervals.back().last_bin = std::max(plane->intervals.back().last_bin, search.last_bin);
      search.interval = int(plane->intervals.size()) - 1;
    }
    for (std::size_t k = 0; k < plane->intervals.size(); ++k)
      for (int b = plane->intervals[k].first_bin; b <= plane->intervals[k].last_bin; ++b)
        plane->slot[std::size_t(b)] = std::uint16_t(k + 1);
    plane->shells.resize(
        std::max(plane->shells.size(), plane->intervals.size() * std::size_t(groups_.count)));
    for (RadiusShell& shell : plane->shells) shell.used = 0;
  }

  RadiusShell* shells_of(RadiusPlane* plane, int interval) const {
    return plane->shells.data() + std::size_t(interval) * std::size_t(groups_.count);
  }
  const RadiusShell* shells_of(const RadiusPlane& plane, int interval) const {
    return plane.shells.data() + std::size_t(interval) * std::size_t(groups_.count);
  }

  void collect(RadiusPlane* begin, RadiusPlane* end, int group) const {
    alignas(64) double r2[kBlockRays];
    alignas(64) std::int32_t bin[kBlockRays];
    int hits[kBlockRays];
    visit_blocks(begin, end, group,
                 [&](RadiusPlane* plane, const RayBlock& block, Eigen::Index first, int used) {
                   kernels_.bins(block, plane->binned, r2, bin);
                   const std::uint16_t* slot = plane->slot.data();
                   int found = 0;
                   for (int i = 0; i < used; ++i) {  // branch-free, because few rays are needed
                     hits[found] = i;
                     found += slot[bin[i]] != 0;
                   }
                   for (int k = 0; k < found; ++k) {
                     const int i = hits[k];
                     RadiusShell& shell = shells_of(plane, slot[bin[i]] - 1)[group];
                     const std::size_t at = shell.used++;
                     if (at >= shell.r2.size()) {
                       make_room(shell.r2, at + 1);
                       make_room(shell.weight, at + 1);
                       make_room(shell.ray, at + 1);
                     }
                     shell.r2[at] = r2[i];
                     shell.weight[at] = block.weight[i];
                     shell.ray[at] = std::uint32_t(first + i);
                   }
                 });
    for (RadiusPlane* plane = begin; plane != end; ++plane) {
      for (std::size_t k = 0; k < plane->intervals.size(); ++k) {
        RadiusShell& shell = shells_of(plane, int(k))[group];
        // Spare room, because the next evaluation may find a few more rays.
        const std::size_t spare = shell.used + shell.used / 8 + kRayPadding;
        make_room(shell.r2, spare);
        make_room(shell.weight, spare);
        make_room(shell.ray, spare);
        for (std::size_t i = shell.used; i < shell.padded(); ++i) shell.r2[i] = shell.weight[i] = 0.0;
      }
    }
  }

  void solve(const RadiusPlane& plane, const RadiusPlane::Search& search) const {
    RadiusRequest& request = requests_[search.request];
    if (request.of_share) {
      solve_share(plane, search.interval, &request);
      return;
    }
    const double wanted = request.fraction * sums_.weight;
    if (!(width_ > 0)) {
      request.radius = order_statistic(plane, search.interval, wanted);
      return;
    }
    double start = 0.5 * (search.low + search.high), low = search.low, high = search.high;
    if (search.every_bin) {
      start = order_statistic(plane, search.interval, wanted);
      low = 0;
      high = kInfinity;
    }
    request.radius = std::nan("");
    if (search.too_small || !(start > kSmallestSpotInWidths * width_)) return;
    request.radius = root(plane, search.interval, wanted, start, low, high);
    // Implicit function theorem on count(radius) = fraction * total: d radius = -d count / density.
    if (request.gradient && std::isfinite(request.radius))
      gradient(plane, search.interval, request,
               2.0 / smooth_count(plane, search.interval, request.radius).density);
  }

  void solve_share(const RadiusPlane& plane, int interval, RadiusRequest* request) const {
    if (!is_disc(request->radius)) {
      request->fraction = request->radius <= 0 ? 0.0 : request->radius > 0 ? 1.0 : std::nan("");
      return;
    }
    if (width_ > 0) {
      request->fraction = smooth_count(plane, interval, request->radius).weight / sums_.weight;
      if (request->gradient) gradient(plane, interval, *request, -2.0 / sums_.weight);
      return;
    }
    double sum = plane.before[std::size_t(plane.intervals[std::size_t(interval)].first_bin)];
    const double radius2 = request->radius * request->radius;
    const RadiusShell* shells = shells_of(plane, interval);
    for (int g = 0; g < groups_.count; ++g)
      for (std::size_t i = 0; i < shells[g].used; ++i)
        if (shells[g].r2[i] <= radius2) sum += shells[g].weight[i];
    request->fraction = sum / sums_.weight;
  }

  double order_statistic(const RadiusPlane& plane, int interval, double wanted) const {
    struct Node {
      double radius, weight;
      std::uint32_t ray;
    };
    std::vector<Node> nodes;
    const RadiusShell* shells = shells_of(plane, interval);
    for (int g = 0; g < groups_.count; ++g)
      for (std::size_t i = 0; i < shells[g].used; ++i) {
        const double r2 = shells[g].r2[i];  // NaN goes last, because a sort needs an order
        nodes.push_back({r2 >= 0 ? std::sqrt(r2) : kInfinity, shells[g].weight[i], shells[g].ray[i]});
      }
    std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) {
      return a.radius < b.radius || (a.radius == b.radius && a.ray < b.ray);
    });
    double sum = plane.before[std::size_t(plane.intervals[std::size_t(interval)].first_bin)];
    double previous_sum = 0, previous_radius = 0;
    bool first = true;
    for (const Node& node : nodes) {
      const double here = sum + 0.5 * node.weight;
      sum += node.weight;
      if (here >= wanted) {
        if (first || here == previous_sum) return node.radius;
        return previous_radius +
               (node.radius - previous_radius) * (wanted - previous_sum) / (here - previous_sum);
      }
      previous_sum = here;
      previous_radius = node.radius;
      first = false;
    }
    return previous_radius;
  }

  struct Count {
    double weight, density;  // weight within the radius; its derivative
  };
  Count smooth_count(const RadiusPlane& plane, int interval, double radius) const {
    const SmoothDisc disc(radius, width_);
    const DiscShape shape{0, 0, disc.radius2, disc.scale};
    double sums[2] = {plane.before[std::size_t(plane.intervals[std::size_t(interval)].first_bin)], 0.0};
    const RadiusShell* shells = shells_of(plane, interval);
    for (int g = 0; g < groups_.count; ++g)
      kernels_.count(shells[g].r2.data(), shells[g].weight.data(), int(shells[g].padded()), shape, sums);
    return {sums[0], sums[1] / radius};
  }

  // Newton's method inside a bracket; NaN where the count has no slope.
  double root(const RadiusPlane& plane, int interval, double wanted, double start, double low,
              double high) const {
    double radius = start;
    for (int iteration = 0; iteration < 100; ++iteration) {
      const Count count = smooth_count(plane, interval, radius);
      const double excess = count.weight - wanted;
      (excess > 0 ? high : low) = radius;
      if (count.density > 0) {
        const double step = excess / count.density;
        if (std::abs(step) <= 1e-11 * radius)
          return radius - step;  // convergence is quadratic, so the next step is below rounding
        radius -= step;
      }
      if (!(count.density > 0) || !(radius > low && radius < high))
        radius = std::isfinite(high) ? 0.5 * (low + high) : 2 * low;
      if (std::isfinite(high) && high - low <= 1e-15 * high) break;
    }
    return smooth_count(plane, interval, radius).density > 0 ? radius : std::nan("");
  }

  // Writes -scale/2 times the derivative of the smooth count within the request's radius.
  void gradient(const RadiusPlane& plane, int interval, const RadiusRequest& request, double scale) const {
    const SmoothDisc disc(request.radius, width_);
    const DiscShape shape{0, 0, disc.radius2, disc.scale};
    const RadiusShell* shells = shells_of(plane, interval);
    alignas(64) double density[kBlockRays];
    const auto visit_kernel = [&](const auto& visit) {  // visit(ray, weight * density) for nonzero densities
      for (int g = 0; g < groups_.count; ++g) {
        const RadiusShell& shell = shells[g];
        for (std::size_t first = 0; first < shell.used; first += kBlockRays) {
          const int count = int(std::min<std::size_t>(kBlockRays, shell.padded() - first));
          kernels_.density(shell.r2.data() + first, shell.weight.data() + first, count, shape, density);
          visit(shell.ray.data() + first, density,
                int(std::min<std::size_t>(kBlockRays, shell.used - first)));
        }
      }
    };
    std::size_t rays_in_kernel = 0;
    visit_kernel([&](const std::uint32_t*, const double* d, int count) {
      for (int i = 0; i < count; ++i) rays_in_kernel += d[i] > 0.0;
    });
    RayGradient& g = *request.gradient;
    g.dz = request.dz;
    resize_with_spare(g.rays, rays_in_kernel + 1);  // one more, because entries are written before the test
    std::size_t at = 0;
    resize_with_spare(g.d_x, rays_in_kernel + 1);
    visit_kernel([&](const std::uint32_t* ray, const double* d, int count) {
      for (int i = 0; i < count; ++i) {
        g.rays[at] = ray[i];
        g.d_x[at] = d[i];
        at += d[i] > 0.0;
      }
    });
    g.rays.resize(at);
    g.d_x.resize(at);
    resize_with_spare(g.d_y, at);
    for (std::size_t k = 0; k < at; ++k) {
      const auto i = Eigen::Index(g.rays[k]);
      const double share = scale * g.d_x[k];
      g.d_x[k] = share * (rays_.x[i] + request.dz * rays_.tx[i] - plane.binned.centre_x);
      g.d_y[k] = share * (rays_.y[i] + request.dz * rays_.ty[i] - plane.binned.centre_y);
    }
    if (about_centroid_) follow_centroid(rays_, sums_.weight, &g);
  }

  const RayBundle& rays_;
  const RaySums& sums_;
  bool about_centroid_;
  double width_;
  RayGroups groups_;
  std::vector<RadiusRequest>& requests_;
  const FocusKernels& kernels_;
};

}  // namespace

void follow_centroid(const RayBundle& rays, double total, RayGradient* gradient) {
  const auto n = std::size_t(rays.size());
  for (std::vector<double>* component : {&gradient->d_x, &gradient->d_y}) {
    double sum = 0;
    for (const double d : *component) sum += d;
    const std::size_t listed = gradient->all_rays ? 0 : component->size();
    component->resize(n);
    // Works in place from the back: ray numbers increase, so entry k moves to place k or beyond.
    for (std::size_t k = listed; k-- > 0;) {
      const double value = (*component)[k];
      (*component)[k] = 0.0;
      (*component)[gradient->rays[k]] += value;
    }
    const double share = sum / total;
    for (std::size_t i = 0; i < n; ++i) (*component)[i] -= share * rays.weight[Eigen::Index(i)];
  }
  gradient->rays.clear();
  gradient->all_rays = true;
}

void encircled_radii(const RayBundle& rays, const RaySums& sums, bool about_centroid, double width,
                     int threads, RadiusBuffers* buffers, std::vector<RadiusRequest>* requests) {
  std::vector<RadiusRequest>& wanted = *requests;
  std::vector<std::size_t>& order = buffers->order;
  order.resize(wanted.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return wanted[a].dz != wanted[b].dz ? wanted[a].dz < wanted[b].dz : a < b;
  });
  std::size_t planes = 0;
  for (std::size_t k = 0; k < order.size(); ++k)
    planes += k == 0 || wanted[order[k]].dz != wanted[order[k - 1]].dz;
  if (planes == 0) return;

  // We handle as many planes together as memory allows, so rays are read from memory once for all of them.
  const auto at_once = std::min(
      planes, std::size_t(std::max(
                  1.0, std::floor(kShellMemory / (5.0 * double(std::max<Eigen::Index>(rays.size(), 1)))))));
  // For few planes, threads divide the rays. For many planes, each thread computes its own planes.
  const RayGroups groups(rays.size(), std::max(1, int(16 / at_once)));
  const RadiusSolver solver(rays, sums, about_centroid, width, groups, requests);
  if (buffers->planes.size() < at_once) buffers->planes.resize(at_once);
  RadiusPlane* const first = buffers->planes.data();
  for (std::size_t k = 0; k < order.size();) {
    std::size_t count = 0;
    for (; k < order.size(); ++k) {
      const bool next = count == 0 || wanted[order[k]].dz != first[count - 1].binned.dz;
      if (next && count == at_once) break;
      if (next) {
        first[count].binned.dz = wanted[order[k]].dz;
        first[count++].searches.clear();
      }
      first[count - 1].searches.push_back({order[k]});
    }
    if (groups.count > 1 || count < 2) {
      solver.run(first, first + count, threads);
      continue;
    }
    const std::size_t parts = std::min(count, std::size_t(std::max(threads, 1)));
    parallel_for(parts, threads, [&](std::size_t p) {
      solver.run(first + p * count / parts, first + (p + 1) * count / parts, 1);
    });
  }
}

}  // namespace aberfit::internal
