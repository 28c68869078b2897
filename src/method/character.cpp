#include "aberfit/method/character.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/tost.h"
#include "other_light.h"
#include "surface_look.h"

namespace aberfit {
using namespace internal;

namespace {

// Highest frequency of the roughness in the terms: the cut, or a tenth below their own last frequency.
double last_frequency(const Groundwork& ground, const TermSet& terms) {
  double last = 0;
  for (const FourierMode& mode : terms.fourier) last = std::max(last, std::hypot(mode.fx, mode.fy));
  if (!terms.zernike.empty())
    last = std::max(last, zernike_cutoff(terms.zernike.back().n, terms.radius) / law::kOrderBeyondCut);
  return ground.split ? ground.prior_psd->f_max() : std::min(last, ground.prior_psd->f_max());
}

// Edges from `low` to `high` [cycles/m]; empty where there is nothing between them.
Eigen::ArrayXd bin_edges(double low, double high) {
  if (!(high > low)) return {};
  const auto bins = std::max(Eigen::Index(1), Eigen::Index(law::kBinsPerOctave * std::log2(high / low)));
  return Eigen::ArrayXd::LinSpaced(bins + 1, std::log(low), std::log(high)).exp();
}

// Interval of one more realisation, from the cube roots. of_several: number of simultaneous properties.
BesideDraws beside(double value, const std::vector<double>& draws, Eigen::Index of_several) {
  BesideDraws result;
  result.value = value;
  const auto count = double(draws.size());
  double sum = 0, roots = 0, squares = 0;
  for (const double draw : draws) sum += draw, roots += std::cbrt(draw);
  for (const double draw : draws) squares += std::pow(std::cbrt(draw) - roots / count, 2);
  const double left_out = (1 - law::kCharacterConfidence) / double(of_several);
  const double reach =
      student_quantile(1 - 0.5 * left_out, count - 1) * std::sqrt(squares / (count - 1) * (1 + 1 / count));
  result.mean = sum / count;
  result.low = std::pow(std::max(0.0, roots / count - reach), 3);
  result.high = std::pow(roots / count + reach, 3);
  return result;
}

using Property = std::function<double(const LookedAt&)>;

BesideDraws beside(const LookedAt& surface, const std::vector<LookedAt>& draws, Eigen::Index of_several,
                   const Property& property) {
  std::vector<double> values;
  for (const LookedAt& draw : draws) values.push_back(property(draw));
  return beside(property(surface), values, of_several);
}

// The same for the anisotropy. No surface is too round, so the interval has one end. The logarithm is a
// length in the plane of the two anisotropies; its square is a gamma variate.
BesideDraws beside_in_roundness(const LookedAt& surface, const std::vector<LookedAt>& draws) {
  BesideDraws squares = beside(surface, draws, 1, [](const LookedAt& looked) {
    return std::pow(std::log(looked.length_over_width), 2);
  });
  BesideDraws result{surface.length_over_width, 0, 1, std::exp(std::sqrt(squares.high))};
  for (const LookedAt& draw : draws) result.mean += draw.length_over_width / double(draws.size());
  return result;
}

double mean_over(const RadialPsd& psd, double low, double high) {
  return psd_moments(psd.band(low, high)).height_variance / (std::acos(-1) * (high * high - low * low));
}

// Pitch [m] of a grid that holds the image of the specification; 0, with a reason, where there is none.
double pitch_of_image(const Task& task, const Groundwork& ground, const TermSet& terms,
                      std::string* obstacle) {
  if (!ground.specified_spot) {
    *obstacle = "the scene has no mean PSF";
    return 0;
  }
  try {
    const double ee90 = ground.specified_spot->at_plane(0).encircled_energy_radius(0.9);
    const double pitch =
        wave_pitch(task, terms, {Target{EncircledEnergyRadius{0.9, 0}, ee90}}, ground.split.get(), 2);
    const double cells = 2 * ground.radius / pitch;
    if (cells <= law::kMostCells / 2) return pitch;
    *obstacle =
        fmt::format("it would need a grid of {:.0f} points across, more than {}", cells, law::kMostCells / 2);
  } catch (const ComputationError& error) {
    *obstacle = error.what();
  }
  return 0;
}

void compare(const LookedAt& surface, const std::vector<LookedAt>& draws, const RadialPsd& psd,
             const Eigen::ArrayXd& edges, Character* character) {
  for (Eigen::Index b = 0; b + 1 < edges.size(); ++b) {
    CharacterBin bin{edges[b], edges[b + 1], mean_over(psd, edges[b], edges[b + 1]), {}};
    bin.ratio = beside(surface, draws, edges.size() - 1, [b](const LookedAt& l) { return l.psd[b]; });
    const double mean = bin.ratio.mean;
    bin.ratio = {bin.ratio.value / mean, 1, bin.ratio.low / mean, bin.ratio.high / mean};
    character->psd.push_back(bin);
  }
  const Eigen::Index zones = surface.zones.isFinite().count();
  for (int z = 0; z < law::kSlopeZones; ++z) {
    if (!std::isfinite(surface.zones[z])) continue;
    character->zones.push_back(
        {double(z) / law::kSlopeZones, double(z + 1) / law::kSlopeZones,
         beside(surface, draws, zones, [z](const LookedAt& l) { return l.zones[z]; })});
  }
  character->slope_x_over_y = beside(surface, draws, 1, [](const LookedAt& l) { return l.slope_x_over_y; });
  if (!character->light_obstacle.empty()) return;
  character->length_over_width = beside_in_roundness(surface, draws);
  character->bright_share = beside(surface, draws, 1, [](const LookedAt& l) { return l.bright_share; });
}

}  // namespace

double CharacterBin::middle() const { return std::sqrt(low * high); }

std::string Character::fault() const {
  std::string worst;
  double farthest = 0;
  const auto ask = [&](const BesideDraws& one, const std::string& clause) {
    if (one.inside()) return;
    const double beyond = std::abs(std::log(one.value / (one.value < one.low ? one.low : one.high)));
    if (beyond <= farthest) return;
    farthest = beyond;
    worst = clause;
  };
  for (const CharacterBin& bin : psd)
    ask(bin.ratio,
        fmt::format("its PSD is {:.2g} times the specified one at {:.3g} /m", bin.ratio.value, bin.middle()));
  for (const ZoneSlope& zone : zones)
    ask(zone.ratio,
        fmt::format("its RMS slope is {:.2f} times that of the aperture at {:.2f}-{:.2f} R (realisations: "
                    "{:.2f}-{:.2f})",
                    zone.ratio.value, zone.rho_min, zone.rho_max, zone.ratio.low, zone.ratio.high));
  ask(slope_x_over_y, fmt::format("its slope along x is {:.2f} times that along y", slope_x_over_y.value));
  if (length_over_width)
    ask(*length_over_width, fmt::format("its PSF is {:.2f} times as long as wide", length_over_width->value));
  if (bright_share)
    ask(*bright_share,
        fmt::format(
            "{:.2g} % of the energy beyond ee35 falls on 1 % of the area there (realisations: {:.2g} %)",
            100 * bright_share->value, 100 * bright_share->mean));
  return worst;
}

// PSD and shape are compared without segment errors, which have no PSD; other wavelengths include them.
Character character_of(const Task& task, const Groundwork& ground, const TermSet& all,
                       const Eigen::VectorXd& coefficients, const RunContext& context) {
  const TermSet terms = all.without_segments();
  Character character;
  character.draws = law::kCharacterDraws;
  character.f_low = 0.5 * law::kLeastCycles / ground.radius;
  // Differences of neighbours need twice the grid cells of waves to keep 0.95 of the steepest slopes.
  const double cells_per_cycle = 2 * law::kCellsPerCycle;
  character.f_high =
      std::min(last_frequency(ground, terms), 0.25 * law::kMostCells / (cells_per_cycle * ground.radius));
  const RadialPsd psd = ground.prior_psd->band(0, character.f_high);
  const Eigen::ArrayXd edges = bin_edges(std::max(character.f_low, psd.f_min()), character.f_high);
  const double for_image = pitch_of_image(task, ground, terms, &character.light_obstacle);
  const double for_slopes = 1 / (cells_per_cycle * character.f_high);
  const SurfaceLook look(task, edges, for_image > 0 ? std::min(for_image, for_slopes) : for_slopes,
                         for_image > 0);

  const RandomStream seeds(task.fit.seed, "character-draws");
  std::vector<LookedAt> draws(law::kCharacterDraws);
  std::vector<HeightMap> kept(law::kOtherLightDraws);
  parallel_for(draws.size(), context.threads, [&](std::size_t d) {
    HeightMap map = look.draw(psd, seeds.bits(d));
    draws[d] = look(look.at_points(map));
    if (d < kept.size()) kept[d] = std::move(map);
  });
  SurfaceField field;
  SurfaceOperator(terms, look.points(), focus_operator(FocusModel::kWaves, context.threads))
      .apply(coefficients.head(terms.size()), &field);
  compare(look(field.height), draws, psd, edges, &character);
  if (ground.specified_spot && !context.stopped())
    character.others = other_light(task, ground, all, coefficients, kept, context);
  return character;
}

}  // namespace aberfit
