#include "height_adjoint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/scene/segments.h"

namespace aberfit::internal {
namespace {

using Complex = std::complex<double>;

constexpr int kFewestCells = 64, kMostCells = 512;
constexpr int kTransferPerCell = 8, kBinsPerCell = 4;
constexpr double kCarried = 0.45;  // largest usable cycles per grid cell; the limit is 0.5
constexpr int kCyclesOfEdge = 12;  // extra cycles, for diffraction at the aperture's edge
constexpr int kSamplesOfPhase = 200;
constexpr double kFlat = 1e-9;  // rad

double phase_of_departure(const SpreadProblem& problem, double x, double y) {
  const double f = problem.mirror.focal_length, r2 = x * x + y * y, t2 = r2 / (4 * f * f);
  double height = is_parabola(problem.mirror) ? 0 : base_surface(problem.mirror, x, y).height - r2 / (4 * f);
  if (problem.departure) height += problem.departure(x, y);
  return 4 * kPi / problem.wavelength * height / (1 + t2);
}

double defocus(double focal_length, double wavelength, double dz) {
  return kTwoPi / wavelength * focal_length * dz / (focal_length + dz);
}

// 1 - cos theta at the squared distance r2 from the axis on the mirror.
double one_minus_cosine(double r2, double focal_length) {
  const double t2 = r2 / (4 * focal_length * focal_length);
  return 2 * t2 / (1 + t2);
}

// Distance of a point on a periodic grid from its origin [grid cells].
double distance(int i, int j, int side) { return std::hypot(std::min(i, side - i), std::min(j, side - j)); }

// The transform with exp(+...) in place of exp(-...), by conjugation before and after.
void inverse(const FourierTransform& transform, ComplexGrid* values) {
  for (Complex& value : *values) value = std::conj(value);
  transform(values->data());
  const double scale = 1 / double(values->size());
  for (Complex& value : *values) value = std::conj(value) * scale;
}

}  // namespace

int AdjointGrid::cells_for(const SpreadProblem& problem, double dz) {
  const double f = problem.mirror.focal_length, rim = aperture_radius(problem.aperture);
  const double step = rim / kSamplesOfPhase;
  double steepest = 0;  // rad/m
  for (const double direction : {0.3, 1.1, 2.2, 3.7, 5.2}) {
    const double cosine = std::cos(direction), sine = std::sin(direction);
    double last = 0;
    for (int i = 0; i <= kSamplesOfPhase; ++i) {
      const double r = i * step;
      const double phase = phase_of_departure(problem, r * cosine, r * sine) +
                           defocus(f, problem.wavelength, dz) * one_minus_cosine(r * r, f);
      if (i > 0 && std::isfinite(phase)) steepest = std::max(steepest, std::abs(phase - last) / step);
      last = phase;
    }
  }
  // A frequency that shifts the spot by more than its width does not interfere with it.
  const double cycles = 2 * steepest / kTwoPi * 2 * rim + kCyclesOfEdge;
  // Powers of two, and three times such powers, transform fast.
  int cells = kFewestCells;
  while (cells < 2 * cycles && cells < kMostCells) cells = cells % 3 == 0 ? cells / 3 * 4 : cells / 2 * 3;
  return cells;
}

AdjointGrid::AdjointGrid(const SpreadProblem& problem, int cells)
    : focal_length_(problem.mirror.focal_length),
      wavelength_(problem.wavelength),
      pupil_(diffraction_pupil(without_segment_errors(problem.aperture), problem.mirror.focal_length,
                               2 * aperture_radius(problem.aperture) / cells)),
      side_(2 * cells),
      transform_(side_, side_) {
  const auto& structure = std::get<DirectionGrid>(pupil_.sample.structure).cells;
  const Eigen::Index points = pupil_.sample.size();
  departure_.resize(points);
  for (Eigen::Index k = 0; k < points; ++k) {
    const double value = phase_of_departure(problem, pupil_.sample.x[k], pupil_.sample.y[k]);
    departure_[k] = std::isfinite(value) ? value : 0;  // grid cells at the edge may lie beyond the sag
    place_.push_back(structure.row[std::size_t(k)] * std::size_t(side_) + structure.column[std::size_t(k)]);
  }
  distance_.resize((cells + 1) * (cells + 2) / 2);
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= i; ++j) distance_[i * (i + 1) / 2 + j] = std::hypot(i, j);
  transfer_.resize(Eigen::Index(1.5 * cells) * kTransferPerCell + 2);
  const double cutoff = 2 * aperture_radius(problem.aperture);
  for (Eigen::Index i = 0; i < transfer_.size(); ++i)
    transfer_[i] = problem.mean.surface_transfer(std::min(cutoff, double(i) / kTransferPerCell * pitch()));
}

Eigen::ArrayXd AdjointGrid::phase(double dz) const {
  Eigen::ArrayXd result = departure_;
  const double scale = defocus(focal_length_, wavelength_, dz);
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    const double x = pupil_.sample.x[k], y = pupil_.sample.y[k];
    result[k] += scale * one_minus_cosine(x * x + y * y, focal_length_);
  }
  return result;
}

double AdjointGrid::transfer(double cells) const {
  const double place = std::min(cells * kTransferPerCell, double(transfer_.size() - 2));
  const auto i = Eigen::Index(place);
  return transfer_[i] + (place - double(i)) * (transfer_[i + 1] - transfer_[i]);
}

void AdjointGrid::set_frequencies(const Eigen::ArrayXd& frequency) {
  const int bins = side_ * 3 / 4 * kBinsPerCell;  // up to the pupil's diagonal
  bessel_ = Eigen::MatrixXd::Zero(bins, frequency.size());
  Eigen::ArrayXd z(bins), unused(bins);
  for (Eigen::Index i = 0; i < frequency.size(); ++i) {
    if (!(frequency[i] * pitch() < kCarried)) continue;
    z.setLinSpaced(bins, 0.0, bins - 1.0);
    z *= kTwoPi * frequency[i] * pitch() / kBinsPerCell;
    bessel_j0_j1(z.data(), bins, bessel_.col(i).data(), unused.data());
  }
}

HeightAdjoint::HeightAdjoint(const AdjointGrid& grid, double dz) : grid_(grid), dz_(dz) {
  const Eigen::ArrayXd phase = grid.phase(dz);
  flat_ = (phase - phase[0]).abs().maxCoeff() < kFlat;
  field_.assign(std::size_t(grid.side()) * std::size_t(grid.side()), 0);
  for (Eigen::Index k = 0; k < phase.size(); ++k)
    field_[grid.place(k)] = std::polar(1.0, -phase[k]) * grid.pupil().amplitude[k];
  transform_ = field_;
  grid.transform()(transform_.data());
}

// Transforms of the kernel r J1(2 pi r nu)/nu times the mean transfer function of the roughness: the weight
// of a lag of the field in the energy of a disc. Both kernels are even and real, so one transform serves two
// discs: the first in the real part, the second in the imaginary part.
ComplexGrid HeightAdjoint::kernels(double first, double second) const {
  const int side = grid_.side(), half = side / 2;
  const double scale =
      grid_.pitch() / (grid_.wavelength() * (grid_.focal_length() + dz_));  // [1/m] per grid cell
  const Eigen::ArrayXd& distance = grid_.distance();
  Eigen::ArrayXd z(half + 1), j0(half + 1), j1(half + 1);
  ComplexGrid result(field_.size());
  for (int i = 0; i <= half; ++i) {
    std::array<Eigen::ArrayXd, 2> value;
    for (const int disc : {0, 1}) {
      const double radius = disc == 0 ? first : second;
      const auto cells = distance.segment(i * (i + 1) / 2, i + 1);
      z.head(i + 1) = kTwoPi * radius * scale * cells;
      bessel_j0_j1(z.data(), i + 1, j0.data(), j1.data());
      value[std::size_t(disc)] = radius * scale * j1.head(i + 1) / cells;
      if (i == 0) value[std::size_t(disc)][0] = kPi * radius * radius * scale * scale;
    }
    for (int j = 0; j <= i; ++j) {
      const double transfer = grid_.transfer(distance[i * (i + 1) / 2 + j]) / grid_.pupil().total;
      const Complex both(value[0][j] * transfer, value[1][j] * transfer);
      for (const int a : {i, (side - i) % side})
        for (const int b : {j, (side - j) % side}) {
          result[std::size_t(a) * std::size_t(side) + std::size_t(b)] = both;
          result[std::size_t(b) * std::size_t(side) + std::size_t(a)] = both;
        }
    }
  }
  grid_.transform()(result.data());
  return result;
}

// Autocorrelations of two real arrays, as real and imaginary part, over bins of distance: bins x 2.
Eigen::MatrixXd HeightAdjoint::autocorrelations(ComplexGrid responses) const {
  const auto side = std::size_t(grid_.side());
  grid_.transform()(responses.data());
  ComplexGrid powers(responses.size());
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t j = 0; j < side; ++j) {
      const Complex here = responses[i * side + j],
                    there = std::conj(responses[(side - i) % side * side + (side - j) % side]);
      powers[i * side + j] = 0.25 * Complex(std::norm(here + there), std::norm(here - there));
    }
  grid_.transform()(powers.data());  // even and real, so this is also the inverse, but for a factor
  Eigen::MatrixXd bins = Eigen::MatrixXd::Zero(grid_.bessel().rows(), 2);
  const std::size_t half = side / 2;
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t j = 0; j <= half; ++j) {  // the other half is the same
      const std::size_t a = std::min(i, side - i), low = std::min(a, j), high = std::max(a, j);
      const double place = grid_.distance()[Eigen::Index(high * (high + 1) / 2 + low)] * kBinsPerCell;
      const auto bin = Eigen::Index(place);
      if (bin + 1 >= bins.rows()) continue;
      const Complex value = (j == 0 || j == half ? 1.0 : 2.0) * powers[i * side + j];
      const double part = place - double(bin);
      bins(bin, 0) += (1 - part) * value.real();
      bins(bin, 1) += (1 - part) * value.imag();
      bins(bin + 1, 0) += part * value.real();
      bins(bin + 1, 1) += part * value.imag();
    }
  return bins / double(responses.size());
}

ComplexGrid HeightAdjoint::responses(double first, std::optional<double> second) const {
  const ComplexGrid kernel = kernels(first, second.value_or(first));
  ComplexGrid result(field_.size()), light(field_.size());
  for (const int disc : {0, 1}) {
    if (disc == 1 && !second) break;
    for (std::size_t k = 0; k < light.size(); ++k)
      light[k] = std::conj((disc == 0 ? kernel[k].real() : kernel[k].imag()) * transform_[k]);
    grid_.transform()(light.data());
    // E = sum_k conj(U_k) V_k, with V the field times the kernel (`light` holds its conjugate). A height at k
    // changes the phase of U_k by -4 pi q_k/lambda.
    const double scale = 8 * kPi / (grid_.wavelength() * double(light.size()));
    for (Eigen::Index k = 0; k < grid_.pupil().sample.size(); ++k) {
      const std::size_t place = grid_.place(k);
      const double response = scale * grid_.pupil().obliquity[k] * (field_[place] * light[place]).imag();
      result[place] += disc == 0 ? Complex(response, 0) : Complex(0, response);
    }
  }
  return result;
}

Eigen::ArrayXXd HeightAdjoint::power(const std::vector<double>& radius) const {
  Eigen::ArrayXXd result(grid_.bessel().cols(), Eigen::Index(radius.size()));
  for (std::size_t d = 0; d < radius.size(); d += 2) {
    const bool is_pair = d + 1 < radius.size();
    ComplexGrid of_heights = responses(radius[d], is_pair ? std::optional(radius[d + 1]) : std::nullopt);
    // |transform|^2 averaged over direction is the transform of the autocorrelation averaged over direction.
    const Eigen::MatrixXd power = grid_.bessel().transpose() * autocorrelations(std::move(of_heights));
    result.middleCols(Eigen::Index(d), is_pair ? 2 : 1) = power.leftCols(is_pair ? 2 : 1).array().max(0.0);
  }
  return result;
}

Eigen::MatrixXd HeightAdjoint::covariance(const std::vector<double>& radius, const RadialPsd& psd) const {
  const auto discs = Eigen::Index(radius.size());
  const int side = grid_.side(), half = side / 2;
  const double step = 1 / (side * grid_.pitch());
  // Frequencies of the upper half-plane with S > 0; the lower half has their conjugates.
  std::vector<std::pair<std::size_t, std::size_t>> places;  // indices of f and -f
  std::vector<double> weight;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < half; ++j) {
      const double f = step * distance(i, j, side), s = i == 0 && j == 0 ? 0 : psd(f);
      if (!(s > 0) || f * grid_.pitch() > kCarried) continue;
      places.emplace_back(
          std::size_t(i) * std::size_t(side) + std::size_t(j),
          std::size_t((side - i) % side) * std::size_t(side) + std::size_t((side - j) % side));
      weight.push_back((j == 0 ? 1 : 2) * s * step * step);
    }
  Eigen::MatrixXf answers(2 * Eigen::Index(places.size()), discs);  // rows: real and imaginary parts
  for (Eigen::Index d = 0; d < discs; d += 2) {
    const bool is_pair = d + 1 < discs;
    ComplexGrid both =
        responses(radius[std::size_t(d)], is_pair ? std::optional(radius[std::size_t(d) + 1]) : std::nullopt);
    grid_.transform()(both.data());
    for (std::size_t p = 0; p < places.size(); ++p) {
      const Complex here = both[places[p].first], there = std::conj(both[places[p].second]);
      const Complex first = 0.5 * std::sqrt(weight[p]) * (here + there),
                    second = Complex(0, -0.5) * std::sqrt(weight[p]) * (here - there);
      const auto row = 2 * Eigen::Index(p);
      answers(row, d) = float(first.real()), answers(row + 1, d) = float(first.imag());
      if (is_pair) answers(row, d + 1) = float(second.real()), answers(row + 1, d + 1) = float(second.imag());
    }
  }
  return (answers.transpose() * answers).cast<double>();
}

Eigen::ArrayXd HeightAdjoint::transfer_function() const {
  const int side = grid_.side();
  ComplexGrid lags(transform_.size());
  for (std::size_t k = 0; k < lags.size(); ++k) lags[k] = std::norm(transform_[k]);
  inverse(grid_.transform(), &lags);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(side + 1), count = sum;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double place = distance(i, j, side);
      const auto bin = Eigen::Index(place);
      const double value = lags[std::size_t(i) * std::size_t(side) + std::size_t(j)].real();
      sum[bin] += (double(bin) + 1 - place) * value;
      count[bin] += double(bin) + 1 - place;
      sum[bin + 1] += (place - double(bin)) * value;
      count[bin + 1] += place - double(bin);
    }
  return (count > 0).select(sum / count.max(1e-300), 0.0) / lags[0].real();
}

}  // namespace aberfit::internal
