#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "aberfit/core/random.h"
#include "chart_families.h"
#include "dual.h"

namespace aberfit {
namespace {

constexpr std::size_t kSample = 6;  // coefficients; more cost time and tell the same
constexpr double kSteps[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};  // of a prior sigma
// Above this the Gauss-Newton step is no better than the linear solver leaves it (eta of fit/calibrate.cpp).
constexpr double kGradientTolerance = 1e-3;

Eigen::VectorXd prior_sigmas(const CoefficientPrior& prior) {
  Eigen::VectorXd sigma(prior.size());
  for (const CoefficientPrior::Block& block : prior.blocks())
    for (std::size_t i = 0; i < block.index.size(); ++i)
      sigma[block.index[i]] = block.factor.row(Eigen::Index(i)).norm();
  return sigma;
}

// Coefficients to try, drawn without repetition among those that may move.
std::vector<Eigen::Index> sample_of(const Eigen::VectorXd& sigma, std::uint64_t seed) {
  std::vector<Eigen::Index> all;
  for (Eigen::Index j = 0; j < sigma.size(); ++j)
    if (sigma[j] > 0) all.push_back(j);
  const RandomStream stream(seed, "chart-coefficients");
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    std::swap(all[i], all[i + std::size_t(stream.bits(i) % (all.size() - i))]);
  all.resize(std::min(all.size(), kSample));
  return all;
}

// The one term of a coefficient, which is all that its column of L needs; `unit` gets its coefficients.
TermSet one_term(const TermSet& terms, Eigen::Index j, Eigen::VectorXd* unit) {
  TermSet one;
  one.radius = terms.radius;
  *unit = Eigen::VectorXd::Ones(1);
  if (j < terms.fourier_begin()) {
    one.zernike = {terms.zernike[std::size_t(j)]};
  } else if (j < terms.spherical_begin()) {
    const auto k = std::size_t(j - terms.fourier_begin());
    one.fourier = {terms.fourier[k / 2]};
    *unit = k % 2 == 0 ? Eigen::Vector2d(1, 0) : Eigen::Vector2d(0, 1);
  } else {
    one.spherical = {terms.spherical[std::size_t(j - terms.spherical_begin())]};
  }
  return one;
}

// Derivatives of the rays along one coefficient: the templated physics with a dual number.
struct RayTangents {
  Eigen::ArrayXd x, y, tx, ty;
};
RayTangents ray_tangents(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                         const SurfaceField& column) {
  const Eigen::Index n = pupil.size();
  RayTangents t{Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const SurfacePoint<double> base = base_surface(mirror, pupil.x[i], pupil.y[i]);
    const SurfacePoint<Dual> s{{base.height + field.height[i], column.height[i]},
                               {base.slope_x + field.slope_x[i], column.slope_x[i]},
                               {base.slope_y + field.slope_y[i], column.slope_y[i]}};
    const Ray<Dual> ray = reflect(mirror.focal_length, Dual{pupil.x[i], 0}, Dual{pupil.y[i], 0}, s);
    t.x[i] = ray.x.derivative;
    t.y[i] = ray.y.derivative;
    t.tx[i] = ray.tx.derivative;
    t.ty[i] = ray.ty.derivative;
  }
  return t;
}

double along(const StatisticGradient& gradient, const RayTangents& t, const SurfaceField& column) {
  if (gradient.d_height.size() > 0) return (gradient.d_height * column.height).sum();
  const RayGradient& g = gradient.rays;
  const std::size_t entries = g.all_rays ? std::size_t(t.x.size()) : g.rays.size();
  const auto of = [](const std::vector<double>& component, std::size_t k) {
    return component.empty() ? 0.0 : component[k];
  };
  double sum = 0;
  for (std::size_t k = 0; k < entries; ++k) {
    const Eigen::Index i = g.all_rays ? Eigen::Index(k) : Eigen::Index(g.rays[k]);
    const double d_x = of(g.d_x, k), d_y = of(g.d_y, k);
    sum += d_x * t.x[i] + d_y * t.y[i] + (of(g.d_tx, k) + g.dz * d_x) * t.tx[i] +
           (of(g.d_ty, k) + g.dz * d_y) * t.ty[i];
  }
  return sum;
}

using Values = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

// Columns (f(c + h e) - f(c - h e)) / 2h for the sampled coefficients, h = step sigma, times sigma.
Eigen::MatrixXd differences(const Values& f, const Eigen::VectorXd& c, const Eigen::VectorXd& sigma,
                            const std::vector<Eigen::Index>& sample, double step) {
  Eigen::MatrixXd columns;
  for (std::size_t k = 0; k < sample.size(); ++k) {
    Eigen::VectorXd up = c, down = c;
    up[sample[k]] += step * sigma[sample[k]];
    down[sample[k]] -= step * sigma[sample[k]];
    const Eigen::VectorXd column = (f(up) - f(down)) / (2 * step);
    columns.conservativeResize(column.size(), Eigen::Index(k + 1));
    columns.col(Eigen::Index(k)) = column;
  }
  return columns;
}

// Ridders' extrapolation of central differences to step 0 (Ridders 1982; Numerical Recipes 5.7), every
// statistic with the entry of its tableaus that changed least. Two of them: few rays in a narrow kernel make
// a ring width jump within 1e-4 sigma now and then, and smaller steps alone would lose digits of the others.
Eigen::MatrixXd ridders(const Values& f, const Eigen::VectorXd& c, const Eigen::VectorXd& sigma,
                        const std::vector<Eigen::Index>& sample) {
  constexpr int kRows = 7;
  constexpr double kShrink = 1.6;
  Eigen::MatrixXd best, change;
  for (const double first : {1e-3, 1e-5}) {
    std::array<std::array<Eigen::MatrixXd, kRows>, kRows> a;
    double step = first;
    for (int i = 0; i < kRows; ++i, step /= kShrink) {
      a[0][std::size_t(i)] = differences(f, c, sigma, sample, step);
      if (best.size() == 0) {
        best = a[0][0];
        change = Eigen::MatrixXd::Constant(best.rows(), best.cols(), INFINITY);
      }
      double factor = kShrink * kShrink;
      for (int j = 1; j <= i; ++j, factor *= kShrink * kShrink) {
        const Eigen::MatrixXd &finer = a[std::size_t(j - 1)][std::size_t(i)],
                              &coarser = a[std::size_t(j - 1)][std::size_t(i - 1)];
        Eigen::MatrixXd& here = a[std::size_t(j)][std::size_t(i)];
        here = (finer * factor - coarser) / (factor - 1);
        const Eigen::MatrixXd moved = (here - finer).cwiseAbs().cwiseMax((here - coarser).cwiseAbs());
        best = (moved.array() < change.array()).select(here, best);
        change = change.cwiseMin(moved);
      }
    }
  }
  return best;
}

// Per statistic the length of the difference over the length of the reference, over the sampled
// coefficients. Statistics that the sample does not move do not count.
StatisticErrors gradient_errors(const Eigen::MatrixXd& gradients, const Eigen::MatrixXd& reference) {
  std::vector<double> errors;
  for (Eigen::Index k = 0; k < reference.rows(); ++k) {
    const double length = reference.row(k).norm();
    if (!(length > 0)) continue;
    errors.push_back((gradients.row(k) - reference.row(k)).norm() / length);
  }
  return worst_and_rms(errors);
}

}  // namespace

ChartFamily chart_derivatives(const ChartBench& bench, double seconds) {
  ChartFamily family{"derivatives",
                     "Ways to the Jacobian",
                     "largest relative error of a statistic's gradient",
                     "values and full Jacobian (columns of a sample scaled to all terms)",
                     kGradientTolerance,
                     "what the linear solver leaves",
                     {},
                     "",
                     ""};
  const Eigen::VectorXd& c = bench.coefficients;
  const Eigen::VectorXd sigma = prior_sigmas(bench.prior);
  const std::vector<Eigen::Index> sample = sample_of(sigma, bench.task.fit.seed);
  const double columns = double(c.size()), sampled = double(sample.size());
  const auto trace_of = [&](std::int64_t rays) {
    return ChartTrace(bench, bench.terms,
                      make_pupil(bench.task.aperture, pupil_of_at_most(bench.task, rays)), bench.threads);
  };
  // One pass over the sampled columns is to take half of what one step may.
  constexpr std::int64_t kProbe = 4096;
  const double share = seconds / (std::size(kSteps) * 2 + 8);
  Eigen::VectorXd values;
  ChartTrace probe = trace_of(kProbe);
  const double once = measure_time(0.05 * seconds, [&] {
                        probe.smooth(c, bench.statistics, bench.smoothing, &values, nullptr);
                      }).median;
  const double affordable = double(kProbe) * 0.5 * share / (2 * sampled * std::max(once, 1e-6));
  ChartTrace at = trace_of(std::int64_t(std::max(double(kProbe), affordable)));

  bench.say("chart: Jacobian by adjoints");
  Eigen::MatrixXd jacobian;
  bool exists = false;
  const ChartTime adjoint_time = measure_time(
      share, [&] { exists = at.smooth(c, bench.statistics, bench.smoothing, &values, &jacobian); });
  if (!exists) {
    family.skipped = "A statistic of the draw has no derivative: the kernel is too narrow for so few rays.";
    return family;
  }
  Eigen::MatrixXd adjoint(jacobian.rows(), Eigen::Index(sample.size()));
  for (std::size_t k = 0; k < sample.size(); ++k)
    adjoint.col(Eigen::Index(k)) = jacobian.col(sample[k]) * sigma[sample[k]];

  bench.say("chart: Jacobian by forward mode");
  const SurfaceField field = at.field();
  Eigen::MatrixXd forward(adjoint.rows(), adjoint.cols());
  const ChartTime forward_time = measure_time(share, [&] {
    for (std::size_t k = 0; k < sample.size(); ++k) {
      Eigen::VectorXd unit;
      const TermSet one = one_term(bench.terms, sample[k], &unit);
      SurfaceField column;
      SurfaceOperator(one, at.pupil(), OperatorOptions{bench.threads, {}, {}})
          .apply(unit * sigma[sample[k]], &column);
      const RayTangents tangents = ray_tangents(bench.task.mirror, at.pupil(), field, column);
      for (Eigen::Index s = 0; s < forward.rows(); ++s)
        forward(s, Eigen::Index(k)) = along(at.gradients()[std::size_t(s)], tangents, column);
    }
  });

  // What all columns share: values and gradients over the rays.
  const double shared_time =
      measure_time(share, [&] {
        std::vector<StatisticGradient> gradients;
        const FocusInput input{at.rays(), at.nominal(), field.height, bench.task.trace.centre};
        evaluate_smooth(input, bench.statistics, bench.smoothing, bench.threads, &values, &gradients);
      }).median;

  const Values smooth = [&](const Eigen::VectorXd& at_c) {
    Eigen::VectorXd result;
    if (!at.smooth(at_c, bench.statistics, bench.smoothing, &result, nullptr))
      result.setConstant(std::nan(""));
    return result;
  };
  const Values exact = [&](const Eigen::VectorXd& at_c) { return at.exact(at_c, bench.statistics); };
  bench.say("chart: Jacobian by Ridders' extrapolation");
  const StatisticErrors certainty = gradient_errors(adjoint, ridders(smooth, c, sigma, sample));

  const auto add = [&](const std::string& method, double step, const ChartTime& time, double scale,
                       const StatisticErrors& errors, const std::string& reference) -> ChartRow& {
    ChartRow row;
    row.family = family.name;
    row.method = method;
    row.value = step;
    row.parameter = std::isfinite(step) ? "step" : "";
    row.unit = std::isfinite(step) ? "prior sigma" : "1";
    row.rays = at.pupil().size();
    row.terms = c.size();
    row.statistics = std::int64_t(bench.statistics.size());
    row.error = errors.worst;
    row.error_rms = errors.rms;
    row.reference = reference;
    row.error_of_reference = certainty.worst;
    set_time({scale * time.median, scale * time.low, scale * time.high, time.repeats}, &row);
    family.rows.push_back(std::move(row));
    return family.rows.back();
  };
  const std::string doubt = "; both differ from Ridders' extrapolation by error_of_reference";
  add("adjoint", std::nan(""), adjoint_time, 1, gradient_errors(adjoint, forward), "forward mode" + doubt)
      .is_default = true;
  ChartRow& row = add("forward mode", std::nan(""), forward_time, columns / sampled,
                      gradient_errors(forward, adjoint), "adjoint" + doubt);
  for (double* const part : {&row.seconds, &row.seconds_low, &row.seconds_high}) *part += shared_time;
  row.note = fmt::format("{} of {} columns timed", sample.size(), c.size());

  for (const auto& [name, f] : {std::pair<std::string, const Values*>{"differences of smooth", &smooth},
                                {"differences of exact", &exact}}) {
    for (const double step : kSteps) {
      bench.say(fmt::format("chart: {}, step {:.0e}", name, step));
      Eigen::MatrixXd estimate;
      const ChartTime time = measure_time(share, [&] { estimate = differences(*f, c, sigma, sample, step); });
      add(name, step, time, columns / sampled, gradient_errors(estimate, adjoint), "adjoint" + doubt).note =
          fmt::format("{} of {} columns timed", sample.size(), c.size());
    }
  }
  mark_rows(&family);
  return family;
}

}  // namespace aberfit
