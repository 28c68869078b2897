#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "aberfit/scene/aperture.h"

namespace aberfit {

enum class PupilLayout {
  kPolar,   ///< Gauss-Legendre in rho^2 times equal angles, every ring turned by a golden-angle step; circle and annulus only
  kRandom,  ///< independent uniform points (the paper's choice)
  kSobol,   ///< two-dimensional Sobol points with Owen scrambling
  kGrid,    ///< Cartesian grid centred on the axis
};

struct PupilOptions {
  PupilLayout layout = PupilLayout::kPolar;
  std::int64_t rays = 65536;  ///< wanted number; grid and polar come near it, random and sobol meet it
  std::uint64_t seed = 1;     ///< random and sobol
};

/// Points of the aperture with weights that sum to 1.
struct PupilSample {
  Eigen::ArrayXd x;       ///< [m]
  Eigen::ArrayXd y;       ///< [m]
  Eigen::ArrayXd weight;  ///< share of the light
  PupilLayout layout = PupilLayout::kPolar;
  Eigen::Index size() const { return x.size(); }
};

/// Samples the aperture. Throws ComputationError when the layout does not exist for the shape or no point fits inside the margin.
PupilSample make_pupil(const Aperture& aperture, const PupilOptions& options);

/// First `count` points of the two-dimensional Sobol sequence in [0,1)^2 with Owen scrambling (hash-based, Laine & Karras 2011), 2 x count.
Eigen::Array2Xd scrambled_sobol(std::int64_t count, std::uint64_t seed);

}  // namespace aberfit
