// Wave optics: the mean spot of generalised Harvey-Shack, and the PSF of one surface with its gradients.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/diffraction_psf.h"
#include "benchmark_case.h"
#include "benchmark_scene.h"

namespace aberfit::benchmarks {
namespace {

constexpr double kWavelength = 632.8e-9;
constexpr int kCells = 256;  // across the aperture

struct Rough {
  const char* name;
  RadialPsd psd;
  double ee90;  // [m]
};

// One surface of g near 1 for each autocorrelation. The radii are by the double integral over all pairs of
// points of the aperture (tests/theory/ghs_pairs_test.cpp, with 420 radii and 1,000 angles). It uses the
// pupil coordinate of every point, as the theory does by default. The paraxial form, whose radii are golden
// tables, is 8e-4 off.
std::vector<Rough> golden_surfaces() {
  return {{"Gaussian, l = 10 mm", RadialPsd(GaussianPsd{5e-8, 0.01}), 9.77936794e-05},
          {"k-correlation, l = 10 mm", RadialPsd(KCorrelationPsd{5e-8, 2 * std::numbers::pi * 0.01, 5.0}),
           6.18255184e-05}};
}

GeneralisedHarveyShack mean_spot(const RadialPsd& psd) {
  return {psd, parabola(), CircleAperture{2 * kRadius, 0}, kWavelength};
}

void add_mean_spots() {
  for (const Rough& rough : golden_surfaces()) {
    add_case(fmt::format("Mean spot/set-up, {}", rough.name), [=]() -> Timed {
      return [=](benchmark::State& state) {
        time_alone(state, [&] { benchmark::DoNotOptimize(mean_spot(rough.psd)); });
        const double ee90 = mean_spot(rough.psd).encircled_energy_radius(0.9, 0);
        report_error(state, std::abs(ee90 / rough.ee90 - 1), 1e-6);
        report_rate(state, "scenes", 1);
      };
    });
    add_case(fmt::format("Mean spot/EE 90 % in focus, {}", rough.name), [=]() -> Timed {
      const auto spot = std::make_shared<const GeneralisedHarveyShack>(mean_spot(rough.psd));
      return [=](benchmark::State& state) {
        double ee90 = 0;
        time_alone(state, [&] { ee90 = spot->encircled_energy_radius(0.9, 0); });
        report_error(state, std::abs(ee90 / rough.ee90 - 1), 1e-6);
        report_rate(state, "radii", 1);
      };
    });
  }
}

// The paper's band with a quarter of its roughness (g = 0.5).
struct Waves {
  bool shares;  // within radii, else radii of shares and all else
  Mirror mirror = parabola();
  DiffractionPupil pupil = diffraction_pupil(CircleAperture{2 * kRadius, 0}, kParaxial, 2 * kRadius / kCells);
  Eigen::ArrayXd height = heights(1), along = heights(2);
  std::vector<Statistic> statistics;
  DiffractionWorkspace workspace;
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> gradients;

  explicit Waves(bool of_shares = false) : shares(of_shares) {
    for (const Statistic& statistic : default_statistics(30e-6))
      if (!shares && !kind_of(statistic).is_moment()) statistics.push_back(statistic);
    for (int k = 0; shares && k < 65; ++k)
      statistics.push_back(RingThrough{(1 + k % 7) * 6e-6, 4e-5 * (k / 7 - 4)});
  }
  Eigen::ArrayXd heights(std::uint64_t seed) const {
    const SurfaceOperator surface(zernike_terms(20), pupil.sample, {1, {}, {}, true});
    SurfaceField field;
    const CoefficientPrior prior = make_prior(surface.terms(), roughness_for(20), CovarianceKind::kFull);
    surface.apply(0.25 * prior.colour(draw_white(prior.size(), seed)), &field);
    return field.height;
  }
  DiffractionProblem problem() const { return {pupil, mirror.focal_length, kWavelength}; }
  // Every evaluation has new heights, because the planes of the last ones are kept.
  bool evaluate(bool with_gradients) {
    height[0] += 1e-18;
    return evaluate_diffraction(problem(), height, statistics, 1, &workspace, &values, nullptr) &&
           (!with_gradients ||
            evaluate_diffraction(problem(), height, statistics, 1, &workspace, &values, &gradients));
  }
  double gradient_error() {
    if (!evaluate(true)) return std::nan("");
    const auto moved = [&](double t) {
      Eigen::VectorXd result;
      evaluate_diffraction(problem(), height + t * along, statistics, 1, nullptr, &result, nullptr);
      return result;
    };
    Eigen::VectorXd analytic(values.size());
    for (std::size_t k = 0; k < gradients.size(); ++k)
      analytic[Eigen::Index(k)] = (gradients[k] * along).sum();
    return derivative_error(moved, values, analytic);
  }
};

}  // namespace

void register_cases(bool /*smoke*/) {
  add_mean_spots();
  add_case(fmt::format("Diffraction/EE 90 % of a perfect mirror, {} cells across", kCells), []() -> Timed {
    const auto work = std::make_shared<Waves>();
    return [=](benchmark::State& state) {
      const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(work->height.size());
      Eigen::VectorXd ee90;
      time_alone(state, [&] {
        evaluate_diffraction(work->problem(), flat, {EncircledEnergyRadius{0.9, 0}}, 1, nullptr, &ee90,
                             nullptr);
      });
      // Airy pattern: EE = 1 - J0^2 - J1^2.
      const double z = std::numbers::pi * ee90[0] * 2 * kRadius / (kWavelength * work->mirror.focal_length);
      const double share = 1 - std::pow(std::cyl_bessel_j(0, z), 2) - std::pow(std::cyl_bessel_j(1, z), 2);
      report_error(state, std::abs(share - 0.9), 1e-7);
      report_rate(state, "radii", 1);
    };
  });
  for (const bool gradients : {false, true})
    add_case(fmt::format("Diffraction/{} of 65 shares within radii, {} cells across",
                         gradients ? "values and gradients" : "values", kCells),
             [=]() -> Timed {
               const auto work = std::make_shared<Waves>(true);
               return [=](benchmark::State& state) {
                 time_alone(state, [&] { work->evaluate(gradients); });
                 report_error(state, work->gradient_error(), 1e-6);
                 report_rate(state, "cells", double(work->height.size()));
               };
             });
  const auto make = [] { return std::make_shared<Waves>(); };
  const std::string setting = fmt::format("64 statistics, {} cells across", kCells);
  add_case("Diffraction/values of " + setting, [=]() -> Timed {
    const auto work = make();
    return [=](benchmark::State& state) {
      time_alone(state, [&] { work->evaluate(false); });
      report_error(state, work->gradient_error(), 1e-6);
      report_rate(state, "cells", double(work->height.size()));
    };
  });
  add_case("Diffraction/values and gradients of " + setting, [=]() -> Timed {
    const auto work = make();
    return [=](benchmark::State& state) {
      time_against(
          state, [&] { work->evaluate(true); }, "values alone", [&] { work->evaluate(false); });
      report_error(state, work->gradient_error(), 1e-6);
      report_rate(state, "cells", double(work->height.size()));
    };
  });
}

}  // namespace aberfit::benchmarks
