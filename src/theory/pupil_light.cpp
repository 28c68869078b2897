#include "pupil_light.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// The taper, in parts of the field of view: light nearer to its edge is mixed with what lies beyond and comes
// back in from the other side.
constexpr double kTaper = 0.5, kTaperEnd = 0.7;
// The same of rings: beyond the cone of light, in steps of its diffraction.
constexpr double kBeyondCone = 1.15, kStepsBeyondCone = 24, kTaperOfRings = 1.3;
// Light beyond the taper, evenly in the logarithm of its distance.
constexpr double kTailStep = 1.02, kTailEnd = 600;
// Shear times the distance where the taper begins, beyond which what is beyond has no transfer.
constexpr double kShort = 0.75;
// The same beyond which the light tells b: of its power j at j times as much.
constexpr double kSeenApart = 2;
// Cycles of the outermost light that the 24 nodes of a panel resolve.
constexpr double kCyclesOfLightPanel = 3.5;
// Nodes of rings: of Gauss-Legendre in the pupil for each turn of the phase, and in the focal plane.
constexpr double kNodesPerTurn = 3, kNodesPerStep = 5;
constexpr Eigen::Index kTogether = 256;  // rings of the focal plane at a time

double taper(double distance, double edge, double end) {
  if (distance >= end) return 0;
  return std::pow(std::cos(0.5 * pi * std::clamp((distance - edge) / (end - edge), 0.0, 1.0)), 2);
}

double binomial(int n, int k) {
  double result = 1;
  for (int i = 1; i <= k; ++i) result *= double(n - k + i) / i;
  return result;
}

Eigen::MatrixXd shifted_chebyshev(int degree) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  c(0, 0) = 1;
  if (degree > 0) c(1, 0) = -1, c(1, 1) = 2;
  for (int p = 2; p <= degree; ++p)
    for (int i = 0; i <= p; ++i)
      c(p, i) = -2 * c(p - 1, i) - c(p - 2, i) + (i > 0 ? 4 * c(p - 1, i - 1) : 0.0);
  return c;
}

// Of squares of shares `weight`: b is a times the square of a cosine.
Eigen::MatrixXd mean_of_aperture(const Eigen::ArrayXd& square, Eigen::ArrayXd weight, int degree) {
  weight /= weight.sum();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  for (int p = 0; p <= degree; ++p, weight *= square) {
    double of_cosine = 1;
    for (int q = 0; q <= p; ++q) {
      if (q > 0) of_cosine *= (2 * q - 1) / (2.0 * q);
      mean(p - q, q) = weight.sum() * of_cosine;
    }
  }
  return mean;
}

}  // namespace

PupilCells::PupilCells(const PupilField& field, int cells)
    : PupilCells(field.aperture(), field.focal_length(), field.outer(), cells) {
  wavelength_ = field.wavelength();
  path_.resize(square_.size());
  departure_ = Eigen::ArrayXd::Zero(square_.size());
  for (Eigen::Index k = 0; k < square_.size(); ++k) {
    const double sine2 = square_[k] * std::pow(outer_ / focal_length_, 2);
    path_[k] = sine2 / (1 + std::sqrt(1 - sine2));
    if (field.has_departure()) departure_[k] = field.departure_phase(grid().x[column(k)], grid().y[row(k)]);
  }
}

PupilCells::PupilCells(const Aperture& aperture, int cells)
    : PupilCells(aperture, kParaxial, aperture_radius(aperture), cells) {
  path_ = departure_ = Eigen::ArrayXd::Zero(square_.size());
}

PupilCells::PupilCells(const Aperture& aperture, double focal_length, double outer, int cells)
    : pupil_(diffraction_pupil(aperture, focal_length, 2 * outer / cells)),
      side_(int(std::max(grid().x.size(), grid().y.size()))),
      focal_length_(focal_length),
      outer_(outer),
      square_(pupil_.amplitude.size()) {
  for (Eigen::Index k = 0; k < square_.size(); ++k)
    square_[k] = (std::pow(grid().x[column(k)], 2) + std::pow(grid().y[row(k)], 2)) / (outer_ * outer_);
}

Eigen::ArrayXd PupilCells::area() const {
  return pupil_.amplitude * (pupil_.sample.weight / pupil_.cover).sqrt();
}

const CartesianGrid& PupilCells::grid() const {
  const PupilStructure& structure = pupil_.sample.structure;
  if (const auto* directions = std::get_if<DirectionGrid>(&structure)) return directions->cells;
  return std::get<CartesianGrid>(structure);
}

Eigen::ArrayXd PupilCells::phase(double dz) const {
  return departure_ + 2 * pi / wavelength_ * dz / (1 + dz / focal_length_) * path_;
}

double PupilCells::steepest(double dz) const {
  const Eigen::ArrayXd all = phase(dz);
  double most = 0;
  struct Above {
    Eigen::Index row = -2;
    double phase = 0;
  };
  std::vector<Above> above(std::size_t(grid().x.size()));
  for (Eigen::Index k = 0; k < all.size(); ++k) {
    if (k > 0 && row(k) == row(k - 1) && column(k) == column(k - 1) + 1)
      most = std::max(most, std::abs(all[k] - all[k - 1]));
    Above& one = above[std::size_t(column(k))];
    if (one.row == row(k) - 1) most = std::max(most, std::abs(all[k] - one.phase));
    one = {row(k), all[k]};
  }
  return most / (2 * pi) * 2 * outer_ / pitch();
}

FocalGrid::FocalGrid(int samples)
    : side(samples),
      transform(samples, samples),
      rings(samples / 2 + 1, samples / 2 + 1, 1, 1, 0.5 * kTaperEnd * samples) {}

int FocalGrid::samples_for(const PupilCells& cells, double end) {
  int samples = cells.side() + int(std::ceil(end / cells.pitch())) + 1;
  do samples = int(smooth_from(samples + 1));
  while (samples % 2 != 0);
  return samples;
}

std::vector<PupilLight::Product> PupilLight::products(int degree) {
  std::vector<Product> all;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j) {
      std::vector<double> powers{1};
      const auto times = [&](double scale, double sign) {
        powers.push_back(0);
        for (std::size_t k = powers.size(); k-- > 0;)
          powers[k] = scale * (powers[k] + (k > 0 ? sign * powers[k - 1] : 0.0));
      };
      for (int k = 0; k < i; ++k) times(0.5, 1);
      for (int k = 0; k < 2 * j; ++k) times(1, -1);
      all.push_back({i, j, std::move(powers)});
    }
  return all;
}

PupilLight PupilLight::of_cells(const PupilCells& cells, const FocalGrid& grid, int degree, double dz) {
  const DiffractionPupil& pupil = cells.pupil();
  const Eigen::Index n = pupil.amplitude.size(), side = grid.side;
  const Eigen::ArrayXd phase = cells.phase(dz);
  Eigen::ArrayXd sine(n), cosine(n), amplitude = pupil.amplitude;
  sin_cos(phase.data(), int(n), sine.data(), cosine.data());
  std::vector<Eigen::ArrayXcd> field;
  for (int i = 0; i <= 2 * degree; ++i, amplitude *= cells.square()) {
    field.emplace_back(Eigen::ArrayXcd::Zero(side * side));
    for (Eigen::Index k = 0; k < n; ++k)
      field.back()[cells.row(k) * side + cells.column(k)] = {amplitude[k] * cosine[k],
                                                             amplitude[k] * sine[k]};
    grid.transform(field.back().data());
  }

  const std::vector<Product> all = products(degree);
  const auto count = Eigen::Index(all.size());
  Eigen::ArrayXXd sums = Eigen::ArrayXXd::Zero(grid.rings.lengths(), count);
  Eigen::ArrayXd line(side);
  for (Eigen::Index row = 0; row < side; ++row) {
    const int from_axis = int(std::min(row, side - row));
    const Eigen::Index within = grid.rings.columns_within(from_axis);
    if (within == 0) continue;
    const std::uint32_t* const ring = grid.rings.length_of(from_axis);
    for (Eigen::Index l = 0; l < count; ++l) {
      const std::vector<double>& powers = all[std::size_t(l)].of_powers;
      // The first columns, and those as far on the other side of the axis.
      for (const Eigen::Index first : {Eigen::Index(0), side - within}) {
        auto part = line.segment(first, within);
        part.setZero();
        for (std::size_t k = 0; k < powers.size(); ++k) {
          const auto one = field[powers.size() - 1 - k].segment(row * side + first, within),
                     two = field[k].segment(row * side + first, within);
          part += powers[k] * (one.real() * two.real() + one.imag() * two.imag());
        }
      }
      double* const sum = sums.col(l).data();
      sum[ring[0]] += line[0];
      for (Eigen::Index c = 1; c < within; ++c) sum[ring[c]] += line[c] + line[side - c];
    }
  }

  PupilLight result{
      degree, cells.outer(), {}, {}, 0, 0, mean_of_aperture(cells.square(), cells.area(), degree)};
  result.edge = 0.5 * kTaper / cells.pitch();
  result.end = 0.5 * kTaperEnd / cells.pitch();
  const Eigen::Index nodes = grid.rings.nodes();
  const double step = 1 / (LagTable::kNodesPerLag * double(side) * cells.pitch());
  result.distance = step * Eigen::ArrayXd::LinSpaced(nodes, 0.0, double(nodes - 1));
  const Eigen::ArrayXd left =
      result.distance.unaryExpr([&](double d) { return taper(d, result.edge, result.end); });
  result.light.resize(nodes, count);
  for (Eigen::Index l = 0; l < count; ++l)
    result.light.col(l) =
        left * grid.rings.to_nodes(sums.col(l)) / (double(side) * double(side) * pupil.total);
  return result;
}

PupilLight PupilLight::of_rings(const PupilField& field, int degree, double dz) {
  const double inner = field.inner(), outer = field.outer();
  const double steepest = field.steepest(dz) / (2 * pi);  // [cycles/m]
  PupilLight result{degree, outer, {}, {}, 0, 0, {}};
  result.edge = kBeyondCone * steepest + kStepsBeyondCone / (2 * outer);
  result.end = kTaperOfRings * result.edge;
  const double turns = (outer - inner) * (steepest + result.end);
  const Quadrature pupil = gauss_legendre(32 + int(kNodesPerTurn * turns), inner, outer);
  const Eigen::Index n = pupil.nodes.size();
  const Eigen::ArrayXd square = (pupil.nodes / outer).square();
  Eigen::ArrayXd amplitude(n), phase(n), sine(n), cosine(n);
  field.along_radius(dz, pupil.nodes, &amplitude, &phase);
  sin_cos(phase.data(), int(n), sine.data(), cosine.data());
  const Eigen::ArrayXd ring = 2 * pi * pupil.nodes * pupil.weights;
  const double total = (ring * amplitude.square()).sum();
  result.mean = mean_of_aperture(square, ring * amplitude.square(), degree);
  Eigen::MatrixXd fields(n, 2 * (2 * degree + 1));
  Eigen::ArrayXd weight = ring * amplitude;
  for (int i = 0; i <= 2 * degree; ++i, weight *= square) {
    fields.col(2 * i) = weight * cosine;
    fields.col(2 * i + 1) = weight * sine;
  }

  const std::vector<Product> all = products(degree);
  const int panels = 1 + int(result.end * 2 * outer * kNodesPerStep / 24);
  const Quadrature unit = gauss_legendre(24, 0.0, result.end / panels);
  result.distance.resize(24 * panels);
  result.light.resize(24 * panels, Eigen::Index(all.size()));
  for (int p = 0; p < panels; ++p) result.distance.segment(24 * p, 24) = result.end * p / panels + unit.nodes;
  Eigen::MatrixXd bessel;
  Eigen::ArrayXd z(n), unused(n);
  for (Eigen::Index first = 0; first < result.distance.size(); first += kTogether) {
    const Eigen::Index rows = std::min(kTogether, result.distance.size() - first);
    bessel.resize(n, rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      z = 2 * pi * result.distance[first + k] * pupil.nodes;
      bessel_j0_j1(z.data(), int(n), bessel.col(k).data(), unused.data());
    }
    const Eigen::MatrixXd focal = bessel.transpose() * fields;
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double d = result.distance[first + k];
      const double area =
          2 * pi * d * unit.weights[(first + k) % 24] * taper(d, result.edge, result.end) / total;
      for (std::size_t l = 0; l < all.size(); ++l) {
        double sum = 0;
        const std::vector<double>& powers = all[l].of_powers;
        for (std::size_t i = 0; i < powers.size(); ++i) {
          const auto one = Eigen::Index(2 * (powers.size() - 1 - i)), two = Eigen::Index(2 * i);
          sum += powers[i] * (focal(k, one) * focal(k, two) + focal(k, one + 1) * focal(k, two + 1));
        }
        result.light(first + k, Eigen::Index(l)) = area * sum;
      }
    }
  }
  return result;
}

LightMoments::LightMoments(PupilLight light, const MomentBasis& basis)
    : light_(std::move(light)),
      basis_(basis),
      products_(PupilLight::products(light_.degree)),
      shifted_(shifted_chebyshev(light_.degree)),
      missing_(1 - light_.light.col(0).sum()) {
  const auto steps = Eigen::Index(std::log(kTailEnd) / std::log(kTailStep));
  tail_ =
      light_.edge * (std::log(kTailStep) * Eigen::ArrayXd::LinSpaced(steps, 0.0, double(steps - 1))).exp();
  share_ = tail_.unaryExpr([this](double d) { return (1 - taper(d, light_.edge, light_.end)) / d; });
  share_ /= share_.sum();
}

double LightMoments::resolved() const { return kCyclesOfLightPanel / light_.end; }

Eigen::MatrixXd LightMoments::chebyshev(const Eigen::MatrixXd& monomials) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(basis_.order, basis_.order);
  const Eigen::MatrixXd of_degree = shifted_ * monomials * shifted_.transpose();
  const int most = std::min(light_.degree, basis_.order - 1);
  for (int p = 0; p <= most; ++p)
    for (int q = 0; q <= std::min(most, light_.degree - p); ++q) all(p, q) = of_degree(p, q);
  return all;
}

Eigen::ArrayXd LightMoments::whole() const { return basis_.at_nodes(chebyshev(light_.mean)); }

// From sums over the light of the products to those of a^i b^j.
Eigen::MatrixXd LightMoments::monomials(const Eigen::ArrayXd& sums, double shear2) const {
  const int degree = light_.degree;
  Eigen::MatrixXd in_sum = Eigen::MatrixXd::Zero(degree + 1, degree + 1), result = in_sum;
  for (std::size_t l = 0; l < products_.size(); ++l)
    in_sum(products_[l].i, products_[l].j) = sums[Eigen::Index(l)] / std::pow(4 * shear2, products_[l].j);
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      for (int k = 0; k <= i; ++k)
        result(i, j) += binomial(i, k) * std::pow(-0.25 * shear2, i - k) * in_sum(k, j);
  return result;
}

Eigen::ArrayXXd LightMoments::operator()(const Eigen::ArrayXd& x) const {
  const Eigen::Index n = light_.distance.size();
  Eigen::ArrayXXd result(x.size(), basis_.order * basis_.order);
  Eigen::ArrayXd z(std::max(n, tail_.size())), j0(z.size()), j1(z.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    z.head(n) = 2 * pi * x[k] * light_.distance;
    bessel_j0_j1(z.data(), int(n), j0.data(), j1.data());
    Eigen::ArrayXd sums = light_.light.matrix().transpose() * j0.head(n).matrix();
    if (x[k] * light_.edge < kShort) {
      z.head(tail_.size()) = 2 * pi * x[k] * tail_;
      bessel_j0_j1(z.data(), int(tail_.size()), j0.data(), j1.data());
      sums[0] += missing_ * (share_ * j0.head(tail_.size())).sum();
    }
    Eigen::MatrixXd all = monomials(sums, std::pow(x[k] / light_.outer, 2));
    // Of two points that are close b is a small difference over a small shear: there it has its mean over the
    // aperture.
    for (int j = 1; j <= light_.degree; ++j) {
      const double known = std::pow(std::min(1.0, x[k] * light_.edge / (kSeenApart * j)), 2 * j);
      for (int i = 0; i + j <= light_.degree; ++i)
        all(i, j) = (known > 0 ? known * all(i, j) : 0.0) + (1 - known) * sums[0] * light_.mean(i, j);
    }
    result.row(k) = basis_.at_nodes(chebyshev(all)).transpose();
  }
  return result;
}

}  // namespace aberfit::internal
