#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/method/task.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/theory/ray_perturbation.h"
#include "aberfit/trace/ray_bundle.h"

/// The paper's own methods, programmed as it describes them.
namespace aberfit::test {

/// The focal numbers that the paper prints [m], [rad].
struct PaperFocus {
  double ee90 = 0, ring_fwhm = 0, scatter_rms = 0;
};
inline PaperFocus paper_focus(const RayBundle& rays, const RayBundle& nominal) {
  const Eigen::VectorXd v = evaluate_exact({rays, nominal, Eigen::ArrayXd(), Centre::kNominal},
                                           {EncircledEnergyRadius{}, RingFwhm{}, ScatterRms{}}, 1);
  return {v[0], v[1], v[2]};
}

/// Ring FWHM by the paper's method [m]: the number of planes, 0.1 mm apart, in which the ring holds at least
/// half of the largest number of rays.
inline double counted_ring_width(const RayBundle& rays, double ring_radius) {
  constexpr double kPitch = 1e-4;
  constexpr int kPlanes = 200;  // to either side
  std::vector<double> inside;
  for (int k = -kPlanes; k <= kPlanes; ++k) {
    const Eigen::ArrayXd x = rays.x + k * kPitch * rays.tx, y = rays.y + k * kPitch * rays.ty;
    inside.push_back((x.square() + y.square() <= ring_radius * ring_radius).select(rays.weight, 0.0).sum());
  }
  const double half = 0.5 * *std::max_element(inside.begin(), inside.end());
  return kPitch * double(std::count_if(inside.begin(), inside.end(), [half](double n) { return n >= half; }));
}

/// The paper's phase Phi = sum sqrt(P0 dA_k) cos(2 pi f_k.x + phi_k) [rad] over modes that are uniform in
/// log f and in angle. dA_k is the area of a mode in the frequency plane, its width taken with log10 where ln
/// is right, and there is no factor 4 pi/lambda (fits/paper-verify).
struct PaperSum {
  static constexpr double kLevel = 1e-20, kLow = 2.5, kHigh = 1e6;  // P0 as printed; [cycles/m]
  static constexpr int kModes = 10000;
  std::vector<FourierMode> modes;
  double gradient = 0;           ///< RMS over both axes [rad/m]
  double expected_gradient = 0;  ///< the same as a mean over the random modes
  double height = 0;             ///< RMS of lambda/(4 pi) Phi [m]
  PaperFocus focus;              ///< of rays that turn by lambda/(4 pi) grad Phi
};
inline PaperSum paper_sum(const Task& task, const PupilSample& pupil, const RayBundle& nominal) {
  using std::numbers::pi;
  constexpr double kLow = PaperSum::kLow, kHigh = PaperSum::kHigh;
  const double decades = std::log10(kHigh / kLow);
  const RandomStream stream(task.trace.pupil.seed, "published-phase");
  TermSet terms;
  terms.radius = aperture_radius(task.aperture);
  Eigen::VectorXd phase(2 * PaperSum::kModes);
  for (int k = 0; k < PaperSum::kModes; ++k) {
    const auto [u, v] = stream.uniform_pair(2 * std::uint64_t(k));
    const double f = kLow * std::pow(kHigh / kLow, u), angle = 2 * pi * v;
    terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
    const double amplitude = std::sqrt(PaperSum::kLevel * 2 * pi * f * f * decades / PaperSum::kModes);
    const double shift = 2 * pi * stream.uniform(2 * std::uint64_t(k) + 1);
    phase[2 * k] = amplitude * std::cos(shift);
    phase[2 * k + 1] = -amplitude * std::sin(shift);
  }
  SurfaceField field;  // heights are phases [rad] here
  SurfaceOperator(terms, pupil, {}).apply(phase, &field);
  const Eigen::ArrayXd w = pupil.weight / pupil.weight.sum();
  const double metres = task.wavelength / (4 * pi);  // of a radian
  PaperSum sum;
  sum.modes = terms.fourier;
  sum.gradient = std::sqrt((w * (field.slope_x.square() + field.slope_y.square())).sum());
  sum.height = metres * std::sqrt((w * field.height.square()).sum());
  // E |grad Phi|^2 = sum P0 dA (2 pi f)^2/2 with E f^4 = (f_max^4 - f_min^4)/(4 ln(f_max/f_min)).
  const double mean_f4 = (std::pow(kHigh, 4) - std::pow(kLow, 4)) / (4 * std::log(kHigh / kLow));
  sum.expected_gradient = std::sqrt(PaperSum::kLevel * 2 * pi * decades * 2 * pi * pi * mean_f4);
  Eigen::Array2Xd slope(2, pupil.size());
  slope.row(0) = metres * field.slope_x.transpose();
  slope.row(1) = metres * field.slope_y.transpose();
  sum.focus = paper_focus(trace_perturbed(task.mirror, pupil, slope, Convention::kPaper), nominal);
  return sum;
}

/// The mean focus of 200 surfaces of Zernikes n = 2..8 with independent coefficients of equal variance and
/// 100 nm RMS in all. The paper's aberration branch may be this.
inline PaperFocus independent_zernikes(const Task& task, int threads) {
  constexpr int kDraws = 200;
  TermSet terms;
  terms.radius = aperture_radius(task.aperture);
  terms.zernike = zernike_modes(2, 8);
  const PupilSample pupil = make_pupil(task.aperture, {PupilLayout::kSobol, 16384, task.trace.pupil.seed});
  const RayBundle nominal = trace_nominal(task.mirror, pupil);
  const SurfaceOperator surface(terms, pupil, {});
  std::vector<PaperFocus> all(kDraws);
  parallel_for(kDraws, threads, [&](std::size_t d) {
    const std::uint64_t seed = RandomStream(task.fit.seed, "independent-terms").bits(d);
    SurfaceField field;
    surface.apply(100e-9 / std::sqrt(double(terms.size())) * draw_white(terms.size(), seed), &field);
    all[d] = paper_focus(trace(task.mirror, pupil, field), nominal);
  });
  PaperFocus mean;
  for (const PaperFocus& one : all) {
    mean.ee90 += one.ee90 / kDraws;
    mean.ring_fwhm += one.ring_fwhm / kDraws;
    mean.scatter_rms += one.scatter_rms / kDraws;
  }
  return mean;
}

}  // namespace aberfit::test
