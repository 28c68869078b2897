#include "height_adjoint.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using Complex = std::complex<double>;

constexpr int kFewestCells = 64, kMostCells = 512;
constexpr int kTransferPerCell = 8, kBinsPerCell = 4;
constexpr double kCarried = 0.45;  // cycles a cell, of 0.5
constexpr int kCyclesOfEdge = 12;  // beyond what the phase asks for: diffraction at the aperture's edge
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

// 1 - cos theta at distance^2 r2 from the axis on the mirror.
double one_minus_cosine(double r2, double focal_length) {
  const double t2 = r2 / (4 * focal_length * focal_length);
  return 2 * t2 / (1 + t2);
}

// Distance of a place on a periodic grid from its origin [cells].
double distance(int i, int j, int side) { return std::hypot(std::min(i, side - i), std::min(j, side - j)); }

// exp(+...) in place of exp(-...), by conjugation before and after.
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
  // A frequency that shifts light by more than the width of the spot no longer interferes with it.
  const double cycles = 2 * steepest / kTwoPi * 2 * rim + kCyclesOfEdge;
  // Powers of two and three times them, which transform fast.
  int cells = kFewestCells;
  while (cells < 2 * cycles && cells < kMostCells) cells = cells % 3 == 0 ? cells / 3 * 4 : cells / 2 * 3;
  return cells;
}

AdjointGrid::AdjointGrid(const SpreadProblem& problem, int cells)
    : focal_length_(problem.mirror.focal_length),
      wavelength_(problem.wavelength),
      pupil_(diffraction_pupil(problem.aperture, problem.mirror.focal_length,
                               2 * aperture_radius(problem.aperture) / cells)),
      side_(2 * cells),
      transform_(side_, side_) {
  const auto& structure = std::get<DirectionGrid>(pupil_.sample.structure).cells;
  const Eigen::Index points = pupil_.sample.size();
  departure_.resize(points);
  for (Eigen::Index k = 0; k < points; ++k) {
    const double value = phase_of_departure(problem, pupil_.sample.x[k], pupil_.sample.y[k]);
    departure_[k] = std::isfinite(value) ? value : 0;  // centres of edge cells may lie beyond the sag
    place_.push_back(structure.row[std::size_t(k)] * std::size_t(side_) + structure.column[std::size_t(k)]);
  }
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
  const int bins = side_ * 3 / 4 * kBinsPerCell;  // the pupil's diagonal
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

Eigen::ArrayXd HeightAdjoint::power(double radius, double* share) const {
  const int side = grid_.side();
  const double scale = grid_.pitch() / (grid_.wavelength() * (grid_.focal_length() + dz_));  // 1/m a cell
  // What a lag of the field adds to the light in the disc: r J1(2 pi r nu)/nu times the mean transfer
  // function of the roughness.
  const int half = side / 2;
  Eigen::ArrayXd z(half + 1), j0(half + 1), j1(half + 1);
  ComplexGrid kernel(field_.size());
  for (int i = 0; i <= half; ++i) {
    for (int j = 0; j <= i; ++j) z[j] = kTwoPi * radius * scale * distance(i, j, side);
    bessel_j0_j1(z.data(), i + 1, j0.data(), j1.data());
    for (int j = 0; j <= i; ++j) {
      const double cells = distance(i, j, side);
      const double value = (cells == 0 ? kPi * radius * radius : radius * j1[j] / (scale * cells)) *
                           grid_.transfer(cells) * scale * scale / grid_.pupil().total;
      for (const int a : {i, (side - i) % side})
        for (const int b : {j, (side - j) % side}) {
          kernel[std::size_t(a) * std::size_t(side) + std::size_t(b)] = value;
          kernel[std::size_t(b) * std::size_t(side) + std::size_t(a)] = value;
        }
    }
  }
  grid_.transform()(kernel.data());
  for (std::size_t k = 0; k < kernel.size(); ++k) kernel[k] = kernel[k].real() * transform_[k];
  inverse(grid_.transform(), &kernel);
  // E = sum_k conj(U_k) V_k, V the field times the kernel; a height at k turns U_k by -4 pi q_k/lambda.
  ComplexGrid response(field_.size());
  double light = 0;
  for (Eigen::Index k = 0; k < grid_.pupil().sample.size(); ++k) {
    const Complex product = std::conj(field_[grid_.place(k)]) * kernel[grid_.place(k)];
    light += product.real();
    response[grid_.place(k)] =
        -2 * product.imag() * 4 * kPi / grid_.wavelength() * grid_.pupil().obliquity[k];
  }
  if (share) *share = light;
  // |transform|^2 averaged over direction is the transform of the autocorrelation averaged over direction.
  grid_.transform()(response.data());
  for (Complex& value : response) value = std::norm(value);
  inverse(grid_.transform(), &response);
  Eigen::VectorXd bins = Eigen::VectorXd::Zero(grid_.bessel().rows());
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double place = distance(i, j, side) * kBinsPerCell;
      const auto bin = Eigen::Index(place);
      if (bin + 1 >= bins.size()) continue;
      const double value = response[std::size_t(i) * std::size_t(side) + std::size_t(j)].real();
      bins[bin] += (double(bin) + 1 - place) * value;
      bins[bin + 1] += (place - double(bin)) * value;
    }
  return (grid_.bessel().transpose() * bins).array().max(0.0);
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
