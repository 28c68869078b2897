#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/focus/circles_of_square.h"
#include "aberfit/waves/diffraction_psf.h"
#include "diffraction_band.h"
#include "diffraction_otf.h"
#include "diffraction_peak_place.h"
#include "diffraction_plane.h"
#include "diffraction_ring.h"
#include "diffraction_workspace.h"

namespace aberfit {
using namespace internal;

namespace {

// If EE'(r) r is below this, the radius lies in a dark ring and has no derivative.
constexpr double kDark = 1e-10;

// Evaluates one statistic in its plane; NaN when it does not exist. The gradient is over the heights.
class DiffractionEvaluator {
 public:
  // `grid` must be the grid of `plane`.
  DiffractionEvaluator(const DiffractionScene& scene, const Eigen::ArrayXd& height,
                       const DiffractionGrid& grid, DiffractionPlane* plane, RingMemory* rings,
                       Eigen::ArrayXd* d_height)
      : scene_(scene), height_(height), grid_(grid), plane_(plane), rings_(rings), d_height_(d_height) {}

  double operator()(const EncircledEnergyRadius& s) const {
    if (!scene_.has_plane(s.dz) || !(s.fraction > 0)) return std::nan("");
    const auto radius = plane_->radius(s.fraction);
    if (!radius) return std::nan("");
    if (d_height_) {
      const double density = plane_->density(*radius);
      if (!(density * *radius > kDark)) return std::nan("");
      *d_height_ = plane_->energy_gradient(*radius).over_heights(-1 / density);
    }
    return *radius;
  }
  double operator()(const RingThrough& s) const {
    if (!scene_.has_plane(s.dz) || !(s.ring_radius > 0) || s.ring_radius > scene_.largest_radius(s.dz))
      return std::nan("");
    if (d_height_) *d_height_ = plane_->energy_gradient(s.ring_radius, true).over_heights();
    return plane_->energy(s.ring_radius);
  }
  double operator()(const RingFwhm& s) const {
    double ring = s.ring_radius.value_or(0.0), d_ring = 0;
    Eigen::ArrayXd d_phase, d_phase_of_ring;
    if (!s.ring_radius) {
      plane_->focus(0.0);
      const auto radius = plane_->radius(s.ring_fraction);
      if (!radius) return std::nan("");
      ring = *radius;
      if (d_height_) {
        const double density = plane_->density(ring);
        if (!(density * ring > kDark)) return std::nan("");
        d_phase_of_ring = -1 / density * plane_->energy_gradient(ring).over_phases();
      }
    }
    const auto width =
        diffraction_ring_width(scene_, plane_, rings_, ring, d_height_ ? &d_phase : nullptr, &d_ring);
    if (!width) return std::nan("");
    const PhaseSteps steps = scene_.phase_steps(height_, width->lower, width->upper);
    if (steps.aliased_share > scene_.problem().aliased_limit) return std::nan("");
    if (d_height_) {
      *d_height_ = per_height() * d_phase;
      if (!s.ring_radius) *d_height_ += d_ring * per_height() * d_phase_of_ring;
    }
    return width->fwhm;
  }
  double operator()(const SpotFwhm& s) const {
    if (!(s.bandwidth >= 0)) return std::nan("");
    const DiffractionProblem& problem = scene_.problem();
    const double waves = problem.wavelength * problem.focal_length;
    // A Gaussian smoothing of the profile is a factor on the transfer function.
    const auto blur = [&](Eigen::Index lags, double pitch) -> Eigen::ArrayXd {
      const Eigen::ArrayXd nu = Eigen::ArrayXd::LinSpaced(lags, 0.0, double(lags - 1)) * (pitch / waves);
      return (-2 * kPi * kPi * s.bandwidth * s.bandwidth * nu.square()).exp();
    };
    const double pitch_x = problem.pupil.pitch_x, pitch_y = problem.pupil.pitch_y;
    const Eigen::ArrayXd blur_x = blur(plane_->along_x().size(), pitch_x);
    const Eigen::ArrayXd blur_y = blur(plane_->along_y().size(), pitch_y);
    Eigen::ArrayXcd g_x, g_y;
    const auto x = otf_line_width(plane_->along_x() * blur_x, d_height_ ? &g_x : nullptr);
    const auto y = otf_line_width(plane_->along_y() * blur_y, d_height_ ? &g_y : nullptr);
    if (!x || !y) return std::nan("");
    const double half_x = 0.5 * waves / pitch_x, half_y = 0.5 * waves / pitch_y;
    if (d_height_) {
      g_x *= half_x * blur_x;
      g_y *= half_y * blur_y;
      *d_height_ = plane_->axis_gradient(g_x, g_y).over_heights();
    }
    return half_x * *x + half_y * *y;
  }
  // A tilt moves the highest point onto the axis, where the sum over lags gives a value and a gradient. The
  // gradient may ignore the shift of that point, because the irradiance is stationary there.
  double operator()(const StrehlRatio&) const {
    const FocalPlace place = highest_place(scene_, grid_);
    if (place.u == 0 && place.v == 0) return strehl_on_axis(scene_, plane_);
    const DiffractionScene tilted(scene_.problem(), height_ + tilt_from(scene_, place), 1);
    BorrowedBench bench(grid_);
    DiffractionPlane plane(tilted, grid_, bench->buffers, bench->focused);
    plane.focus(0);
    return strehl_on_axis(tilted, &plane);
  }
  // The sum of the energy within the field of view, and of energy beyond the grid from the mean spot.
  double operator()(const ModulationTransfer& s) const {
    const double unit = scene_.per_period(0), lag = s.frequency / unit;
    const Eigen::ArrayXd& values = plane_->otf().values();
    if (!(s.frequency >= 0) || !std::isfinite(lag)) return std::nan("");
    const Eigen::ArrayXd weights =
        RadialOtf::transfer_weights(scene_.field_radius(0) * unit, lag, values.size());
    const MeanScatter* scatter = scene_.problem().scatter.get();
    const double transfer = (weights * values).sum() + (scatter ? scatter->image_transfer(s.frequency) : 0);
    if (d_height_) *d_height_ = plane_->sum_gradient(transfer < 0 ? -weights : weights).over_heights();
    return std::abs(transfer);
  }
  double operator()(const EnsquaredThrough& s) const {
    if (!scene_.has_plane(s.dz) || !(s.side > 0)) return std::nan("");
    const double unit = scene_.per_period(s.dz), side = s.side * unit;
    if (s.side / std::numbers::sqrt2 > scene_.largest_radius(s.dz)) return std::nan("");
    const Quadrature circles = circles_of_square(kTwoPi * side * scene_.longest_lag());
    const Eigen::Index nodes = plane_->otf().values().size();
    Eigen::ArrayXd weights = Eigen::ArrayXd::Zero(nodes);
    double sum = 0;
    for (Eigen::Index k = 0; k < circles.nodes.size(); ++k) {
      const double q = circles.nodes[k] * side, end = scene_.field_radius(s.dz) * unit;
      sum += circles.weights[k] * plane_->otf().energy(q);
      if (d_height_) weights += circles.weights[k] * RadialOtf::energy_weights(std::min(q, end), nodes);
    }
    if (d_height_) *d_height_ = plane_->sum_gradient(weights).over_heights();
    return sum;
  }
  double operator()(const MomentKind auto&) const { return std::nan(""); }
  double operator()(const RayKind auto&) const { return std::nan(""); }

 private:
  const Eigen::ArrayXd& per_height() const { return scene_.per_height(); }

  double strehl_on_axis(const DiffractionScene& scene, DiffractionPlane* plane) const {
    const Eigen::Index nodes = plane->otf().values().size();
    if (d_height_)
      *d_height_ =
          plane->sum_gradient(Eigen::ArrayXd::Constant(nodes, 1 / scene.perfect_irradiance())).over_heights();
    return axis_ratio(scene, *plane);
  }

  const DiffractionScene& scene_;
  const Eigen::ArrayXd& height_;
  const DiffractionGrid& grid_;
  DiffractionPlane* plane_;
  RingMemory* rings_;
  Eigen::ArrayXd* d_height_;
};

// Statistics that one thread evaluates in one plane, or a single statistic that moves the plane.
struct Job {
  std::optional<double> dz;
  std::vector<std::size_t> statistics;
};

std::vector<Job> jobs_of(const std::vector<Statistic>& statistics) {
  std::vector<Job> jobs;
  std::map<double, std::vector<std::size_t>> planes;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto dz = plane_of_light(statistics[k]);
    if (!dz)
      jobs.push_back({std::nullopt, {k}});  // first, because searches take longest
    else if (std::isfinite(*dz))            // otherwise the value stays NaN
      planes[*dz].push_back(k);
  }
  for (auto& [dz, members] : planes) jobs.push_back({dz, std::move(members)});
  return jobs;
}

}  // namespace

std::shared_ptr<const MeanScatter> MeanScatter::of_line(std::size_t) const {
  throw ComputationError(
      "the scatter of this surface is known at one wavelength only; request light of one wavelength");
}

bool evaluate_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                          const std::vector<Statistic>& statistics, int threads,
                          DiffractionWorkspace* workspace, Eigen::VectorXd* values,
                          std::vector<Eigen::ArrayXd>* d_height, const GradientReduction& reduce) {
  values->setConstant(Eigen::Index(statistics.size()), std::nan(""));
  if (d_height) d_height->assign(statistics.size(), {});
  if (!height.allFinite()) return false;
  if (problem.wavelength.is_band())
    return evaluate_band(problem, height, statistics, threads, workspace, values, d_height, reduce);
  const DiffractionScene scene(problem, height, threads);
  std::vector<Job> jobs = jobs_of(statistics);
  double low = 0, high = 0;
  for (const Job& job : jobs) {
    if (!job.dz || !scene.has_plane(*job.dz)) continue;
    low = std::min(low, *job.dz);
    high = std::max(high, *job.dz);
  }
  if (scene.phase_steps(height, low, high).aliased_share > problem.aliased_limit) return false;
  DiffractionWorkspace own;
  DiffractionWorkspace::Buffers& pool = (workspace ? *workspace : own).buffers();
  pool.prepare(scene);
  std::vector<FocusedField*> kept(jobs.size(), nullptr);
  if (workspace) {
    std::vector<double> planes;
    for (const Job& job : jobs)
      if (job.dz) planes.push_back(*job.dz);
    pool.look_at(scene, planes);
    for (std::size_t j = 0; j < jobs.size(); ++j)
      if (jobs[j].dz && scene.has_plane(*jobs[j].dz)) kept[j] = pool.plane(*jobs[j].dz);
  }
  const DiffractionPlane::Mean mean = jobs.size() > kMostPlanesOfTheirOwn ? DiffractionPlane::Mean::kInFocus
                                                                          : DiffractionPlane::Mean::kInPlane;
  parallel_for(jobs.size(), threads, [&](std::size_t j) {
    const Job& job = jobs[j];
    BorrowedBench bench(*pool.grid);
    DiffractionPlane plane(scene, *pool.grid, bench->buffers, kept[j] ? *kept[j] : bench->focused);
    if (job.dz && scene.has_plane(*job.dz)) plane.focus(*job.dz, mean);
    for (const std::size_t k : job.statistics) {
      const DiffractionEvaluator evaluate(scene, height, *pool.grid, &plane,
                                          workspace ? &pool.rings : nullptr,
                                          d_height ? &(*d_height)[k] : nullptr);
      (*values)[Eigen::Index(k)] = std::visit(evaluate, statistics[k]);
      if (d_height && reduce && (*d_height)[k].size() > 0) (*d_height)[k] = reduce((*d_height)[k]);
    }
  });
  return values->allFinite();
}

DiffractionCheck check_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                   double dz) {
  // A failed fit calls this to find the reason, so we accept heights that are not finite.
  const bool finite = height.allFinite();
  const DiffractionScene scene(problem, finite ? height : Eigen::ArrayXd::Zero(height.size()), 1);
  if (!scene.has_plane(dz)) throw std::invalid_argument("the plane lies behind the mirror");
  const PhaseSteps steps =
      finite ? scene.phase_steps(height, dz, dz) : PhaseSteps{std::nan(""), std::nan("")};
  DiffractionCheck check;
  if (!finite)
    check.warnings.push_back(
        {"psf-not-finite", "the surface has heights that are not finite, so it has no PSF"});
  check.energy_outside = scene.energy_outside();
  check.field_of_view = 2 * scene.field_radius(dz);
  check.largest_step = steps.largest;
  check.aliased_share = steps.aliased_share;
  if (steps.aliased_share > problem.aliased_limit)
    check.warnings.push_back(
        {"psf-aliased",
         (dz == 0 ? "the surface is too steep for the pupil grid: the phase turns"
                  : "the pupil grid is too coarse for the plane " + format_quantity(dz, Dimension::kLength) +
                        " out of focus: the phase there turns") +
             " by more than pi between " + format_quantity(steps.aliased_share, Dimension::kFraction) +
             " of neighbouring grid points, so energy lands in the wrong place; take a finer grid or " +
             (dz == 0 ? "a less steep surface" : "a plane nearer to the focus")});
  if (problem.pupil.missing > 0.01)
    check.warnings.push_back(
        {"psf-holes", format_quantity(problem.pupil.missing, Dimension::kFraction) +
                          " of the aperture has no measured heights and was taken as opaque"});
  return check;
}

Eigen::ArrayXd diffraction_encircled_energy(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                            double dz, const Eigen::ArrayXd& radius) {
  const DiffractionScene scene(problem, height, 1);
  if (!scene.has_plane(dz)) return Eigen::ArrayXd::Constant(radius.size(), std::nan(""));
  const DiffractionGrid grid(scene);
  DiffractionBench bench(grid.transform);
  DiffractionPlane plane(scene, grid, bench.buffers, bench.focused);
  plane.focus(dz, DiffractionPlane::Mean::kInPlane);
  return radius.unaryExpr(
      [&](double r) { return r >= 0 && r <= scene.largest_radius(dz) ? plane.energy(r) : std::nan(""); });
}

}  // namespace aberfit
