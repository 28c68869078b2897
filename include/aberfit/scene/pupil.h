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
  kPolar,   ///< Gauss-Legendre in rho^2 times equal angles, each ring turned by the golden angle; circle and
            ///< annulus only
  kRandom,  ///< independent uniform points (the choice of the paper)
  kSobol,   ///< two-dimensional Sobol points with Owen scrambling
  kGrid,    ///< Cartesian grid centred on the axis
};

struct PupilOptions {
  std::optional<PupilLayout> layout;  ///< absent: usual_layout
  /// Wanted number of rays. Random and Sobol points match it; grid and polar points come close to it. When
  /// absent it is kUsualRays, and a fit finds the number it needs.
  std::optional<std::int64_t> rays;
  std::uint64_t seed = 1;  ///< for random and Sobol points
};
inline constexpr std::int64_t kUsualRays = 65536;
/// kPolar for circle and annulus, kSobol for all other shapes.
PupilLayout usual_layout(const Aperture& aperture);
inline PupilLayout layout_of(const Aperture& aperture, const PupilOptions& options) {
  return options.layout ? *options.layout : usual_layout(aperture);
}
inline std::int64_t rays_of(const PupilOptions& options) { return options.rays.value_or(kUsualRays); }

/// Regular structure of a pupil, which lets an operator reuse work between points. Polar rings have equally
/// many, equally spaced points. Point ring * spokes + j lies at radius rho[ring] and angle 2 pi j / spokes +
/// turn[ring].
struct PolarRings {
  Eigen::ArrayXd rho;   ///< [m]
  Eigen::ArrayXd turn;  ///< [rad]
  Eigen::Index spokes = 0;
};
/// Any subset of the points of a Cartesian grid. Point k lies at (x[column[k]], y[row[k]]).
struct CartesianGrid {
  Eigen::ArrayXd x, y;  ///< coordinates of the columns and of the rows [m]
  std::vector<std::uint32_t> column, row;
};
/// Points of a parabola at equal steps of the direction cosine from which light arrives at the focus. Point k
/// lies at (x, y) (1 + t^2) with x = x[column[k]], y = y[row[k]], t = r/2f; x and y are the focal length
/// times the direction cosines.
struct DirectionGrid {
  CartesianGrid cells;
  double focal_length = 0;        ///< [m]
  std::array<double, 2> shift{};  ///< from the symmetric position about the aperture [grid cells]
};
using PupilStructure = std::variant<std::monostate, PolarRings, CartesianGrid, DirectionGrid>;

/// Points of the aperture with weights that sum to 1.
struct PupilSample {
  Eigen::ArrayXd x;       ///< [m]
  Eigen::ArrayXd y;       ///< [m]
  Eigen::ArrayXd weight;  ///< fraction of the incident energy
  PupilLayout layout = PupilLayout::kPolar;
  PupilStructure structure = {};  ///< empty for scattered points
  /// The segment of each grid cell, if the segments of the aperture have errors; else empty. A cell that an
  /// edge between two segments cuts occurs twice.
  std::vector<std::uint32_t> segment = {};
  Eigen::Index size() const { return x.size(); }
};

/// Samples the aperture. Throws ComputationError if the shape lacks the layout or no point fits in the
/// margin.
PupilSample make_pupil(const Aperture& aperture, const PupilOptions& options);

/// First `count` points of the two-dimensional Sobol sequence in [0,1)^2 with Owen scrambling (hash-based,
/// Laine & Karras 2011). Returns 2 x count values.
Eigen::Array2Xd scrambled_sobol(std::int64_t count, std::uint64_t seed);

}  // namespace aberfit
