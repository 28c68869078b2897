#include "diffraction_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

const CartesianGrid& grid_of(const DiffractionPupil& pupil) {
  const auto* grid = std::get_if<CartesianGrid>(&pupil.sample.structure);
  if (!grid || pupil.cover.size() == 0 || grid->column.size() != std::size_t(pupil.cover.size()) ||
      pupil.amplitude.size() != pupil.cover.size())
    throw std::invalid_argument("a diffraction pupil needs the cells of a Cartesian grid");
  return *grid;
}

// exp(i phase)
Eigen::ArrayXcd unit_phasors(const Eigen::ArrayXd& phase) {
  Eigen::ArrayXd sine(phase.size()), cosine(phase.size());
  sin_cos(phase.data(), int(phase.size()), sine.data(), cosine.data());
  Eigen::ArrayXcd result(phase.size());
  result.real() = cosine;
  result.imag() = sine;
  return result;
}

// Share of the light per unit of a sum over the focal plane.
double per_sample(const DiffractionScene& scene, const PupilTransform& transform) {
  return 1.0 / (double(transform.m_rows()) * double(transform.m_columns()) * scene.total_cover());
}

// Of one lag of a cell against one of the finer pitch.
double cell_area(const DiffractionScene& scene) {
  const double unit = scene.finer_pitch();
  return scene.problem().pupil.pitch_x / unit * (scene.problem().pupil.pitch_y / unit);
}

}  // namespace

DiffractionScene::DiffractionScene(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                   int threads)
    : problem_(problem), grid_(grid_of(problem.pupil)) {
  const DiffractionPupil& pupil = problem.pupil;
  if (height.size() != pupil.cover.size())
    throw std::invalid_argument("a diffraction pupil needs one height per cell");
  if (!height.allFinite()) throw std::invalid_argument("the heights of a diffraction pupil must be finite");
  if (!(problem.focal_length > 0) || !(problem.wavelength > 0) || !(pupil.pitch_x > 0) ||
      !(pupil.pitch_y > 0))
    throw std::invalid_argument("focal length, wavelength and pitch must be above zero");
  if (!(problem.padding >= 2)) throw std::invalid_argument("padding below 2 folds the transfer function");
  total_cover_ = pupil.cover.sum();
  base_.resize(height.size());
  const double phase = -4 * kPi / problem.wavelength;
  constexpr Eigen::Index kBlock = 8192;
  const auto blocks = std::size_t((height.size() + kBlock - 1) / kBlock);
  parallel_for(blocks, threads, [&](std::size_t b) {
    const Eigen::Index end = std::min(height.size(), Eigen::Index(b + 1) * kBlock);
    const Eigen::Index first = Eigen::Index(b) * kBlock, size = end - first;
    const auto amplitude = pupil.amplitude.segment(first, size);
    const Eigen::ArrayXcd turned = unit_phasors(phase * height.segment(first, size));
    base_.segment(first, size) = amplitude * turned;
  });
  const double cx = 0.5 * (grid_.x[0] + grid_.x[grid_.x.size() - 1]);
  const double cy = 0.5 * (grid_.y[0] + grid_.y[grid_.y.size() - 1]);
  const double furthest =
      std::sqrt(((pupil.sample.x - cx).square() + (pupil.sample.y - cy).square()).maxCoeff());
  const double diagonal = std::hypot((columns() - 1) * pupil.pitch_x, (rows() - 1) * pupil.pitch_y);
  longest_lag_ = std::min(diagonal, 2 * furthest) * (1 + 1e-12) / finer_pitch();
}

double DiffractionScene::chirp(double dz) const {
  const double f = problem_.focal_length;
  return -kPi / problem_.wavelength * dz / (f * (f + dz));
}

PhaseSteps DiffractionScene::phase_steps(const Eigen::ArrayXd& height, double dz_low, double dz_high) const {
  const std::size_t width = std::size_t(columns());
  std::vector<Eigen::Index> cell(width * std::size_t(rows()), -1);
  for (Eigen::Index k = 0; k < points(); ++k)
    cell[grid_.row[std::size_t(k)] * width + grid_.column[std::size_t(k)]] = k;
  const Eigen::ArrayXd &x = problem_.pupil.sample.x, &y = problem_.pupil.sample.y;
  const double per_height = -4 * kPi / problem_.wavelength, low = chirp(dz_low), high = chirp(dz_high);
  PhaseSteps steps;
  std::size_t pairs = 0, aliased = 0;
  const auto look = [&](Eigen::Index a, Eigen::Index b) {
    const double surface = per_height * (height[a] - height[b]);
    const double rho2 = x[a] * x[a] + y[a] * y[a] - x[b] * x[b] - y[b] * y[b];
    const double step = std::max(std::abs(surface + low * rho2), std::abs(surface + high * rho2));
    steps.largest = std::max(steps.largest, step);
    ++pairs;
    aliased += step > kPi;
  };
  for (std::size_t i = 0; i < cell.size(); ++i) {
    if (cell[i] < 0) continue;
    if (i % width + 1 < width && cell[i + 1] >= 0) look(cell[i], cell[i + 1]);
    if (i + width < cell.size() && cell[i + width] >= 0) look(cell[i], cell[i + width]);
  }
  if (pairs > 0) steps.aliased_share = double(aliased) / double(pairs);
  return steps;
}

DiffractionGrid::DiffractionGrid(const DiffractionScene& scene)
    : transform(scene.rows(), scene.columns(), scene.problem().padding),
      lags(scene.rows(), scene.columns(), scene.problem().pupil.pitch_x / scene.finer_pitch(),
           scene.problem().pupil.pitch_y / scene.finer_pitch(), scene.longest_lag()) {}

DiffractionPlane::DiffractionPlane(const DiffractionScene& scene, const DiffractionGrid& grid,
                                   PupilTransform::Buffers& buffers, FocusedField& focused)
    : scene_(scene), grid_(grid), buffers_(buffers), focused_(focused) {
  if (!std::isnan(focused.dz)) unit_ = scene.per_period(focused.dz);
}

void DiffractionPlane::focus(double dz) {
  if (focused_.dz == dz) return;
  focused_.dz = std::nan("");  // until all of it is there
  unit_ = scene_.per_period(dz);
  const PupilTransform& transform = grid_.transform;
  const CartesianGrid& grid = scene_.grid();
  const double chirp = scene_.chirp(dz);
  const Eigen::ArrayXcd along_columns = unit_phasors(chirp * grid.x.square());
  const Eigen::ArrayXcd along_rows = unit_phasors(chirp * grid.y.square());
  const std::size_t width = transform.pupil_stride();
  std::complex<double>* pupil = buffers_.pupil.data();
  std::fill_n(pupil, std::size_t(transform.rows()) * width, 0.0);
  focused_.field.resize(scene_.points());
  for (Eigen::Index k = 0; k < focused_.field.size(); ++k) {
    const std::uint32_t row = grid.row[std::size_t(k)], column = grid.column[std::size_t(k)];
    focused_.field[k] = scene_.base()[k] * (along_columns[column] * along_rows[row]);
    pupil[row * width + column] = focused_.field[k];
  }
  transform.to_focus(focused_.focal.data(), &buffers_);
  transform.correlation(focused_.focal.data(), &buffers_);

  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(grid_.lags.lengths());
  for (int row = 0; row < transform.rows(); ++row) {
    const double* even = buffers_.quarter.data() + std::size_t(row) * transform.quarter_stride();
    const std::uint32_t* length = grid_.lags.length_of(row);
    const int within = grid_.lags.columns_within(row);
    const double times = row > 0 ? 4 : 2;  // lags of this length and direction
    if (within > 0) sums[length[0]] += 0.5 * times * even[0];
    for (int column = 1; column < within; ++column) sums[length[column]] += times * even[column];
  }
  const double scale = per_sample(scene_, transform);
  focused_.otf = RadialOtf((scale * cell_area(scene_)) * grid_.lags.to_nodes(sums));
  focused_.along_x = scale * transform.correlation_along_x(buffers_);
  focused_.along_y = scale * transform.correlation_along_y(buffers_);
  focused_.dz = dz;
}

std::optional<double> DiffractionPlane::radius(double fraction) {
  const auto q = focused_.otf.radius(fraction, scene_.largest_radius(dz()) * unit_);
  if (!q) return std::nullopt;
  return *q / unit_;
}

Eigen::ArrayXd DiffractionPlane::energy_gradient(double radius) {
  const PupilTransform& transform = grid_.transform;
  const double scale = cell_area(scene_) * per_sample(scene_, transform);
  const Eigen::ArrayXd g =
      scale * grid_.lags.at_lengths(RadialOtf::energy_weights(radius * unit_, grid_.lags.nodes()));
  std::fill_n(buffers_.quarter.data(), transform.quarter_size(), 0.0);
  for (int row = 0; row < transform.rows(); ++row) {
    double* even = buffers_.quarter.data() + std::size_t(row) * transform.quarter_stride();
    const std::uint32_t* length = grid_.lags.length_of(row);
    const int within = grid_.lags.columns_within(row);
    for (int column = 0; column < within; ++column) even[column] = g[length[column]];
  }
  transform.kernel(&buffers_);
  transform.back_to_pupil(focused_.focal.data(), &buffers_);
  return pulled_back();
}

// Re(g C) is half of g C plus its conjugate, which belongs to the opposite lag: the kernel is the real part
// of the sum over lags from zero on.
Eigen::ArrayXd DiffractionPlane::axis_gradient(const Eigen::ArrayXcd& g_x, const Eigen::ArrayXcd& g_y) {
  const PupilTransform& transform = grid_.transform;
  const double scale = per_sample(scene_, transform);
  transform.back_to_pupil(focused_.focal.data(), transform.kernel_along_x(scale * g_x),
                          transform.kernel_along_y(scale * g_y), &buffers_);
  return pulled_back();
}

// With S = sum_X K |F|^2, F = sum_k E_k exp(...): dS/d phase_k = 2 Re(i E_k conj(V_k)).
Eigen::ArrayXd DiffractionPlane::pulled_back() const {
  const CartesianGrid& grid = scene_.grid();
  const Eigen::ArrayXcd& field = focused_.field;
  const std::size_t width = grid_.transform.pupil_stride();
  Eigen::ArrayXd d_phase(field.size());
  for (Eigen::Index k = 0; k < field.size(); ++k) {
    const std::complex<double> v =
        buffers_.pupil.data()[grid.row[std::size_t(k)] * width + grid.column[std::size_t(k)]];
    d_phase[k] = 2 * (field[k].real() * v.imag() - field[k].imag() * v.real());
  }
  return d_phase;
}

double DiffractionPlane::energy_slope(double radius, const Eigen::ArrayXd& energy_gradient) const {
  const PupilSample& sample = scene_.problem().pupil.sample;
  const double distance = scene_.problem().focal_length + dz();
  const double turn = -kPi / (scene_.problem().wavelength * distance * distance);
  return turn * (energy_gradient * (sample.x.square() + sample.y.square())).sum() -
         density(radius) * radius / distance;
}

}  // namespace aberfit::internal
