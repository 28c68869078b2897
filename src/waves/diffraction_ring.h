#pragma once
#include <Eigen/Core>
#include <optional>

#include "diffraction_plane.h"
#include "diffraction_workspace.h"

namespace aberfit::internal {

struct DiffractionRingWidth {
  double fwhm, peak, lower, upper;  ///< FWHM and planes from z = f [m]
};

/// FWHM of N(z), the encircled energy of radius `ring` [m], between the half crossings nearest to its highest
/// peak. Moves `plane`. memory: earlier searches of the same surface; may be null. d_phase (set) and d_ring:
/// derivatives of the FWHM with respect to the phases and the ring's radius. Returns nothing when N does not
/// fall to half on both sides within the search range.
std::optional<DiffractionRingWidth> diffraction_ring_width(const DiffractionScene& scene,
                                                           DiffractionPlane* plane, RingMemory* memory,
                                                           double ring, Eigen::ArrayXd* d_phase,
                                                           double* d_ring);

}  // namespace aberfit::internal
