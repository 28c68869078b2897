#include "aberfit/theory/realisation_spread.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/theory/aperture_otf.h"
#include "aberfit/theory/scattering_band.h"
#include "frequency_panels.h"
#include "height_adjoint.h"
#include "scrambled_light.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kLongest = 0.05;       // longest wave: cycles across the aperture
constexpr double kCore = 2;             // in lambda f/diameter: scale of the table of encircled energy
constexpr double kBetweenPlanes = 0.5;  // correlation of pairs in the focus and at the end of a width
constexpr double kPartOfFocus = 0.95;   // largest radius of tables of encircled energy, over the focal length

// Energy of a mean spot in discs away from its axis, from a table of its encircled energy.
class ShiftedDisc {
 public:
  // core: radius [m] of the order of the spot's finest detail; reach: largest distance from the axis [m].
  ShiftedDisc(const MeanSpot& spot, double core, double reach);
  // Energy in a disc of `radius` whose centre is `shift` from the axis [m]:
  //   (1/2 pi) oint E(rho)/rho^2 (X . n) ds
  // around its edge, by Gauss's theorem. Error about 1e-3 of E(radius), from linear interpolation of E/rho^2.
  double operator()(double radius, double shift) const;

 private:
  double mean_irradiance(double rho) const;  // E(rho)/rho^2

  static constexpr double kStep = 0.03;   // in asinh(rho/core)
  static constexpr double kFirst = 1e-3;  // in units of the core: radius of the node at the centre
  static constexpr int kNodes = 32;
  static constexpr double kNarrowest = 1e-5;  // rad
  Quadrature rule_;
  double core_;
  Eigen::ArrayXd table_;  // over asinh(rho/core)
  double end_ = 0, light_ = 0;
};

ShiftedDisc::ShiftedDisc(const MeanSpot& spot, double core, double reach)
    : rule_(gauss_legendre(kNodes, 0, 1)), core_(core) {
  const auto count = Eigen::Index(std::ceil(std::asinh(reach / core) / kStep)) + 2;
  table_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double rho = core * std::sinh(i == 0 ? kFirst : double(i) * kStep);
    table_[i] = spot.encircled_energy(rho) / (rho * rho);
    if (i == count - 1) end_ = rho, light_ = table_[i] * rho * rho;
  }
}

double ShiftedDisc::mean_irradiance(double rho) const {
  if (rho >= end_) return light_ / (rho * rho);
  const double place = std::asinh(rho / core_) / kStep;
  const auto i = std::min(Eigen::Index(place), table_.size() - 2);
  return table_[i] + (place - double(i)) * (table_[i + 1] - table_[i]);
}

double ShiftedDisc::operator()(double radius, double shift) const {
  // Integrates over the angle b from the point of the edge nearest to the axis, with b = narrow sinh(s). So
  // the steps grow from the size of the spot's core, or from the distance to it if that is larger.
  const double nearest = std::abs(radius - shift);
  const double narrow = std::clamp(
      std::hypot(0.5 * core_, nearest) / std::sqrt(radius * std::max(radius, shift)), kNarrowest, 1.0);
  const double last = std::asinh(kPi / narrow);
  double sum = 0;
  for (int k = 0; k < kNodes; ++k) {
    const double s = last * rule_.nodes[k], b = narrow * std::sinh(s), sine = std::sin(0.5 * b);
    const double rho = std::sqrt(nearest * nearest + 4 * radius * shift * sine * sine);
    sum += rule_.weights[k] * narrow * std::cosh(s) * mean_irradiance(rho) *
           (radius - shift + 2 * shift * sine * sine);
  }
  return std::max(0.0, radius / kPi * last * sum);
}

// Indices of the discs in one plane.
struct Plane {
  double dz = 0;
  std::vector<std::size_t> discs;
};

std::vector<Plane> planes_of(const std::vector<FocalDisc>& discs) {
  std::map<double, std::size_t> known;
  std::vector<Plane> planes;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const auto [place, is_new] = known.try_emplace(discs[i].dz, planes.size());
    if (is_new) planes.push_back({discs[i].dz, {}});
    planes[place->second].discs.push_back(i);
  }
  return planes;
}

// Appends a disc in the focus for each disc that is the end of a width.
std::vector<FocalDisc> with_focus(const std::vector<FocalDisc>& discs) {
  std::vector<FocalDisc> result = discs;
  for (const FocalDisc& disc : discs)
    if (disc.is_end_of_width) result.push_back({disc.radius, 0});
  return result;
}

// Phase per height [1/m], root mean square over the aperture, with the obliquity 1/(1 + t^2).
double wave_number(const SpreadProblem& problem) {
  double square = 0;
  for (const RadialNode& node : radial_quadrature(problem.aperture, 16)) {
    const double t = 0.5 * node.rho / problem.mirror.focal_length;
    square += node.weight * std::pow(1 + t * t, -2);
  }
  return 4 * kPi / problem.wavelength * std::sqrt(square);
}

// Radius of the largest disc over lambda F [cycles/m].
double largest(const SpreadProblem& problem, const std::vector<FocalDisc>& discs) {
  double result = 0;
  for (const FocalDisc& disc : discs)
    result = std::max(result, disc.radius / (problem.wavelength * (problem.mirror.focal_length + disc.dz)));
  return result;
}

RadialPsd checked(const SpreadProblem& problem, const std::vector<FocalDisc>& discs) {
  if (!(problem.wavelength > 0)) throw std::invalid_argument("spread of realisations: no wavelength");
  for (const FocalDisc& disc : discs)
    if (!(disc.radius > 0))
      throw std::invalid_argument(fmt::format("spread of realisations: a disc of radius {} m", disc.radius));
  for (const FocalDisc& disc : discs)
    if (!(std::isfinite(disc.dz) && problem.mirror.focal_length + disc.dz > 0))
      throw ComputationError(fmt::format("there is no plane {} m from the focus", disc.dz));
  if (!(problem.psd.f_min() * problem.wavelength < 1))
    throw ComputationError(
        "this roughness scatters no light, because all its frequencies are above 1/wavelength");
  return scattering_band(problem.psd, problem.wavelength).psd;
}

// Largest ratio of a spread to its limit.
SmallestCut judged(const RealisationSpread& spread, const Eigen::ArrayXd& limits, double cut) {
  SmallestCut result;
  result.frequency = cut;
  const Eigen::ArrayXd light = spread.light(cut) / limits;
  Eigen::Index worst = -1;
  if (light.size() > 0) result.share_of_limit = light.maxCoeff(&worst);
  result.disc = int(worst);
  return result;
}

// Terms represent a rest narrower than one cycle: all of it up to half a cycle, then less and less.
double resolved_cut(const RealisationSpread& spread, double cut) {
  const double width = spread.highest() - cut, cycle = spread.resolution();
  return width < cycle ? spread.highest() - std::max(0.0, 2 * width - cycle) : cut;
}

}  // namespace

struct RealisationSpread::Tables {
  // with_pairs: also computes `pairs`; needs discs of one plane.
  Tables(const SpreadProblem& problem, const std::vector<FocalDisc>& discs, int threads,
         bool with_pairs = false);
  // The three terms of var E(r), nodes x discs.
  struct Terms {
    Eigen::ArrayXXd linear;  // factor of S
    Eigen::ArrayXXd moving;  // S dE/dS
    Eigen::ArrayXXd moved;   // M
  };
  void evaluate(const SpreadProblem& problem, const std::vector<FocalDisc>& discs, const Plane& plane,
                const std::map<int, AdjointGrid>& grids, Terms* terms, bool with_pairs);
  Eigen::ArrayXXd integrand(const std::vector<FocalDisc>& discs, const Terms& terms) const;
  Eigen::ArrayXd weights() const;  // weights of int d2f over the band
  FrequencyPanels::Place place(double cut) const {
    return panels.place(std::clamp(cut, panels.edges().front(), panels.edges().back()));
  }

  RadialPsd psd;
  double phase_per_height, area, diameter;
  FrequencyPanels panels;
  Eigen::ArrayXd s;                       // S at the nodes
  std::optional<TailIntegrals> of_psd;    // S^2 d2f, ((2 pi f)^2 S)^2 d2f
  std::optional<TailIntegrals> of_light;  // the integrands of var E(r), one per disc
  ScrambledLight scrambled;
  double height_variance, slope_variance;
  Eigen::MatrixXd pairs;  // covariance matrix of the discs
};

Eigen::ArrayXd RealisationSpread::Tables::weights() const {
  Eigen::ArrayXd result(panels.frequency().size());
  for (Eigen::Index p = 0; p < panels.panels(); ++p)
    result.segment<FrequencyPanels::kNodes>(p * FrequencyPanels::kNodes) = panels.width(p) * panels.weights();
  return kTwoPi * panels.frequency() * result;
}

RealisationSpread::Tables::Tables(const SpreadProblem& problem, const std::vector<FocalDisc>& discs,
                                  int threads, bool with_pairs)
    : psd(checked(problem, discs)),
      phase_per_height(wave_number(problem)),
      area(aperture_area(problem.aperture)),
      diameter(2 * aperture_radius(problem.aperture)),
      panels(psd, std::max(psd.f_min(), std::min(kLongest / diameter, 0.5 * psd.f_max())),
             std::min(psd.f_max(), 1 / problem.wavelength), 1 / diameter),
      s(panels.frequency().unaryExpr([this](double f) { return psd(f); })),
      scrambled(psd, {phase_per_height, problem.wavelength, diameter, area, largest(problem, discs)},
                ApertureOtf(problem.aperture), panels.edges().front(), panels.edges().back()),
      height_variance(radial_moment(problem.psd, 0)),
      slope_variance(kTwoPi * kTwoPi * radial_moment(problem.psd, 2)) {
  const Eigen::ArrayXd& f = panels.frequency();
  Eigen::ArrayXXd moments(f.size(), 2);
  moments.col(0) = kTwoPi * f * s.square();
  moments.col(1) = kTwoPi * f * ((kTwoPi * f).square() * s).square();
  of_psd.emplace(panels, std::move(moments));

  const std::vector<FocalDisc> all = with_focus(discs);
  const std::vector<Plane> planes = planes_of(all);
  std::map<int, AdjointGrid> grids;
  for (const Plane& plane : planes) {
    const int cells = AdjointGrid::cells_for(problem, plane.dz);
    const auto [grid, is_new] = grids.try_emplace(cells, problem, cells);
    if (is_new) grid->second.set_frequencies(f);
  }
  const Eigen::ArrayXXd none = Eigen::ArrayXXd::Zero(f.size(), Eigen::Index(all.size()));
  Terms terms{none, none, none};
  parallel_for(planes.size(), threads,
               [&](std::size_t i) { evaluate(problem, all, planes[i], grids, &terms, with_pairs); });
  of_light.emplace(panels, integrand(discs, terms));
}

// Integrands of the caller's discs; the discs of `with_focus` follow them.
Eigen::ArrayXXd RealisationSpread::Tables::integrand(const std::vector<FocalDisc>& discs,
                                                     const Terms& terms) const {
  Eigen::ArrayXXd result(s.size(), Eigen::Index(discs.size()));
  Eigen::Index focus = result.cols();
  for (Eigen::Index d = 0; d < result.cols(); ++d) {
    Eigen::ArrayXd moving = terms.moving.col(d), others = terms.linear.col(d) + terms.moved.col(d);
    if (discs[std::size_t(d)].is_end_of_width) {
      const auto here = terms.moved.col(d), there = terms.moved.col(focus);
      moving -= 0.5 * terms.moving.col(focus);
      others = here + 0.25 * there - kBetweenPlanes * (here * there).sqrt();
      ++focus;
    }
    result.col(d) = kTwoPi * panels.frequency() * (2 / area * moving.square() + s * others);
  }
  return result;
}

// Writes only the columns of the discs in this plane.
void RealisationSpread::Tables::evaluate(const SpreadProblem& problem, const std::vector<FocalDisc>& discs,
                                         const Plane& plane, const std::map<int, AdjointGrid>& grids,
                                         Terms* terms, bool with_pairs) {
  const double focal_length = problem.mirror.focal_length, distance = focal_length + plane.dz;
  const double per_frequency = problem.wavelength * distance;  // shift of the spot per frequency [m^2]
  const Eigen::ArrayXd& f = panels.frequency();
  double reach = per_frequency * f[f.size() - 1];
  std::vector<double> radius;
  for (const std::size_t i : plane.discs) radius.push_back(discs[i].radius);
  reach = std::min(reach + *std::max_element(radius.begin(), radius.end()), kPartOfFocus * focal_length);
  const MeanSpot spot = problem.mean.at_plane(plane.dz);
  const ShiftedDisc shifted(spot, kCore * per_frequency / diameter, reach);
  const AdjointGrid& grid = grids.at(AdjointGrid::cells_for(problem, plane.dz));
  const HeightAdjoint adjoint(grid, plane.dz);
  const double square = phase_per_height * phase_per_height;
  const Eigen::ArrayXd transfer = adjoint.transfer_function();
  const Eigen::ArrayXXd moved = scrambled(f, transfer, grid.pitch(), distance, radius);
  Eigen::ArrayXXd answered, moving(f.size(), Eigen::Index(radius.size()));  // S dE/dS, one column per disc
  if (!adjoint.is_flat()) answered = adjoint.power(radius);
  for (std::size_t d = 0; d < radius.size(); ++d) {
    const double inside = spot.encircled_energy(radius[d]);
    for (Eigen::Index k = 0; k < f.size(); ++k)
      moving(k, Eigen::Index(d)) = s[k] * square * (shifted(radius[d], per_frequency * f[k]) - inside);
    const auto column = Eigen::Index(plane.discs[d]);
    terms->moving.col(column) = moving.col(Eigen::Index(d));
    terms->moved.col(column) = moved.col(Eigen::Index(d));
    if (!adjoint.is_flat()) terms->linear.col(column) = answered.col(Eigen::Index(d));
  }
  if (!with_pairs) return;
  const Eigen::ArrayXd weight = weights();
  pairs = 2 / area * moving.matrix().transpose() * weight.matrix().asDiagonal() * moving.matrix() +
          scrambled.covariance(f, weight * s, transfer, grid.pitch(), distance, radius);
  if (adjoint.is_flat()) return;
  // The grid of heights gives the correlation; the panels give a more accurate variance.
  Eigen::MatrixXd linear = adjoint.covariance(radius, psd);
  const Eigen::ArrayXd variance = (answered.colwise() * (weight * s)).colwise().sum().transpose();
  const Eigen::VectorXd scale = (variance / linear.diagonal().array().max(1e-300)).sqrt();
  pairs += scale.asDiagonal() * linear * scale.asDiagonal();
}

RealisationSpread::RealisationSpread(const SpreadProblem& problem, const std::vector<FocalDisc>& discs,
                                     int threads)
    : tables_(std::make_unique<const Tables>(problem, discs, threads)) {}
RealisationSpread::~RealisationSpread() = default;
RealisationSpread::RealisationSpread(RealisationSpread&&) noexcept = default;
RealisationSpread& RealisationSpread::operator=(RealisationSpread&&) noexcept = default;

double RealisationSpread::lowest() const { return edges().front(); }
double RealisationSpread::highest() const { return edges().back(); }
double RealisationSpread::resolution() const { return 1 / tables_->diameter; }
const std::vector<double>& RealisationSpread::edges() const { return tables_->panels.edges(); }

Eigen::ArrayXd RealisationSpread::light(double cut) const {
  return tables_->of_light->from(tables_->place(cut)).sqrt();
}

Eigen::MatrixXd RealisationSpread::covariance(const SpreadProblem& problem,
                                              const std::vector<FocalDisc>& discs) {
  for (const FocalDisc& disc : discs)
    if (disc.dz != discs.front().dz)
      throw std::invalid_argument("covariance of energies: the discs lie in more than one plane");
  if (discs.empty()) return {};
  return Tables(problem, discs, 1, true).pairs;
}

double RealisationSpread::rms_height(double cut) const {
  const double variance = 2 / tables_->area * tables_->of_psd->from(tables_->place(cut))[0];
  return 0.5 * std::sqrt(variance) / tables_->height_variance;
}

double RealisationSpread::rms_slope(double cut) const {
  const double variance = 2 / tables_->area * tables_->of_psd->from(tables_->place(cut))[1];
  return 0.5 * std::sqrt(variance) / tables_->slope_variance;
}

SmallestCut smallest_cut(const RealisationSpread& spread, const Eigen::ArrayXd& limits) {
  if (limits.size() != spread.light(spread.highest()).size())
    throw std::invalid_argument("smallest cut: one limit per disc is needed");
  if (!(limits > 0).all()) throw std::invalid_argument("smallest cut: every limit must be above zero");
  const std::vector<double>& edges = spread.edges();
  std::size_t below = edges.size() - 1;  // the highest edge that breaks a limit
  while (below > 0 && judged(spread, limits, edges[below - 1]).share_of_limit <= 1) --below;
  if (below == 0) {
    SmallestCut result = judged(spread, limits, edges.front());
    result.whole_band = true;
    return result;
  }
  const auto excess = [&](double u) { return judged(spread, limits, std::exp(u)).share_of_limit - 1; };
  std::uintmax_t steps = 100;
  const auto close = [](double a, double b) { return std::abs(a - b) <= 1e-12; };
  const auto bracket = boost::math::tools::toms748_solve(excess, std::log(edges[below - 1]),
                                                         std::log(edges[below]), close, steps);
  return judged(spread, limits, resolved_cut(spread, std::exp(bracket.second)));
}

}  // namespace aberfit
