#include "other_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "aberfit/core/errors.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/parallel.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/trace/nominal_surface.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {
namespace {

struct LightWanted {
  double wavelength_ratio, stop;
};

// The same aperture behind a concentric stop; the hole of an annulus stays.
Aperture stopped(const Aperture& aperture, double stop) {
  return std::visit(
      Overloaded{[&](CircleAperture a) -> Aperture { return a.diameter *= stop, a; },
                 [&](AnnulusAperture a) -> Aperture { return a.diameter *= stop, a; },
                 [&](RectangleAperture a) -> Aperture { return a.width *= stop, a.height *= stop, a; },
                 [&](PolygonAperture a) -> Aperture {
                   for (auto& corner : a.vertices) corner[0] *= stop, corner[1] *= stop;
                   return a;
                 },
                 [&](SegmentedAperture a) -> Aperture {
                   for (Outline& outline : a.outlines)
                     for (auto& corner : outline) corner[0] *= stop, corner[1] *= stop;
                   return a;
                 }},
      aperture);
}

// One wavelength and stop: the targets, and a grid fine enough for them.
struct Scene {
  Task task;
  std::shared_ptr<const BandSplit> split;  // null: the terms represent all of the roughness
  std::vector<Target> targets;
  double pitch = 0;
};

Scene scene_of(const Task& task, const Groundwork& ground, const TermSet& terms, const LightWanted& wanted,
               int threads) {
  Scene scene{task, nullptr, {}, 0};
  scene.task.wavelength *= wanted.wavelength_ratio;
  if (wanted.stop < 1 && has_segment_errors(task.aperture))
    throw ComputationError("a smaller stop would have other segments");
  if (wanted.stop < 1) scene.task.aperture = stopped(task.aperture, wanted.stop);
  const Task& at = scene.task;
  if (const auto* annulus = std::get_if<AnnulusAperture>(&at.aperture);
      annulus && !(annulus->inner_diameter < 0.9 * annulus->diameter))
    throw ComputationError("the central hole is larger than such a stop");
  const RadialPsd psd = ground.psd->scaled(ground.prior_height_factor);
  const auto whole =
      std::make_shared<const GeneralisedHarveyShack>(psd, at.mirror, at.aperture, at.wavelength);
  if (ground.split)
    scene.split = std::make_shared<const BandSplit>(psd, ground.split->cut(), at.mirror, at.aperture,
                                                    at.wavelength, whole);
  for (const double share : {0.35, 0.5, 0.65, 0.8, 0.9})
    scene.targets.push_back({EncircledEnergyRadius{share, 0}});
  Eigen::VectorXd slopes;
  const Eigen::VectorXd radii = whole->predict(statistics_of(scene.targets), threads, &slopes);
  for (std::size_t k = 0; k < scene.targets.size(); ++k) {
    scene.targets[k].value = radii[Eigen::Index(k)];
    scene.targets[k].curve_slope = slopes[Eigen::Index(k)];
  }
  scene.pitch = wave_pitch(at, terms, scene.targets, scene.split.get(), 2);
  if (const double cells = 2 * aperture_radius(at.aperture) / scene.pitch; !(cells <= law::kMostCells / 2))
    throw ComputationError(fmt::format("it would need a grid of {:.0f} points across, more than {}", cells,
                                       law::kMostCells / 2));
  return scene;
}

// Lagrange weights of six equidistant values between the third and fourth; error 0.3 % at six per wave.
std::array<double, 6> lagrange(double t) {
  std::array<double, 6> weight{};
  for (int i = 0; i < 6; ++i) {
    weight[std::size_t(i)] = 1;
    for (int j = 0; j < 6; ++j)
      if (j != i) weight[std::size_t(i)] *= (t + 2 - j) / double(i - j);
  }
  return weight;
}

Eigen::ArrayXd interpolated(const HeightMap& map, const PupilSample& at) {
  Eigen::ArrayXd height(at.size());
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    const double u = (at.x[k] - map.x0) / map.pitch_x, v = (at.y[k] - map.y0) / map.pitch_y;
    const Eigen::Index column = std::clamp<Eigen::Index>(Eigen::Index(std::floor(u)), 2, map.columns() - 4),
                       row = std::clamp<Eigen::Index>(Eigen::Index(std::floor(v)), 2, map.rows() - 4);
    const auto along_x = lagrange(u - double(column)), along_y = lagrange(v - double(row));
    double sum = 0;
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = 0; j < 6; ++j)
        sum += along_y[std::size_t(i)] * along_x[std::size_t(j)] * map.height(row - 2 + i, column - 2 + j);
    height[k] = sum;
  }
  return height;
}

struct Worst {
  double tolerances = 0, fraction = 0;
};

// Differences of the energy inside the mean's radii, in tolerances of the verdict.
Worst worst_in(const Scene& scene, const DiffractionProblem& problem, const Eigen::ArrayXd& height) {
  const std::vector<Target> aims = aims_of(scene.targets);
  Eigen::VectorXd values;
  evaluate_diffraction(problem, height, statistics_of(aims), 1, nullptr, &values, nullptr);
  Worst worst;
  for (std::size_t k = 0; k < aims.size(); ++k) {
    const double margin = margin_of(scene.targets[k], scene.task.equivalence) * aims[k].relative_to();
    const double off = std::abs(values[Eigen::Index(k)] - aims[k].value) / margin;
    if (!(off <= worst.tolerances))
      worst = {off, std::get<EncircledEnergyRadius>(scene.targets[k].statistic).fraction};
  }
  return worst;
}

Eigen::ArrayXd drawn_segments(const TermSet& all, const PupilSample& at, std::uint64_t seed) {
  TermSet terms;
  terms.segments = all.segments;
  const CoefficientPrior prior(terms.size(), segment_prior_blocks(terms));
  SurfaceField field;
  SurfaceOperator(terms, at, {}).apply(prior.colour(draw_white(terms.size(), seed)), &field);
  return field.height;
}

// All wavelengths at one aperture share its grid, because cells and heights do not depend on the wavelength.
void look_behind(const std::vector<Scene>& scenes, const TermSet& terms, const Eigen::VectorXd& coefficients,
                 const std::vector<HeightMap>& draws, int threads, const std::vector<OtherLight*>& found) {
  double pitch = HUGE_VAL;
  for (const Scene& scene : scenes) pitch = std::min(pitch, scene.pitch);
  const Task& task = scenes.front().task;
  const DiffractionPupil pupil = diffraction_pupil(task.aperture, task.mirror.focal_length, pitch);
  Eigen::ArrayXd departure = departure_from_parabola(task.mirror, pupil.sample);
  if (departure.size() == 0) departure = Eigen::ArrayXd::Zero(pupil.sample.size());
  const RandomStream seeds(task.fit.seed, "segment-draws");
  std::vector<std::vector<Worst>> worst(draws.size() + 1);
  parallel_for(worst.size(), threads, [&](std::size_t k) {
    Eigen::ArrayXd height;
    if (k == draws.size()) {
      SurfaceField field;
      SurfaceOperator(terms, pupil.sample, focus_operator(FocusModel::kWaves, 1)).apply(coefficients, &field);
      height = field.height;
    } else {
      height = interpolated(draws[k], pupil.sample);
      if (terms.of_a_segment() > 0) height += drawn_segments(terms, pupil.sample, seeds.bits(k));
    }
    height += departure;
    for (const Scene& scene : scenes) {
      DiffractionProblem problem{pupil, scene.task.mirror.focal_length, scene.task.wavelength};
      problem.scatter = scene.split;
      problem.aliased_limit = kMostAliasedBeforeAFiner;  // the image just fits into the field of view
      problem.nominal = &departure;
      worst[k].push_back(worst_in(scene, problem, height));
    }
  });
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    double squares = 0;
    for (std::size_t d = 0; d < draws.size(); ++d) squares += std::pow(worst[d][s].tolerances, 2);
    found[s]->worst = worst.back()[s].tolerances;
    found[s]->fraction = worst.back()[s].fraction;
    found[s]->draws = std::sqrt(squares / double(draws.size()));
  }
}

}  // namespace

std::vector<OtherLight> other_light(const Task& task, const Groundwork& ground, const TermSet& terms,
                                    const Eigen::VectorXd& coefficients, const std::vector<HeightMap>& draws,
                                    const RunContext& context) {
  std::vector<OtherLight> all;
  for (const LightWanted& wanted : {LightWanted{0.7, 1}, {1.5, 1}, {3, 1}, {1, 0.6}})
    all.push_back({.wavelength = task.wavelength * wanted.wavelength_ratio,
                   .wavelength_ratio = wanted.wavelength_ratio,
                   .stop = wanted.stop,
                   .obstacle = {}});
  for (const double stop : {1.0, 0.6}) {
    std::vector<Scene> scenes;
    std::vector<OtherLight*> found;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k].stop != stop || context.stopped()) continue;
      try {
        scenes.push_back(scene_of(task, ground, terms, {all[k].wavelength_ratio, stop}, context.threads));
        found.push_back(&all[k]);
      } catch (const ComputationError& error) {
        all[k].obstacle = error.what();
      }
    }
    if (!scenes.empty()) look_behind(scenes, terms, coefficients, draws, context.threads, found);
  }
  return all;
}

}  // namespace aberfit::internal
