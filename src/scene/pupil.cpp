#include "aberfit/scene/pupil.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "polar_rule.h"

namespace aberfit {
using namespace internal;

namespace {

struct Ring {
  double inner, outer;  // [m]
};

std::optional<Ring> ring_of(const Aperture& aperture) {
  if (const auto* circle = std::get_if<CircleAperture>(&aperture))
    return Ring{0.0, circle->diameter / 2 - circle->margin};
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture))
    return Ring{annulus->inner_diameter / 2 + annulus->margin, annulus->diameter / 2 - annulus->margin};
  return std::nullopt;
}

[[noreturn]] void no_room() {
  throw ComputationError("no pupil point lies inside the aperture and its margin");
}

PupilSample equal_weights(const std::vector<double>& x, const std::vector<double>& y, PupilLayout layout) {
  if (x.empty()) no_room();
  const auto n = Eigen::Index(x.size());
  return {Eigen::Map<const Eigen::ArrayXd>(x.data(), n),
          Eigen::Map<const Eigen::ArrayXd>(y.data(), n),
          Eigen::ArrayXd::Constant(n, 1.0 / double(n)),
          layout,
          {}};
}

PupilSample polar_pupil(const Ring& ring, std::int64_t rays) {
  if (!(ring.outer > ring.inner)) no_room();
  // Grid cells are about as long as wide: spokes / rings = mean circumference / radial extent.
  const double a = ring.inner, b = ring.outer;
  const double mean_radius = 2.0 / 3.0 * (a * a + a * b + b * b) / (a + b);
  const double aspect = kTwoPi * mean_radius / (b - a);
  const std::int64_t spokes = 8 * nearest_smooth(std::llround(std::sqrt(double(rays) * aspect) / 8));
  const auto rings = std::max<std::int64_t>(1, std::llround(double(rays) / double(spokes)));
  return polar_rule(a, b, rings, spokes);
}

// Points of [0,1)^2 by index: random numbers or a Sobol sequence.
class UnitPoints {
 public:
  UnitPoints(PupilLayout layout, std::uint64_t seed, std::int64_t count) : stream_(seed, "pupil-random") {
    if (layout == PupilLayout::kSobol) sobol_ = scrambled_sobol(count, seed);
  }
  std::array<double, 2> operator()(std::int64_t i) const {
    if (sobol_.cols() == 0) return stream_.uniform_pair(std::uint64_t(i));
    return {sobol_(0, i), sobol_(1, i)};
  }

 private:
  RandomStream stream_;
  Eigen::Array2Xd sobol_;
};

PupilSample scattered_pupil(const Aperture& aperture, PupilLayout layout, std::int64_t rays,
                            std::uint64_t seed) {
  std::vector<double> x, y;
  x.reserve(std::size_t(rays));
  y.reserve(std::size_t(rays));
  if (const auto ring = ring_of(aperture)) {
    if (!(ring->outer > ring->inner)) no_room();
    const UnitPoints points(layout, seed, rays);
    const double a2 = ring->inner * ring->inner, b2 = ring->outer * ring->outer;
    for (std::int64_t i = 0; i < rays; ++i) {
      const auto [u, v] = points(i);
      const double rho = std::sqrt(a2 + (b2 - a2) * u);
      x.push_back(rho * std::cos(kTwoPi * v));
      y.push_back(rho * std::sin(kTwoPi * v));
    }
    return equal_weights(x, y, layout);
  }
  // Rejection from the bounding box. Without a margin, 1.5 times the wanted points over the area are enough.
  const ApertureBox box = bounding_box(aperture);
  const double fill = aperture_area(aperture) / ((box.x1 - box.x0) * (box.y1 - box.y0));
  const double margin = aperture_margin(aperture);
  const auto limit = std::int64_t(double(rays) / fill * 1.5) + 1024;
  for (int round = 0; round < 6 && std::int64_t(x.size()) < rays; ++round) {
    x.clear();
    y.clear();
    const std::int64_t tries = limit << (2 * round);  // a wide margin leaves only a small part of the area
    const UnitPoints points(layout, seed, tries);
    for (std::int64_t i = 0; i < tries && std::int64_t(x.size()) < rays; ++i) {
      const auto [u, v] = points(i);
      const double px = box.x0 + (box.x1 - box.x0) * u, py = box.y0 + (box.y1 - box.y0) * v;
      if (!aperture_contains(aperture, px, py, margin)) continue;
      x.push_back(px);
      y.push_back(py);
    }
    if (x.empty()) no_room();
  }
  return equal_weights(x, y, layout);
}

PupilSample grid_of_pitch(const Aperture& aperture, double pitch) {
  const double margin = aperture_margin(aperture);
  const ApertureBox box = bounding_box(aperture);
  const auto first = [pitch](double low) { return std::int64_t(std::floor(low / pitch)); };
  const auto last = [pitch](double high) { return std::int64_t(std::ceil(high / pitch)); };
  const auto axis = [&](std::int64_t from, std::int64_t to) -> Eigen::ArrayXd {
    Eigen::ArrayXd centres(to - from);
    for (std::int64_t i = from; i < to; ++i) centres[i - from] = (double(i) + 0.5) * pitch;
    return centres;
  };
  CartesianGrid structure{axis(first(box.x0), last(box.x1)), axis(first(box.y0), last(box.y1)), {}, {}};
  std::vector<double> x, y;
  for (Eigen::Index j = 0; j < structure.y.size(); ++j) {
    for (Eigen::Index i = 0; i < structure.x.size(); ++i) {
      const double px = structure.x[i], py = structure.y[j];
      if (!aperture_contains(aperture, px, py, margin)) continue;
      x.push_back(px);
      y.push_back(py);
      structure.column.push_back(std::uint32_t(i));
      structure.row.push_back(std::uint32_t(j));
    }
  }
  PupilSample pupil = equal_weights(x, y, PupilLayout::kGrid);
  pupil.structure = std::move(structure);
  return pupil;
}

PupilSample grid_pupil(const Aperture& aperture, std::int64_t rays) {
  const double pitch = std::sqrt(aperture_area(aperture) / double(rays));
  const PupilSample grid = grid_of_pitch(aperture, pitch);
  if (aperture_margin(aperture) == 0) return grid;
  // The margin removed some points, so we use a finer grid.
  return grid_of_pitch(aperture, pitch * std::sqrt(double(grid.size()) / double(rays)));
}

// Owen's nested uniform scrambling of 32 bits: a random bit that depends on the k bits above flips bit k.
std::uint32_t owen_scramble(std::uint32_t value, std::uint64_t key) {
  std::uint32_t result = 0;
  for (int k = 0; k < 32; ++k) {
    const std::uint64_t prefix = (std::uint64_t(1) << k) | (k == 0 ? 0 : value >> (32 - k));  // marks length
    std::uint64_t hash = key + prefix * 0x9e3779b97f4a7c15ull;  // splitmix64 finaliser
    hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9ull;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebull;
    const std::uint32_t flip = std::uint32_t((hash ^ (hash >> 31)) >> 63);
    result |= (((value >> (31 - k)) & 1u) ^ flip) << (31 - k);
  }
  return result;
}

}  // namespace

Eigen::Array2Xd scrambled_sobol(std::int64_t count, std::uint64_t seed) {
  const RandomStream stream(seed, "sobol-scramble");
  const std::uint64_t key_x = stream.bits(0), key_y = stream.bits(1);
  Eigen::Array2Xd points(2, count);
  for (std::int64_t i = 0; i < count; ++i) {
    std::uint32_t x = 0, y = 0, direction_x = 1u << 31, direction_y = 1u << 31;
    for (std::uint64_t bits = std::uint64_t(i); bits != 0; bits >>= 1) {
      if (bits & 1u) x ^= direction_x, y ^= direction_y;
      direction_x >>= 1;                // van der Corput
      direction_y ^= direction_y >> 1;  // second Sobol dimension: the Pascal matrix modulo 2
    }
    points(0, i) = (double(owen_scramble(x, key_x)) + 0.5) * 0x1p-32;
    points(1, i) = (double(owen_scramble(y, key_y)) + 0.5) * 0x1p-32;
  }
  return points;
}

PupilLayout usual_layout(const Aperture& aperture) {
  return ring_of(aperture) ? PupilLayout::kPolar : PupilLayout::kSobol;
}

PupilSample make_pupil(const Aperture& aperture, const PupilOptions& options) {
  const PupilLayout layout = layout_of(aperture, options);
  const std::int64_t rays = rays_of(options);
  switch (layout) {
    case PupilLayout::kPolar: {
      const auto ring = ring_of(aperture);
      if (!ring)
        throw ComputationError(
            "a polar pupil needs a circular or annular aperture; use sobol, grid or random");
      return polar_pupil(*ring, rays);
    }
    case PupilLayout::kGrid:
      return grid_pupil(aperture, rays);
    case PupilLayout::kRandom:
    case PupilLayout::kSobol:
      break;
  }
  return scattered_pupil(aperture, layout, rays, options.seed);
}

}  // namespace aberfit
