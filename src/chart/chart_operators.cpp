#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/scene/zernike.h"
#include "chart_families.h"

namespace aberfit::internal {
namespace {

constexpr double kBytesPerDenseEntry = 24, kMostDenseBytes = 1e9;
constexpr Eigen::Index kTwinPoints = 48;
constexpr double kRounding = 1e-9;  // what a statistic would still not notice
constexpr int kWhatIfModes = 400;   // plane waves for studies that have none

// Heights and slopes of a term set at chosen points of a pupil, one term at a time: the plain twin.
SurfaceField plain_field(const TermSet& terms, const Eigen::VectorXd& c, const PupilSample& pupil,
                         const std::vector<Eigen::Index>& points) {
  SurfaceField field;
  field.resize(Eigen::Index(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = pupil.x[points[i]], y = pupil.y[points[i]];
    long double h = 0, p = 0, q = 0;
    for (std::size_t j = 0; j < terms.zernike.size(); ++j) {
      const ZernikeValue z = zernike(terms.zernike[j], x / terms.radius, y / terms.radius);
      const double a = c[Eigen::Index(j)];
      h += a * z.value;
      p += a * z.dx / terms.radius;
      q += a * z.dy / terms.radius;
    }
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const FourierMode mode = terms.fourier[k];
      const long double turn = 2 * std::numbers::pi_v<long double>;
      const long double phase = turn * ((long double)(mode.fx) * x + (long double)(mode.fy) * y);
      const Eigen::Index at = terms.fourier_begin() + 2 * Eigen::Index(k);
      const long double cosine = std::cos(phase), sine = std::sin(phase);
      h += c[at] * cosine + c[at + 1] * sine;
      p += turn * mode.fx * (c[at + 1] * cosine - c[at] * sine);
      q += turn * mode.fy * (c[at + 1] * cosine - c[at] * sine);
    }
    const auto to = Eigen::Index(i);
    field.height[to] = double(h);
    field.slope_x[to] = double(p);
    field.slope_y[to] = double(q);
  }
  return field;
}

// Largest difference over largest value, the worst of height and the two slopes.
double field_error(const SurfaceField& a, const SurfaceField& b) {
  double worst = 0;
  for (const auto member : {&SurfaceField::height, &SurfaceField::slope_x, &SurfaceField::slope_y})
    worst = std::max(worst, (a.*member - b.*member).abs().maxCoeff() / (b.*member).abs().maxCoeff());
  return worst;
}

SurfaceField at_points(const SurfaceField& field, const std::vector<Eigen::Index>& points) {
  return {field.height(points), field.slope_x(points), field.slope_y(points)};
}

SurfaceField random_weights(Eigen::Index size) {
  const RandomStream stream(1, "chart-adjoint-weights");
  SurfaceField weights;
  weights.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    weights.height[i] = 1e3 * a;  // [1/m] beside slopes: of the same weight for waves of 6 mm
    weights.slope_x[i] = b;
    weights.slope_y[i] = stream.normal(std::uint64_t(2 * i + 1));
  }
  return weights;
}

struct Method {
  std::string name;
  OperatorOptions options;
  bool is_dense = false, is_reference = false;
};

// Part of L (its Zernikes or its plane waves) on one pupil: forward and adjoint rows of every method that the
// pupil allows.
class OperatorRows {
 public:
  OperatorRows(const ChartBench& bench, TermSet terms, Eigen::VectorXd c, double share)
      : bench_(bench), terms_(std::move(terms)), c_(std::move(c)), share_(share) {}

  void add(const PupilSample& pupil, const std::string& layout, const std::vector<Method>& methods,
           bool is_own, ChartFamily* forward, ChartFamily* adjoint) {
    std::vector<Eigen::Index> sample;
    for (Eigen::Index i = 0; i < std::min(kTwinPoints, pupil.size()); ++i)
      sample.push_back(i * (pupil.size() - 1) /
                       std::max<Eigen::Index>(1, std::min(kTwinPoints, pupil.size()) - 1));
    const SurfaceField twin = plain_field(terms_, c_, pupil, sample), weights = random_weights(pupil.size());
    const SurfaceOperator automatic(terms_, pupil, OperatorOptions{bench_.threads, {}, {}});
    SurfaceField reference;
    Eigen::VectorXd adjoint_reference;
    double reference_error = 0;
    for (const Method& method : methods) {
      if (method.is_dense &&
          kBytesPerDenseEntry * double(pupil.size()) * double(terms_.size()) > kMostDenseBytes)
        continue;
      bench_.say(fmt::format("chart: operator {} on {} points", method.name, layout));
      std::optional<SurfaceOperator> surface;
      try {
        surface.emplace(terms_, pupil, method.options);
      } catch (const std::invalid_argument&) {
        continue;  // the pupil lacks the structure
      }
      // A method that this build does not have is answered by another one.
      if (surface->choice().zernike != method.options.zernike ||
          surface->choice().fourier != method.options.fourier)
        continue;
      ChartRow row;
      row.method = fmt::format("{} on {} points", method.name, layout);
      row.parameter = "points";
      row.unit = "1";
      row.value = double(pupil.size());
      row.rays = pupil.size();
      row.terms = terms_.size();
      row.is_default = is_own && automatic.choice().zernike == method.options.zernike &&
                       automatic.choice().fourier == method.options.fourier;
      SurfaceField field;
      set_time(measure_time(share_, [&] { surface->apply(c_, &field); }), &row);
      Eigen::VectorXd gradient;
      const ChartTime adjoint_time =
          measure_time(share_, [&] { gradient = surface->apply_transpose(weights); });
      if (method.is_reference) {
        reference = field;
        adjoint_reference = gradient;
        reference_error = field_error(at_points(field, sample), twin);
        row.reference = fmt::format("term by term at {} points", sample.size());
        row.error = reference_error;
        row.error_of_reference = 1e-14;  // one mode of the twin at the rim, n = 40 (scene/zernike.h)
      } else {
        row.reference = methods.front().name;
        row.error = field_error(field, reference);
        row.error_of_reference = reference_error;
      }
      row.error_rms = row.error;
      row.family = forward->name;
      forward->rows.push_back(row);
      // <L c, g> = <c, L^T g> judges the adjoint that the others are compared with.
      const double product =
          (field.height * weights.height + field.slope_x * weights.slope_x + field.slope_y * weights.slope_y)
              .sum();
      const double size = std::sqrt((field.height * weights.height).square().sum() +
                                    (field.slope_x * weights.slope_x).square().sum() +
                                    (field.slope_y * weights.slope_y).square().sum());
      row.error = method.is_reference ? std::abs(product - c_.dot(gradient)) / size
                                      : (gradient - adjoint_reference).cwiseAbs().maxCoeff() /
                                            adjoint_reference.cwiseAbs().maxCoeff();
      row.reference =
          method.is_reference ? "the forward operator: <L c, g> = <c, L^T g>" : methods.front().name;
      row.error_rms = row.error;
      row.family = adjoint->name;
      set_time(adjoint_time, &row);
      adjoint->rows.push_back(row);
    }
  }

 private:
  const ChartBench& bench_;
  TermSet terms_;
  Eigen::VectorXd c_;
  double share_;
};

ChartFamily family_of(const std::string& name, const std::string& title, const std::string& timed) {
  ChartFamily family;
  family.name = name;
  family.title = title;
  family.error_of = "largest difference over largest value";
  family.timed = timed;
  family.tolerance = kRounding;
  family.tolerance_of = "rounding that no statistic notices";
  return family;
}

// Pupils of the study's layout and of the one whose structure the fast method needs.
std::vector<std::pair<std::string, PupilSample>> pupils_of(const ChartBench& bench, PupilLayout structured,
                                                           std::int64_t rays) {
  static constexpr std::pair<PupilLayout, const char*> kNames[] = {{PupilLayout::kPolar, "polar"},
                                                                   {PupilLayout::kRandom, "random"},
                                                                   {PupilLayout::kSobol, "sobol"},
                                                                   {PupilLayout::kGrid, "grid"}};
  std::vector<std::pair<std::string, PupilSample>> pupils;
  const PupilOptions own = bench.task.trace.pupil;
  for (const auto& [layout, name] : kNames) {
    if (layout != own.layout && layout != structured) continue;
    try {
      pupils.emplace_back(name, make_pupil(bench.task.aperture, {layout, rays, own.seed}));
    } catch (const ComputationError&) {
      continue;  // the layout does not exist for the shape
    }
  }
  return pupils;
}

}  // namespace

std::vector<ChartFamily> chart_operators(const ChartBench& bench, double seconds) {
  std::vector<ChartFamily> families = {
      family_of("zernike-forward", "Zernike part of L", "heights and slopes from coefficients"),
      family_of("zernike-adjoint", "Zernike part of L, adjoint", "coefficients from one weight per point"),
      family_of("fourier-forward", "Fourier part of L", "heights and slopes from coefficients"),
      family_of("fourier-adjoint", "Fourier part of L, adjoint", "coefficients from one weight per point")};
  const std::int64_t wanted = bench.task.trace.pupil.rays;
  // So many points that some twenty timings of about ten runs each fit; 1e9 term-points a second is slow.
  const auto affordable = [&](Eigen::Index terms) {
    return std::int64_t(std::max(4096.0, 1e9 * seconds / (60.0 * double(std::max<Eigen::Index>(terms, 1)))));
  };
  const double share = seconds / 24;

  TermSet zernike = bench.terms;
  zernike.fourier.clear();
  zernike.spherical.clear();
  if (zernike.size() > 0) {
    OperatorRows rows(bench, zernike, bench.coefficients.head(zernike.size()), share);
    const std::vector<Method> methods = {{"fused", {bench.threads, ZernikeMethod::kFused, {}}, false, true},
                                         {"polar", {bench.threads, ZernikeMethod::kPolar, {}}},
                                         {"dense", {bench.threads, ZernikeMethod::kDense, {}}, true}};
    for (const auto& [name, pupil] :
         pupils_of(bench, PupilLayout::kPolar, std::min(wanted, affordable(zernike.size()))))
      rows.add(pupil, name, methods, pupil.layout == bench.task.trace.pupil.layout, &families[0],
               &families[1]);
  } else {
    families[0].skipped = families[1].skipped = "The study has no Zernike terms.";
  }

  TermSet fourier = bench.terms;
  fourier.zernike.clear();
  fourier.spherical.clear();
  Eigen::VectorXd amplitudes;
  if (!fourier.fourier.empty()) {
    amplitudes = bench.coefficients.segment(bench.terms.fourier_begin(), fourier.size());
  } else if (bench.ground.prior_psd) {
    const RadialPsd& psd = *bench.ground.prior_psd;
    fourier.fourier = fourier_modes(psd, kWhatIfModes, FourierSampling::kLog, bench.task.fit.seed);
    const CoefficientPrior prior = make_prior(fourier, psd, CovarianceKind::kFull);
    amplitudes = prior.colour(draw_white(prior.size(), bench.task.fit.seed));
  }
  if (amplitudes.size() > 0) {
    OperatorRows rows(bench, fourier, amplitudes, share);
    const std::vector<Method> methods = {
        {"phase sums", {bench.threads, {}, FourierMethod::kPhaseSums}, false, true},
        {"grid", {bench.threads, {}, FourierMethod::kGrid}},
        {"dense", {bench.threads, {}, FourierMethod::kDense}, true}};
    const bool own = !bench.terms.fourier.empty();
    for (const auto& [name, pupil] :
         pupils_of(bench, PupilLayout::kGrid, std::min(wanted, affordable(4 * fourier.size()))))
      rows.add(pupil, name, methods, own && pupil.layout == bench.task.trace.pupil.layout, &families[2],
               &families[3]);
  } else {
    families[2].skipped = families[3].skipped = "There is no roughness whose band would place plane waves.";
  }
  for (ChartFamily& family : families) mark_rows(&family);
  return families;
}

}  // namespace aberfit::internal
