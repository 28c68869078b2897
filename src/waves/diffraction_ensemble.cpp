#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/waves/diffraction_psf.h"
#include "diffraction_plane.h"
#include "diffraction_workspace.h"

namespace aberfit {
using namespace internal;

namespace {

struct Draw {
  Eigen::ArrayXd transfer;  // by length of lag
  Eigen::ArrayXd energy;    // at the radii asked for
  Eigen::ArrayXd radius;    // of the fractions asked for
  double aliased = 0;
};

struct SampleMoments {
  double mean, deviation;
};

// Mean and standard deviation (n - 1) of values(i), in order of i.
template <typename F>
SampleMoments moments(std::size_t n, const F& values) {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < n; ++i) sum += values(i);
  const double mean = sum / double(n);
  for (std::size_t i = 0; i < n; ++i) squares += (values(i) - mean) * (values(i) - mean);
  return {mean, std::sqrt(squares / double(n - 1))};
}

}  // namespace

DiffractionEnsemble diffraction_ensemble(const DiffractionProblem& problem, double dz, int draws,
                                         const std::function<Eigen::ArrayXd(int)>& draw,
                                         const Eigen::ArrayXd& radius, const Eigen::ArrayXd& fraction,
                                         int threads) {
  if (draws < 2) throw std::invalid_argument("the scatter of an ensemble needs two draws or more");
  const DiffractionScene flat(problem, Eigen::ArrayXd::Zero(problem.pupil.cover.size()), threads);
  if (!flat.has_plane(dz)) throw std::invalid_argument("the plane lies behind the mirror");
  const double largest = flat.field_radius(dz), unit = flat.per_period(dz);
  DiffractionWorkspace workspace;
  DiffractionWorkspace::Buffers& pool = workspace.buffers();
  const DiffractionGrid& grid = pool.prepare(flat);
  std::vector<Draw> found(std::size_t(draws), Draw{});
  parallel_for(found.size(), threads, [&](std::size_t i) {
    const Eigen::ArrayXd height = draw(int(i));
    const DiffractionScene scene(problem, height, 1);
    BorrowedBench bench(pool);
    DiffractionPlane plane(scene, grid, bench->buffers, bench->focused);
    plane.focus(dz);
    found[i].transfer = plane.otf().values();
    found[i].energy =
        radius.unaryExpr([&](double r) { return r >= 0 && r <= largest ? plane.energy(r) : std::nan(""); });
    found[i].radius = fraction.unaryExpr([&](double p) { return plane.radius(p).value_or(std::nan("")); });
    found[i].aliased = scene.phase_steps(height, dz, dz).aliased_share;
  });

  const double root_n = std::sqrt(double(draws));
  DiffractionEnsemble result;
  result.draws = draws;
  result.energy_outside = flat.energy_outside();
  for (const Draw& d : found) result.aliased_share = std::max(result.aliased_share, d.aliased);
  result.radius = radius;
  result.fraction = fraction;
  result.mean = result.standard_error = Eigen::ArrayXd::Zero(radius.size());
  for (Eigen::Index k = 0; k < radius.size(); ++k) {
    const SampleMoments m = moments(found.size(), [&](std::size_t i) { return found[i].energy[k]; });
    result.mean[k] = m.mean;
    result.standard_error[k] = m.deviation / root_n;
  }
  Eigen::ArrayXd transfer = Eigen::ArrayXd::Zero(found[0].transfer.size());
  for (const Draw& d : found) transfer += d.transfer;
  RadialOtf mean(transfer / double(draws));
  result.ee_radius.resize(fraction.size());
  result.ee_radius_standard_error = result.ee_radius_mean = result.ee_radius_deviation = result.ee_radius;
  for (Eigen::Index k = 0; k < fraction.size(); ++k) {
    const std::optional<double> found_radius = mean.radius(fraction[k], largest * unit);
    if (!found_radius) {
      result.ee_radius[k] = result.ee_radius_standard_error[k] = std::nan("");
      result.ee_radius_mean[k] = result.ee_radius_deviation[k] = std::nan("");
      continue;
    }
    const double q = *found_radius;
    result.ee_radius[k] = q / unit;
    const Eigen::ArrayXd weights = RadialOtf::energy_weights(q, transfer.size());
    const SampleMoments energy =
        moments(found.size(), [&](std::size_t i) { return (found[i].transfer * weights).sum(); });
    result.ee_radius_standard_error[k] = energy.deviation / root_n / mean.density(q) / unit;
    const SampleMoments own = moments(found.size(), [&](std::size_t i) { return found[i].radius[k]; });
    result.ee_radius_mean[k] = own.mean;
    result.ee_radius_deviation[k] = own.deviation;
  }
  return result;
}

}  // namespace aberfit
