#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/random.h"
#include "aberfit/scene/zernike.h"
#include "chart_families.h"

namespace aberfit::internal {
namespace {

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
  bool is(const OperatorChoice& choice) const {
    return choice.zernike == options.zernike && choice.fourier == options.fourier;
  }
};

std::optional<SurfaceOperator> try_operator(const TermSet& terms, const PupilSample& pupil,
                                            const Method& method) {
  try {
    SurfaceOperator surface(terms, pupil, method.options);
    // A method that this build does not have is answered by another one.
    if (method.is(surface.choice())) return surface;
  } catch (const std::invalid_argument&) {  // the pupil lacks the structure
  }
  return std::nullopt;
}

// Part of L: its Zernikes or its plane waves, and the rows of all methods on one pupil after the other.
struct OperatorPart {
  const ChartBench& bench;
  TermSet terms;
  Eigen::VectorXd c;
  std::vector<Method> methods;  // with the first, which any pupil allows, the others are compared
  double seconds;               // of the budget
  ChartFamily &forward, &adjoint;

  // Every method that the pupil allows. is_own: of the study.
  void add(const PupilSample& pupil, bool is_own) {
    const std::string layout = name_of(pupil.layout);
    const Eigen::Index count = std::min(kTwinPoints, pupil.size());
    std::vector<Eigen::Index> sample;
    for (Eigen::Index i = 0; i < count; ++i)
      sample.push_back(i * (pupil.size() - 1) / std::max<Eigen::Index>(1, count - 1));
    const SurfaceField twin = plain_field(terms, c, pupil, sample), weights = random_weights(pupil.size());
    const SurfaceOperator automatic(terms, pupil, OperatorOptions{bench.threads, {}, {}});
    const std::string& reference_name = methods.front().name;
    SurfaceField reference;
    Eigen::VectorXd adjoint_reference;
    double reference_error = 0;
    for (const Method& method : methods) {
      bench.say(fmt::format("chart: operator {} on {} points", method.name, layout));
      const std::optional<SurfaceOperator> surface = try_operator(terms, pupil, method);
      if (!surface) continue;
      ChartRow row =
          row_of(fmt::format("{} on {} points", method.name, layout), "points", double(pupil.size()));
      row.rays = pupil.size();
      row.terms = terms.size();
      row.is_default = is_own && method.is(automatic.choice());
      SurfaceField field;
      set_time(measure_time(seconds / 24, [&] { surface->apply(c, &field); }), &row);
      Eigen::VectorXd gradient;
      const ChartTime adjoint_time =
          measure_time(seconds / 24, [&] { gradient = surface->apply_transpose(weights); });
      const bool is_reference = &method == &methods.front();
      if (is_reference) {
        reference = field;
        adjoint_reference = gradient;
        reference_error = field_error(at_points(field, sample), twin);
        set_errors({reference_error}, fmt::format("term by term at {} points", sample.size()),
                   1e-14,  // one mode of the twin at the rim, n = 40 (scene/zernike.h)
                   &row);
      } else {
        set_errors({field_error(field, reference)}, reference_name, reference_error, &row);
      }
      forward.rows.push_back(row);
      // <L c, g> = <c, L^T g> judges the adjoint that the others are compared with.
      const double product =
          (field.height * weights.height + field.slope_x * weights.slope_x + field.slope_y * weights.slope_y)
              .sum();
      const double size = std::sqrt((field.height * weights.height).square().sum() +
                                    (field.slope_x * weights.slope_x).square().sum() +
                                    (field.slope_y * weights.slope_y).square().sum());
      const double adjoint_error = is_reference ? std::abs(product - c.dot(gradient)) / size
                                                : (gradient - adjoint_reference).cwiseAbs().maxCoeff() /
                                                      adjoint_reference.cwiseAbs().maxCoeff();
      set_errors({adjoint_error},
                 is_reference ? "the forward operator: <L c, g> = <c, L^T g>" : reference_name,
                 row.error_of_reference, &row);
      set_time(adjoint_time, &row);
      adjoint.rows.push_back(row);
    }
  }

  // On pupils of the study's layout and of the one whose structure the fast method needs. work: of a point,
  // in Zernike terms.
  void add_pupils(PupilLayout structured, Eigen::Index work, bool is_of_study) {
    const PupilOptions& own = bench.task.trace.pupil;
    const PupilLayout of_study = layout_of(bench.task.aperture, own);
    // So many points that some twenty timings of about ten runs each fit; 1e9 term-points a second is slow.
    const auto affordable =
        std::int64_t(std::max(4096.0, 1e9 * seconds / (60.0 * double(std::max<Eigen::Index>(work, 1)))));
    for (const PupilLayout layout :
         {PupilLayout::kPolar, PupilLayout::kRandom, PupilLayout::kSobol, PupilLayout::kGrid}) {
      if (layout != of_study && layout != structured) continue;
      const std::optional<PupilSample> pupil =
          try_pupil(bench.task.aperture, {layout, std::min(rays_of(own), affordable), own.seed});
      if (pupil) add(*pupil, is_of_study && layout == of_study);
    }
  }
};

}  // namespace

std::vector<ChartFamily> chart_operators(const ChartBench& bench, double seconds) {
  const auto family = [](const std::string& name, const std::string& title, const std::string& timed) {
    return family_of(name, title, "largest difference over largest value", timed,
                     {kRounding, "rounding that no statistic notices"});
  };
  std::vector<ChartFamily> families = {
      family("zernike-forward", "Zernike part of L", "heights and slopes from coefficients"),
      family("zernike-adjoint", "Zernike part of L, adjoint", "coefficients from one weight per point"),
      family("fourier-forward", "Fourier part of L", "heights and slopes from coefficients"),
      family("fourier-adjoint", "Fourier part of L, adjoint", "coefficients from one weight per point")};
  const int threads = bench.threads;
  const TermSet zernike{bench.terms.radius, bench.terms.zernike, {}, {}};
  if (zernike.size() > 0) {
    OperatorPart{
        bench,
        zernike,
        bench.coefficients.head(zernike.size()),
        {{"fused", {threads, ZernikeMethod::kFused, {}}}, {"polar", {threads, ZernikeMethod::kPolar, {}}}},
        seconds,
        families[0],
        families[1]}
        .add_pupils(PupilLayout::kPolar, zernike.size(), true);
  } else {
    families[0].skipped = families[1].skipped = "The study has no Zernike terms.";
  }

  TermSet fourier{bench.terms.radius, {}, bench.terms.fourier, {}, bench.terms.fourier_pitch};
  const bool is_of_study = !fourier.fourier.empty();
  Eigen::VectorXd amplitudes;
  if (is_of_study) {
    amplitudes = bench.coefficients.segment(bench.terms.fourier_begin(), fourier.size());
  } else if (bench.ground.prior_psd) {
    const RadialPsd& psd = *bench.ground.prior_psd;
    fourier.fourier = fourier_modes(psd, kWhatIfModes, bench.task.fit.seed);
    const CoefficientPrior prior = make_prior(fourier, psd, CovarianceKind::kFull);
    amplitudes = prior.colour(draw_white(prior.size(), bench.task.fit.seed));
  }
  if (amplitudes.size() > 0) {
    OperatorPart{bench,
                 fourier,
                 amplitudes,
                 {{"phase sums", {threads, {}, FourierMethod::kPhaseSums}},
                  {"lattice", {threads, {}, FourierMethod::kLattice}}},
                 seconds,
                 families[2],
                 families[3]}
        .add_pupils(PupilLayout::kPolar, 4 * fourier.size(), is_of_study);
  } else {
    families[2].skipped = families[3].skipped = "There is no roughness whose band would place plane waves.";
  }
  return families;
}

}  // namespace aberfit::internal
