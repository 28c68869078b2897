#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/report/result.h"

namespace aberfit {

/// The resolved study of sample_result.
inline nlohmann::ordered_json sample_study() {
  return {{"aberfit", 1},
          {"title", "Stand-in scene, 100 nm RMS in 2.5-19.96 /m"},
          {"equivalence", {{"margin", 0.01}, {"confidence", 0.95}}}};
}

/// One bin and one zone of the character are outside their limits.
inline Character sample_character() {
  Character character;
  character.draws = 32;
  character.psd = {{3, 6, 2e-17, {0.9, 1, 0.4, 2.1}}, {6, 12, 1e-17, {3.1, 1, 0.6, 1.6}}};
  character.zones = {{0.0, 0.5, {0.97, 1, 0.81, 1.18}}, {0.5, 1.0, {1.25, 1, 0.93, 1.06}}};
  character.slope_x_over_y = {1.02, 1, 0.9, 1.1};
  character.length_over_width = {1.05, 1.08, 1, 1.2};
  character.bright_share = {0.07, 0.06, 0.05, 0.08};
  character.others = {{1.5e-6, 1.5, 1, "", 1.8, 0.65, 7.2}, {1e-6, 1, 0.6, "it has no grid", 0, 0, 0}};
  return character;
}

/// A finished fit as the method returns it, with every kind of term and verdict.
inline ResultDocument sample_result() {
  ResultDocument result;
  result.title = "Stand-in scene, 100 nm RMS in 2.5-19.96 /m";
  result.judgement.confidence = 0.95;
  result.has_roughness = true;
  result.scene.numbers.rms_height = 100e-9;
  result.scene.numbers.rms_slope_per_axis = 6.32e-6;
  result.scene.numbers.correlation_length = 0.0287;
  result.scene.numbers.n_eff = 37.2;
  result.scene.numbers.g = 1.98588;
  result.scene.numbers.kappa = 0.91;
  result.scene.numbers.tis = 0.9806;
  result.scene.numbers.paper_ratio_r = 3.61;
  result.scene.spread.statistics = {{"ee50_radius_m", 0.1066, 10.66}, {"scatter_rms_rad", 0.08, 8}};
  result.scene.numbers.airy_ee90 = 8.42e-6;
  result.scene.numbers.kappa_rule_allows_rays = true;
  result.scene.numbers.reason =
      "kappa is 0.85 or more and the spot is at least five times the diffraction-limited one";
  result.scene.theory = "geometric";
  result.scene.model = result.scene.needed = "rays";
  result.judgement.light_decides = false;
  result.fitted.targets = {{EncircledEnergyRadius{0.5, 0.0}, 41.234e-6, 0.0, 4e-8},
                           {EncircledEnergyRadius{0.9, 0.0}, 75.412e-6, 1e-8, 8e-8},
                           {EncircledEnergyRadius{0.5, -1e-3}, 91.9e-6, 0.0, 9e-8},
                           {RingFwhm{0.9, {}}, 2.985e-3, 0.0, 3e-6},
                           {RingThrough{76e-6, 0.0, true}, 0.9, 0.0, 1e-3},
                           {RingThrough{50e-6, 0.0, true}, 0.6, 0.0, 1e-3},
                           {ScatterRms{}, 35.75e-6, 0.0, 4e-8},
                           {RmsHeight{}, 100e-9, 0.0, 1e-10}};
  const Eigen::Index count = Eigen::Index(result.fitted.targets.size());
  Eigen::VectorXd value(count);
  for (Eigen::Index k = 0; k < count; ++k) value[k] = result.fitted.targets[std::size_t(k)].value;
  result.fitted.start = 1.1 * value;
  result.fitted.values = 1.0005 * value;
  result.fitted.validated = 1.002 * value;
  result.fitted.validated[3] = std::nan("");
  result.fitted.terms.radius = 0.2;
  result.fitted.terms.zernike = {{2, -2}, {2, 0}, {2, 2}, {3, 1}};
  result.fitted.terms.fourier = {{2.5, 1.0 / 3.0}, {-7.25, 0.1}};
  result.fitted.terms.spherical = {4, 8};
  result.fitted.fit.status = FitStatus::kConverged;
  result.fitted.fit.message = "every statistic is within half its tolerance";
  result.fitted.fit.iterations = 12;
  result.fitted.fit.evaluations = 14;
  result.fitted.fit.seconds = 3.25;
  result.fitted.fit.initial_cost = 123.5;
  result.fitted.fit.final_cost = 0.25;
  result.fitted.fit.rank = 3;
  result.fitted.fit.null_directions = 2;
  result.fitted.fit.coefficients = Eigen::VectorXd::LinSpaced(result.fitted.terms.size(), -5e-8, 7e-8) / 3.0;
  result.fitted.fit.coefficient_std = Eigen::VectorXd::Constant(result.fitted.terms.size(), 1e-9 / 7.0);
  result.fitted.fit.statistic_std = 1e-3 * value;
  result.fitted.posterior_std = 1e-3 * value;
  result.fitted.fit.singular_values = Eigen::Vector3d(9.0, 4.0, 1.5);
  result.fitted.rays = 16384;
  result.fitted.radius = 0.2;
  result.fitted.surface.rms_height = 99.9e-9;
  result.fitted.surface.rms_slope_per_axis = 6.3e-6;
  result.fitted.surface.g = 1.984;
  result.fitted.surface.kappa = 0.9;
  result.fitted.surface.captured_fraction = 0.9917;
  for (const Eigen::Index k : {0, 1, 2, 3, 6, 7})
    result.judgement.metrics.push_back(tost(statistic_name(result.fitted.targets[std::size_t(k)].statistic),
                                            false, value[k], 0.0, result.fitted.validated[k], 1e-3 * value[k],
                                            0.01, 0.95));
  result.judgement.metrics.push_back(
      tost("ee35_radius_m@2.75mm", true, 50e-6, 0.0, 50.2e-6, 5e-8, 0.01, 0.95));
  result.judgement.metrics.push_back(
      tost("ee85_radius_m@-1.5mm", true, 80e-6, 0.0, 80.7e-6, 2e-7, 0.01, 0.95));
  result.judgement.verdict = overall(result.judgement.metrics);
  result.warnings = {
      {"realisation-spread",
       "Draws of this specification differ among themselves by about 10.7 % in ee90, because only 37 modes "
       "carry the slope; a measured mirror will differ from the target by as much."}};
  result.provenance = make_provenance(1, 2);
  return result;
}

}  // namespace aberfit
