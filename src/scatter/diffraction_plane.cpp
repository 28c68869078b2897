#include "diffraction_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/parallel.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;

const CartesianGrid& grid_of(const DiffractionPupil& pupil) {
  const auto* grid = std::get_if<CartesianGrid>(&pupil.sample.structure);
  if (!grid || pupil.cover.size() == 0 || grid->column.size() != std::size_t(pupil.cover.size()) ||
      pupil.amplitude.size() != pupil.cover.size())
    throw std::invalid_argument("a diffraction pupil needs the cells of a Cartesian grid");
  return *grid;
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
    for (Eigen::Index k = Eigen::Index(b) * kBlock; k < end; ++k)
      base_[k] = pupil.amplitude[k] * std::polar(1.0, phase * height[k]);
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

DiffractionPlane::DiffractionPlane(const DiffractionScene& scene, const PupilTransform& transform,
                                   PupilTransform::Buffers& buffers)
    : scene_(scene), transform_(transform), buffers_(buffers), otf_(scene.longest_lag()) {}

void DiffractionPlane::focus(double dz) {
  dz_ = dz;
  unit_ = scene_.per_period(dz);
  const CartesianGrid& grid = scene_.grid();
  const double chirp = scene_.chirp(dz);
  const auto axis = [chirp](const Eigen::ArrayXd& x) {
    Eigen::ArrayXcd phase(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) phase[i] = std::polar(1.0, chirp * x[i] * x[i]);
    return phase;
  };
  const Eigen::ArrayXcd along_columns = axis(grid.x), along_rows = axis(grid.y);
  std::complex<double>* focal = buffers_.focal.data();
  std::fill_n(focal, std::size_t(transform_.m_rows()) * transform_.stride(), 0.0);
  field_.resize(scene_.points());
  for (Eigen::Index k = 0; k < field_.size(); ++k) {
    const std::uint32_t row = grid.row[std::size_t(k)], column = grid.column[std::size_t(k)];
    field_[k] = scene_.base()[k] * (along_columns[column] * along_rows[row]);
    focal[std::size_t(row) * transform_.stride() + column] = field_[k];
  }
  transform_.to_focus(&buffers_);
  transform_.correlation(&buffers_);

  const double pitch_x = scene_.problem().pupil.pitch_x, pitch_y = scene_.problem().pupil.pitch_y;
  const double unit = scene_.finer_pitch(), ax = pitch_x / unit, ay = pitch_y / unit;
  const double samples = double(transform_.m_rows()) * double(transform_.m_columns());
  const double scale = 1.0 / (samples * scene_.total_cover());
  const double longest2 = scene_.longest_lag() * scene_.longest_lag();
  otf_.clear();
  along_x_.setZero(transform_.columns());
  along_y_.setZero(transform_.rows());
  for (int row = 0; row < transform_.rows(); ++row) {
    const std::complex<double>* up = half_row(row);
    const std::complex<double>* down = half_row(row > 0 ? transform_.m_rows() - row : 0);
    const double y2 = double(row) * row * ay * ay;
    along_y_[row] = std::conj(up[0]) * scale;
    for (int column = 0; column < transform_.columns(); ++column) {
      const double s2 = y2 + double(column) * column * ax * ax;
      if (s2 > longest2) break;  // no light at both ends
      const double sum = row > 0 ? up[column].real() + down[column].real() : up[column].real();
      otf_.add(std::sqrt(s2), column > 0 ? 2 * sum : sum);
    }
    if (row == 0)
      for (int column = 0; column < transform_.columns(); ++column)
        along_x_[column] = std::conj(up[column]) * scale;
  }
  otf_.scale(scale * ax * ay);
}

std::complex<double>* DiffractionPlane::half_row(int row) {
  return buffers_.scratch.data() + std::size_t(row) * transform_.half_stride();
}

std::optional<double> DiffractionPlane::radius(double fraction) const {
  const auto q = otf_.radius(fraction, scene_.largest_radius(dz_) * unit_);
  if (!q) return std::nullopt;
  return *q / unit_;
}

Eigen::ArrayXd DiffractionPlane::energy_gradient(double radius) {
  const Eigen::ArrayXd g =
      RadialOtf::energy_weights(radius * unit_, RadialOtf::nodes_for(scene_.longest_lag()));
  const double pitch_x = scene_.problem().pupil.pitch_x, pitch_y = scene_.problem().pupil.pitch_y;
  const double unit = scene_.finer_pitch(), ax = pitch_x / unit, ay = pitch_y / unit;
  const double samples = double(transform_.m_rows()) * double(transform_.m_columns());
  const double scale = ax * ay / (samples * scene_.total_cover());
  const double longest2 = scene_.longest_lag() * scene_.longest_lag();
  std::fill_n(half_row(0), std::size_t(transform_.m_rows()) * transform_.half_stride(), 0.0);
  for (int row = 0; row < transform_.rows(); ++row) {
    std::complex<double>* up = half_row(row);
    std::complex<double>* down = half_row(row > 0 ? transform_.m_rows() - row : 0);
    const double y2 = double(row) * row * ay * ay;
    for (int column = 0; column < transform_.columns(); ++column) {
      const double s2 = y2 + double(column) * column * ax * ax;
      if (s2 > longest2) break;
      up[column] = down[column] = scale * RadialOtf::interpolate(g, std::sqrt(s2));
    }
  }
  return pull_back();
}

Eigen::ArrayXd DiffractionPlane::axis_gradient(const Eigen::ArrayXcd& g_x, const Eigen::ArrayXcd& g_y) {
  const double samples = double(transform_.m_rows()) * double(transform_.m_columns());
  const double scale = 1.0 / (samples * scene_.total_cover());
  std::fill_n(half_row(0), std::size_t(transform_.m_rows()) * transform_.half_stride(), 0.0);
  // Re(g C) is half of g C plus its conjugate, which belongs to the opposite lag.
  half_row(0)[0] = scale * (g_x[0].real() + g_y[0].real());
  for (Eigen::Index m = 1; m < g_x.size(); ++m) half_row(0)[m] = 0.5 * scale * g_x[m];
  for (Eigen::Index m = 1; m < g_y.size(); ++m) {
    half_row(int(m))[0] = 0.5 * scale * g_y[m];
    half_row(transform_.m_rows() - int(m))[0] = 0.5 * scale * std::conj(g_y[m]);
  }
  return pull_back();
}

// With S = sum_X K |F|^2, F = sum_k E_k exp(...): dS/d phase_k = 2 Re(i E_k conj(V_k)).
Eigen::ArrayXd DiffractionPlane::pull_back() {
  transform_.kernel(&buffers_);
  transform_.back_to_pupil(&buffers_);
  const CartesianGrid& grid = scene_.grid();
  Eigen::ArrayXd d_phase(field_.size());
  for (Eigen::Index k = 0; k < field_.size(); ++k) {
    const std::complex<double> v =
        buffers_.scratch.data()[std::size_t(grid.row[std::size_t(k)]) * transform_.stride() +
                                grid.column[std::size_t(k)]];
    d_phase[k] = 2 * (field_[k].real() * v.imag() - field_[k].imag() * v.real());
  }
  return d_phase;
}

double DiffractionPlane::energy_slope(double radius, const Eigen::ArrayXd& energy_gradient) const {
  const PupilSample& sample = scene_.problem().pupil.sample;
  const double distance = scene_.problem().focal_length + dz_;
  const double turn = -kPi / (scene_.problem().wavelength * distance * distance);
  return turn * (energy_gradient * (sample.x.square() + sample.y.square())).sum() -
         density(radius) * radius / distance;
}

}  // namespace aberfit
