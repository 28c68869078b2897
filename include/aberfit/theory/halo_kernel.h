#pragma once
#include <Eigen/Core>

#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// A scatter function as an image: the kernel with which the PSF of a surface is convolved to get that of the
/// surface with its scatter. PSF = core PSF + (PSF convolved with `fraction`); core + halo + beyond = 1.
struct HaloKernel {
  Eigen::ArrayXXd fraction;  ///< of the energy, per pixel; column = x, row = y, the axis in the middle
  double pixel = 0;          ///< side [direction cosine]; times the focal length it is a length in the focus
  double core = 1;           ///< fraction that is not scattered, 1 - TIS
  double halo = 0;           ///< sum of `fraction`
  double beyond = 0;         ///< fraction scattered beyond the frame
};

/// The kernel on pixels x pixels squares of side `pixel` [direction cosine]. The specular direction is in the
/// middle: in the middle of a pixel if their number is odd, at a corner if it is even. A pixel has the
/// integral of the BSDF over its area, even where the PSD jumps inside it (round_pixels). Error of the energy
/// in the frame: 1e-10 for a smooth PSD, 3e-9 for one with edges, 6e-7 for a narrow band at g = 2, whose
/// higher orders have kinks. Throws std::invalid_argument unless pixel > 0 and 1 <= pixels <=
/// kMostKernelPixels.
HaloKernel halo_kernel(const ScatterFunction& scatter, double pixel, int pixels);
inline constexpr int kMostKernelPixels = 4097;  ///< a kernel of 134 MB

}  // namespace aberfit
