#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "aberfit/core/random.h"
#include "chart_families.h"

namespace aberfit::internal {
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

// A number with its derivative along one direction: what the templated physics needs to be differentiated
// forwards, and no more.
struct Dual {
  double value = 0, derivative = 0;
};

Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.derivative + b.derivative}; }
Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.derivative - b.derivative}; }
Dual operator*(const Dual& a, const Dual& b) {
  return {a.value * b.value, a.derivative * b.value + a.value * b.derivative};
}
Dual operator-(double a, const Dual& b) { return {a - b.value, -b.derivative}; }
Dual operator/(double a, const Dual& b) {
  const double quotient = a / b.value;
  return {quotient, -quotient / b.value * b.derivative};
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

// What every way to the Jacobian is measured on.
struct JacobianBench {
  const ChartBench& bench;
  Eigen::VectorXd sigma;             // of the prior
  std::vector<Eigen::Index> sample;  // columns
  double share = 0;                  // of the budget, for one way or step [s]
  ChartTrace at;

  // How many times the work of the sample all columns are.
  double columns_per_sampled() const { return double(sigma.size()) / double(sample.size()); }
};

// Rays with which one pass over the sampled columns takes half of what one step may.
std::int64_t affordable_rays(const ChartBench& bench, double sampled, double share, double seconds) {
  constexpr std::int64_t kProbe = 4096;
  ChartTrace probe(bench, pupil_of_at_most(bench.task, kProbe));
  Eigen::VectorXd values;
  const double once = measure_time(0.05 * seconds, [&] {
                        probe.smooth(bench.coefficients, bench.statistics, bench.smoothing, &values, nullptr);
                      }).median;
  const double affordable = double(kProbe) * 0.5 * share / (2 * sampled * std::max(once, 1e-6));
  return std::int64_t(std::max(double(kProbe), affordable));
}

JacobianBench make_jacobian_bench(const ChartBench& bench, double seconds) {
  Eigen::VectorXd sigma = prior_sigmas(bench.prior);
  std::vector<Eigen::Index> sample = sample_of(sigma, bench.task.fit.seed);
  const double share = seconds / (std::size(kSteps) * 2 + 8);
  const std::int64_t rays = affordable_rays(bench, double(sample.size()), share, seconds);
  return {bench, std::move(sigma), std::move(sample), share,
          ChartTrace(bench, pupil_of_at_most(bench.task, rays))};
}

// The sampled columns times sigma, as one way gives them, and its time for values and full Jacobian.
struct Way {
  Eigen::MatrixXd columns;
  ChartTime time;
};

ChartTime scaled(const ChartTime& time, double factor) {
  return {factor * time.median, factor * time.low, factor * time.high, time.repeats};
}

// Nothing where a statistic has no derivative.
std::optional<Way> by_adjoints(JacobianBench* on) {
  const ChartBench& bench = on->bench;
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  bool exists = false;
  Way way;
  way.time = measure_time(on->share, [&] {
    exists = on->at.smooth(bench.coefficients, bench.statistics, bench.smoothing, &values, &jacobian);
  });
  if (!exists) return std::nullopt;
  way.columns.resize(jacobian.rows(), Eigen::Index(on->sample.size()));
  for (std::size_t k = 0; k < on->sample.size(); ++k)
    way.columns.col(Eigen::Index(k)) = jacobian.col(on->sample[k]) * on->sigma[on->sample[k]];
  return way;
}

// Uses the surface and the gradients over the rays that by_adjoints has left.
Way by_forward_mode(const JacobianBench& on) {
  const ChartBench& bench = on.bench;
  const SurfaceField& field = on.at.field();
  Way way;
  way.columns.resize(Eigen::Index(bench.statistics.size()), Eigen::Index(on.sample.size()));
  const ChartTime columns_time = measure_time(on.share, [&] {
    for (std::size_t k = 0; k < on.sample.size(); ++k) {
      Eigen::VectorXd unit;
      const TermSet one = one_term(bench.terms, on.sample[k], &unit);
      SurfaceField column;
      SurfaceOperator(one, on.at.pupil(), OperatorOptions{bench.threads, {}, {}})
          .apply(unit * on.sigma[on.sample[k]], &column);
      const RayTangents tangents = ray_tangents(bench.task.mirror, on.at.pupil(), field, column);
      for (Eigen::Index s = 0; s < way.columns.rows(); ++s)
        way.columns(s, Eigen::Index(k)) = along(on.at.gradients()[std::size_t(s)], tangents, column);
    }
  });
  // What all columns share: values and gradients over the rays.
  const double shared_time =
      measure_time(on.share, [&] {
        Eigen::VectorXd values;
        std::vector<StatisticGradient> gradients;
        const FocusInput input{on.at.rays(), on.at.nominal(), field.height, bench.task.trace.centre};
        evaluate_smooth(input, bench.statistics, bench.smoothing, bench.threads, &values, &gradients);
      }).median;
  way.time = scaled(columns_time, on.columns_per_sampled());
  for (double* const part : {&way.time.median, &way.time.low, &way.time.high}) *part += shared_time;
  return way;
}

Way by_differences(const Values& f, const JacobianBench& on, double step) {
  Way way;
  way.time = measure_time(
      on.share, [&] { way.columns = differences(f, on.bench.coefficients, on.sigma, on.sample, step); });
  way.time = scaled(way.time, on.columns_per_sampled());
  return way;
}

}  // namespace

ChartFamily chart_derivatives(const ChartBench& bench, double seconds) {
  ChartFamily family =
      family_of("derivatives", "Ways to the Jacobian", "largest relative error of a statistic's gradient",
                "values and full Jacobian (columns of a sample scaled to all terms)",
                {kGradientTolerance, "what the linear solver leaves"});
  JacobianBench on = make_jacobian_bench(bench, seconds);
  bench.say("chart: Jacobian by adjoints");
  const std::optional<Way> adjoint = by_adjoints(&on);
  if (!adjoint) {
    family.skipped = "A statistic of the draw has no derivative: the kernel is too narrow for so few rays.";
    return family;
  }
  bench.say("chart: Jacobian by forward mode");
  const Way forward = by_forward_mode(on);

  const Values smooth = [&](const Eigen::VectorXd& at_c) {
    Eigen::VectorXd result;
    if (!on.at.smooth(at_c, bench.statistics, bench.smoothing, &result, nullptr))
      result.setConstant(std::nan(""));
    return result;
  };
  const Values exact = [&](const Eigen::VectorXd& at_c) { return on.at.exact(at_c, bench.statistics); };
  bench.say("chart: Jacobian by Ridders' extrapolation");
  const StatisticErrors certainty =
      gradient_errors(adjoint->columns, ridders(smooth, bench.coefficients, on.sigma, on.sample));

  const std::string timed =
      fmt::format("{} of {} columns timed", on.sample.size(), bench.coefficients.size());
  // The row of a way: its errors against another one and its time.
  const auto add = [&](ChartRow row, const Way& way, const Way& other, const std::string& other_name) {
    on.at.set_sizes(&row);
    set_errors(gradient_errors(way.columns, other.columns),
               other_name + "; both differ from Ridders' extrapolation by error_of_reference",
               certainty.worst, &row);
    set_time(way.time, &row);
    family.rows.push_back(std::move(row));
  };
  add(row_of("adjoint", "", std::nan("")), *adjoint, forward, "forward mode");
  family.rows.back().is_default = true;
  add(row_of("forward mode", "", std::nan("")), forward, *adjoint, "adjoint");
  family.rows.back().note = timed;
  for (const auto& [name, f] : {std::pair<std::string, const Values*>{"differences of smooth", &smooth},
                                {"differences of exact", &exact}}) {
    for (const double step : kSteps) {
      bench.say(fmt::format("chart: {}, step {:.0e}", name, step));
      add(row_of(name, "step", step, "prior sigma"), by_differences(*f, on, step), *adjoint, "adjoint");
      family.rows.back().note = timed;
    }
  }
  return family;
}

}  // namespace aberfit::internal
