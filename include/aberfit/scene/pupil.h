#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

enum class PupilLayout {
  kPolar,   ///< Gauss-Legendre in rho^2 times equal angles, every ring turned by a golden-angle step; circle
            ///< and annulus only
  kRandom,  ///< independent uniform points (the paper's choice)
  kSobol,   ///< two-dimensional Sobol points with Owen scrambling
  kGrid,    ///< Cartesian grid centred on the axis
};

struct PupilOptions {
  std::optional<PupilLayout> layout;  ///< absent: that of usual_layout
  /// Wanted number, grid and polar come near it, random and sobol meet it; absent: kUsualRays, and a fit
  /// finds how many it needs.
  std::optional<std::int64_t> rays;
  std::uint64_t seed = 1;  ///< random and sobol
};
inline constexpr std::int64_t kUsualRays = 65536;
/// kPolar for the shapes that have it, circle and annulus, kSobol for all others.
PupilLayout usual_layout(const Aperture& aperture);
inline PupilLayout layout_of(const Aperture& aperture, const PupilOptions& options) {
  return options.layout ? *options.layout : usual_layout(aperture);
}
inline std::int64_t rays_of(const PupilOptions& options) { return options.rays.value_or(kUsualRays); }

/// Regular structure of a pupil: what lets an operator share work between its points.
/// Rings of equally many, equally spaced points: point ring * spokes + j lies at radius rho[ring] and angle 2
/// pi j / spokes + turn[ring].
struct PolarRings {
  Eigen::ArrayXd rho;   ///< [m]
  Eigen::ArrayXd turn;  ///< [rad]
  Eigen::Index spokes = 0;
};
/// Points of a Cartesian grid, any subset of it: point k lies at (x[column[k]], y[row[k]]).
struct CartesianGrid {
  Eigen::ArrayXd x, y;  ///< coordinates of the columns and of the rows [m]
  std::vector<std::uint32_t> column, row;
};
/// Points of a mirror from where light meets the focus of its parabola at equal steps of the direction
/// cosine: point k lies at (x, y) (1 + t^2), x = x[column[k]] and y = y[row[k]] focal lengths times the
/// direction cosines, t = r/2f.
struct DirectionGrid {
  CartesianGrid cells;
  double focal_length = 0;        ///< [m]
  std::array<double, 2> shift{};  ///< of the cells from where they are symmetric about the aperture [cells]
};
using PupilStructure = std::variant<std::monostate, PolarRings, CartesianGrid, DirectionGrid>;

/// Points of the aperture with weights that sum to 1.
struct PupilSample {
  Eigen::ArrayXd x;       ///< [m]
  Eigen::ArrayXd y;       ///< [m]
  Eigen::ArrayXd weight;  ///< share of the light
  PupilLayout layout = PupilLayout::kPolar;
  PupilStructure structure = {};  ///< nothing for scattered points
  /// The segment that each cell is a part of, if the segments of the aperture err; else empty, as points are
  /// where they are. A cell that an edge between two segments cuts is there twice.
  std::vector<std::uint32_t> segment = {};
  Eigen::Index size() const { return x.size(); }
};

/// Samples the aperture. Throws ComputationError when the layout does not exist for the shape or no point
/// fits inside the margin.
PupilSample make_pupil(const Aperture& aperture, const PupilOptions& options);

/// First `count` points of the two-dimensional Sobol sequence in [0,1)^2 with Owen scrambling (hash-based,
/// Laine & Karras 2011), 2 x count.
Eigen::Array2Xd scrambled_sobol(std::int64_t count, std::uint64_t seed);

}  // namespace aberfit
