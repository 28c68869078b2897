#include "diffraction_plane.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

constexpr double kSameFocalLength = 1e-12;  // relative
// Ratio of focal samples to pupil cells. Below it correlations alias; above it only rounding changes.
constexpr double kExactPadding = 2;

const CartesianGrid& grid_of(const DiffractionPupil& pupil) {
  const auto* grid = std::get_if<CartesianGrid>(&pupil.sample.structure);
  if (const auto* directions = std::get_if<DirectionGrid>(&pupil.sample.structure)) grid = &directions->cells;
  if (!grid || pupil.cover.size() == 0 || grid->column.size() != std::size_t(pupil.cover.size()) ||
      pupil.amplitude.size() != pupil.cover.size() || pupil.obliquity.size() != pupil.cover.size())
    throw std::invalid_argument("a diffraction pupil needs the points of a Cartesian grid");
  return *grid;
}

// Energy fraction per unit of a sum over the focal plane.
double per_sample(const DiffractionScene& scene, const PupilTransform& transform) {
  return 1.0 / (double(transform.m_rows()) * double(transform.m_columns()) * scene.total());
}

// Area per lag, in units of the finer pitch squared.
double cell_area(const DiffractionScene& scene) {
  const double unit = scene.finer_pitch();
  return scene.problem().pupil.pitch_x / unit * (scene.problem().pupil.pitch_y / unit);
}

// The field of a base in the plane dz, at the pupil points and transformed.
void fill_focal(const DiffractionScene& scene, const Eigen::ArrayXcd& of, double dz,
                const PupilTransform& transform, PupilTransform::Buffers* buffers, FocusedField* focused) {
  double* pupil = buffers->pupil.data();
  std::fill_n(pupil, transform.pupil().size(), 0.0);
  const std::uint32_t* place = scene.places().data();
  focused->field.resize(scene.points());
  const double turn = scene.defocus(dz);
  // We use real arrays, because complex numbers pass through memory and are four times as slow.
  const double* base = reinterpret_cast<const double*>(of.data());
  double* field = reinterpret_cast<double*>(focused->field.data());
  constexpr int kBlock = 512;
  double phase[kBlock], sine[kBlock], cosine[kBlock];
  for (Eigen::Index first = 0; first < scene.points(); first += kBlock) {
    const int size = int(std::min<Eigen::Index>(kBlock, scene.points() - first));
    for (int i = 0; i < size; ++i) phase[i] = turn * scene.versine()[first + i];
    sin_cos(phase, size, sine, cosine);
    for (int i = 0; i < size; ++i) {
      const Eigen::Index k = first + i;
      const double re = base[2 * k] * cosine[i] - base[2 * k + 1] * sine[i];
      const double im = base[2 * k] * sine[i] + base[2 * k + 1] * cosine[i];
      field[2 * k] = re;
      field[2 * k + 1] = im;
      pupil[place[k]] += re;
      pupil[place[k] + kLines] += im;
    }
  }
  transform.to_focus(&focused->focal, buffers);
}

}  // namespace

Eigen::ArrayXcd unit_phasors(const Eigen::ArrayXd& phase) {
  Eigen::ArrayXd sine(phase.size()), cosine(phase.size());
  sin_cos(phase.data(), int(phase.size()), sine.data(), cosine.data());
  Eigen::ArrayXcd result(phase.size());
  result.real() = cosine;
  result.imag() = sine;
  return result;
}

DiffractionScene::DiffractionScene(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                   int threads)
    : problem_(problem), grid_(grid_of(problem.pupil)) {
  const DiffractionPupil& pupil = problem.pupil;
  if (height.size() != pupil.cover.size())
    throw std::invalid_argument("a diffraction pupil needs one height per grid point");
  if (!height.allFinite()) throw std::invalid_argument("the heights of a diffraction pupil must be finite");
  if (problem.scatter && problem.nominal &&
      (problem.nominal->size() != pupil.cover.size() || !problem.nominal->allFinite()))
    throw std::invalid_argument("a diffraction pupil needs one finite nominal height per grid point");
  if (!(problem.focal_length > 0) || !(problem.wavelength > 0) || !(pupil.pitch_x > 0) ||
      !(pupil.pitch_y > 0))
    throw std::invalid_argument("focal length, wavelength and pitch must be above zero");
  const auto* directions = std::get_if<DirectionGrid>(&pupil.sample.structure);
  if (directions && !(std::abs(directions->focal_length / problem.focal_length - 1) <= kSameFocalLength))
    throw std::invalid_argument("a diffraction pupil is valid only for the focal length it was made for");
  // 1 - cos theta = p^2/(1 + cos theta) = 2 t^2/(1 + t^2), and 1/(1 + t^2) is the obliquity.
  const double f = problem.focal_length;
  if (directions)
    versine_ = 2 * (1 - pupil.obliquity);
  else
    versine_ = (pupil.sample.x.square() + pupil.sample.y.square()) / (2 * f * f);
  per_height_ = (-4 * kPi / problem.wavelength) * pupil.obliquity;
  base_ = base_of(height, threads);
  const FieldLayout layout{rows(), columns()};
  places_.resize(grid_.column.size());
  for (std::size_t k = 0; k < places_.size(); ++k)
    places_[k] = std::uint32_t(layout.at(grid_.row[k], grid_.column[k]));
  const double cx = 0.5 * (grid_.x[0] + grid_.x[grid_.x.size() - 1]);
  const double cy = 0.5 * (grid_.y[0] + grid_.y[grid_.y.size() - 1]);
  double dx = 0, dy = 0;  // offset of the cell farthest from the centre
  for (std::size_t k = 0; k < grid_.column.size(); ++k) {
    const double x = grid_.x[grid_.column[k]] - cx, y = grid_.y[grid_.row[k]] - cy;
    if (x * x + y * y > dx * dx + dy * dy) {
      dx = x;
      dy = y;
    }
  }
  const double furthest = std::hypot(dx, dy);
  const double diagonal = std::hypot((columns() - 1) * pupil.pitch_x, (rows() - 1) * pupil.pitch_y);
  longest_lag_ = std::min(diagonal, 2 * furthest) * (1 + 1e-12) / finer_pitch();
}

Eigen::ArrayXcd DiffractionScene::base_of(const Eigen::ArrayXd& height, int threads) const {
  Eigen::ArrayXcd base(height.size());
  constexpr Eigen::Index kBlock = 8192;
  const auto blocks = std::size_t((height.size() + kBlock - 1) / kBlock);
  parallel_for(blocks, threads, [&](std::size_t b) {
    const Eigen::Index end = std::min(height.size(), Eigen::Index(b + 1) * kBlock);
    const Eigen::Index first = Eigen::Index(b) * kBlock, size = end - first;
    const auto amplitude = problem_.pupil.amplitude.segment(first, size);
    const Eigen::ArrayXcd turned =
        unit_phasors(per_height_.segment(first, size) * height.segment(first, size));
    base.segment(first, size) = amplitude * turned;
  });
  return base;
}

Eigen::ArrayXcd DiffractionScene::nominal_base() const {
  if (problem_.nominal) return base_of(*problem_.nominal, 1);
  return problem_.pupil.amplitude.cast<std::complex<double>>();
}

// The transfer function summed over all lags, which is the square of a sum.
double DiffractionScene::perfect_irradiance() const {
  const double sum = problem_.pupil.amplitude.sum();
  return sum * sum / total() * cell_area(*this);
}

double DiffractionScene::defocus(double dz) const {
  const double f = problem_.focal_length;
  return -2 * kPi / problem_.wavelength * dz * f / (f + dz);
}
double DiffractionScene::defocus_slope(double dz) const {
  const double stretch = problem_.focal_length / (problem_.focal_length + dz);
  return -2 * kPi / problem_.wavelength * stretch * stretch;
}

PhaseSteps DiffractionScene::phase_steps(const Eigen::ArrayXd& height, double dz_low, double dz_high) const {
  const std::size_t width = std::size_t(columns());
  std::vector<Eigen::Index> cell(width * std::size_t(rows()), -1);
  for (Eigen::Index k = 0; k < points(); ++k)
    cell[grid_.row[std::size_t(k)] * width + grid_.column[std::size_t(k)]] = k;
  const Eigen::ArrayXd turned = per_height() * height;
  const double low = defocus(dz_low), high = defocus(dz_high);
  PhaseSteps steps;
  std::size_t pairs = 0, aliased = 0;
  const std::vector<std::uint32_t>& segment = problem_.pupil.sample.segment;
  const auto look = [&](Eigen::Index a, Eigen::Index b) {
    // A step between two segments is not a slope of either.
    if (!segment.empty() && segment[std::size_t(a)] != segment[std::size_t(b)]) return;
    const double surface = turned[a] - turned[b], versine = versine_[a] - versine_[b];
    const double step = std::max(std::abs(surface + low * versine), std::abs(surface + high * versine));
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

DiffractionGrid::DiffractionGrid(const DiffractionScene& scene, Precision precision)
    : transform(scene.rows(), scene.columns(), kExactPadding, precision) {
  const double step_x = scene.problem().pupil.pitch_x / scene.finer_pitch(),
               step_y = scene.problem().pupil.pitch_y / scene.finer_pitch();
  lags = LagTable(transform.lag_rows(), transform.lag_columns(), step_x, step_y, scene.longest_lag());
  if (scene.problem().scatter) set_scatter(scene);
}

void DiffractionGrid::set_scatter(const DiffractionScene& scene) {
  const DiffractionProblem& problem = scene.problem();
  const MeanScatter& scatter = *problem.scatter;
  const auto shears = [](Eigen::Index count, double step) -> Eigen::ArrayXd {
    return Eigen::ArrayXd::LinSpaced(count, 0.0, double(count - 1)) * step;
  };
  const Eigen::ArrayXd nodes = shears(lags.nodes(), scene.finer_pitch() / LagTable::kNodesPerLag);
  factor = lags.at_lengths(scatter.transfer(nodes));
  whole_ = lags.at_lengths(scatter.whole_transfer(nodes));
  along_x = scatter.transfer(shears(transform.lag_columns() + 1, problem.pupil.pitch_x));
  along_y = scatter.transfer(shears(transform.lag_rows() + 1, problem.pupil.pitch_y));
  perfect = scene.nominal_base();
}

const Eigen::ArrayXd& DiffractionGrid::mean_at(const DiffractionScene& scene, double dz,
                                               PupilTransform::Buffers* buffers,
                                               FocusedField* scratch) const {
  {
    const std::lock_guard lock(mutex_);
    if (const auto at = means_.find(dz); at != means_.end()) return at->second;
  }
  fill_focal(scene, perfect, dz, transform, buffers, scratch);
  Eigen::ArrayXd mean = lags.to_nodes(lag_sums(scene, *this, scratch->focal, buffers) * whole_);
  const std::lock_guard lock(mutex_);
  return means_.emplace(dz, std::move(mean)).first->second;
}

Eigen::ArrayXd lag_sums(const DiffractionScene& scene, const DiffractionGrid& grid, const AlignedArray& focal,
                        PupilTransform::Buffers* buffers) {
  const PupilTransform& transform = grid.transform;
  transform.correlation(focal, buffers);
  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(grid.lags.lengths());
  for (int row = 0; row < transform.lag_rows(); ++row) {
    const double* even = buffers->quarter.data() + std::size_t(row) * transform.quarter_stride();
    const std::uint32_t* length = grid.lags.length_of(row);
    const int within = grid.lags.columns_within(row);
    const double times = row > 0 ? 4 : 2;  // number of lags of this length and direction
    if (within > 0) sums[length[0]] += 0.5 * times * even[0];
    for (int column = 1; column < within; ++column) sums[length[column]] += times * even[column];
  }
  return per_sample(scene, transform) * cell_area(scene) * sums;
}

DiffractionPlane::DiffractionPlane(const DiffractionScene& scene, const DiffractionGrid& grid,
                                   PupilTransform::Buffers& buffers, FocusedField& focused)
    : scene_(scene), grid_(grid), buffers_(buffers), focused_(focused) {
  if (!std::isnan(focused.dz)) unit_ = scene.per_period(focused.dz);
}

// Energy beyond the field of view returns from the opposite side, both for the surface and for the mean spot
// that is subtracted. If the mean spot beyond it is that of the focus, the two focal ones serve as well.
bool DiffractionGrid::has_own_mean(const DiffractionScene& scene, double dz) const {
  constexpr double kSame = 1e-6;
  const MeanScatter* scatter = scene.problem().scatter.get();
  if (!scatter || dz == 0) return false;
  {
    const std::lock_guard lock(mutex_);
    if (const auto at = own_.find(dz); at != own_.end()) return at->second;
  }
  const double end = scene.field_radius(dz), grown = scene.per_period(dz) / scene.per_period(0);
  bool own = false;
  for (const double radius : {end, 1.5 * end, 2 * end, 4 * end}) {
    if (own) break;
    const std::optional<MeanScatter::Encircled> there = scatter->in_plane(radius, dz);
    own = (there && std::abs(there->energy - scatter->encircled_energy(radius * grown)) > kSame);
  }
  const std::lock_guard lock(mutex_);
  return own_[dz] = own;
}

void DiffractionPlane::focus(double dz, Mean mean) {
  const bool own_mean = mean == Mean::kInPlane && grid_.has_own_mean(scene_, dz);
  if (focused_.dz == dz && focused_.own_mean == own_mean) return;
  focused_.dz = std::nan("");  // invalid until the plane is complete
  unit_ = scene_.per_period(dz);
  const MeanScatter* scatter = scene_.problem().scatter.get();
  const double of_mean = own_mean ? dz : 0;
  const Eigen::ArrayXd* light = scatter ? &grid_.mean_at(scene_, of_mean, &buffers_, &focused_) : nullptr;
  fill_focal(scene_, scene_.base(), dz, grid_.transform, &buffers_, &focused_);
  Eigen::ArrayXd sums = lag_sums(scene_, grid_, focused_.focal, &buffers_);
  if (scatter) {
    sums *= grid_.factor;
    focused_.otf = RadialOtf(grid_.lags.to_nodes(sums) - *light,
                             {scatter, 1 / scene_.per_period(of_mean), scene_.field_radius(dz) * unit_,
                              own_mean ? std::optional(dz) : std::nullopt});
  } else {
    focused_.otf = RadialOtf(grid_.lags.to_nodes(sums));
  }
  focused_.along_x.resize(0);
  focused_.along_y.resize(0);
  focused_.own_mean = own_mean;
  focused_.dz = dz;
}

DiffractionPlane::InCircle DiffractionPlane::light_of_own_mean(double radius, double dz) {
  const MeanScatter* scatter = scene_.problem().scatter.get();
  if (!grid_.has_own_mean(scene_, dz)) return {0, 0};
  focused_.dz = std::nan("");  // means use the same memory
  const double unit = scene_.per_period(dz), end = scene_.field_radius(dz) * unit;
  const auto beyond_the_cells = [&](double of, std::optional<double> plane) {
    const Eigen::ArrayXd& light = grid_.mean_at(scene_, of, &buffers_, &focused_);
    return RadialOtf(-light, {scatter, 1 / scene_.per_period(of), end, plane}).encircled(radius * unit);
  };
  const auto own = beyond_the_cells(dz, dz), of_focus = beyond_the_cells(0, std::nullopt);
  return {own.energy - of_focus.energy, (own.density - of_focus.density) * unit};
}

void DiffractionPlane::correlate_along_axes() {
  if (focused_.along_x.size() > 0) return;
  const double scale = per_sample(scene_, grid_.transform);
  grid_.transform.axis_correlations(focused_.focal, &focused_.along_x, &focused_.along_y);
  focused_.along_x *= scale;
  focused_.along_y *= scale;
  if (!scene_.problem().scatter) return;
  focused_.along_x *= grid_.along_x.head(focused_.along_x.size());
  focused_.along_y *= grid_.along_y.head(focused_.along_y.size());
}

std::optional<double> DiffractionPlane::radius(double fraction) {
  const auto q = focused_.otf.radius(fraction, scene_.largest_radius(dz()) * unit_);
  if (!q) return std::nullopt;
  return *q / unit_;
}

void DiffractionPlane::build_kernel(const Eigen::ArrayXd& weights, AlignedArray* kernel) {
  const PupilTransform& transform = grid_.transform;
  const double scale = cell_area(scene_) * per_sample(scene_, transform);
  Eigen::ArrayXd g = scale * grid_.lags.at_lengths(weights);
  if (grid_.factor.size() > 0) g *= grid_.factor;
  std::fill_n(buffers_.quarter.data(), transform.quarter_size(), 0.0);
  for (int row = 0; row < transform.lag_rows(); ++row) {
    double* even = buffers_.quarter.data() + std::size_t(row) * transform.quarter_stride();
    const std::uint32_t* length = grid_.lags.length_of(row);
    const int within = grid_.lags.columns_within(row);
    for (int column = 0; column < within; ++column) even[column] = g[length[column]];
  }
  transform.kernel(kernel, &buffers_);
}

DiffractionPlane::Gradient DiffractionPlane::energy_gradient(double radius, bool remember) {
  const PupilTransform& transform = grid_.transform;
  const double q = std::min(radius, scene_.field_radius(dz())) * unit_;
  const auto build = [&](AlignedArray* k) {
    build_kernel(RadialOtf::energy_weights(q, grid_.lags.nodes()), k);
  };
  const AlignedArray* kernel = remember ? grid_.kernels.find(q, transform, build) : nullptr;
  if (!kernel) {
    build(&buffers_.kernel);
    kernel = &buffers_.kernel;
  }
  transform.back_to_pupil(focused_.focal, *kernel, &buffers_);
  return Gradient(*this);
}

DiffractionPlane::Gradient DiffractionPlane::sum_gradient(const Eigen::ArrayXd& weights) {
  build_kernel(weights, &buffers_.kernel);
  grid_.transform.back_to_pupil(focused_.focal, buffers_.kernel, &buffers_);
  return Gradient(*this);
}

// Re(g C) is half of g C plus its conjugate, which belongs to the opposite lag. So the kernel is the real
// part of the sum over lags >= 0.
DiffractionPlane::Gradient DiffractionPlane::axis_gradient(const Eigen::ArrayXcd& g_x,
                                                           const Eigen::ArrayXcd& g_y) {
  const PupilTransform& transform = grid_.transform;
  const double scale = per_sample(scene_, transform);
  Eigen::ArrayXcd along_x = scale * g_x, along_y = scale * g_y;
  if (scene_.problem().scatter) {
    along_x *= grid_.along_x.head(along_x.size());
    along_y *= grid_.along_y.head(along_y.size());
  }
  transform.back_to_pupil(focused_.focal, transform.kernel_along_x(along_x),
                          transform.kernel_along_y(along_y), &buffers_);
  return Gradient(*this);
}

// With S = sum_X K |F|^2 and F = sum_k E_k exp(...): dS/d phase_k = 2 Re(i E_k conj(V_k)).
double DiffractionPlane::Gradient::over_phase(Eigen::Index k) const {
  const std::complex<double> field = plane_.focused_.field[k];
  const double* v = plane_.buffers_.back.data() + plane_.scene_.places()[std::size_t(k)];
  return 2 * (field.real() * v[kLines] - field.imag() * v[0]);
}

Eigen::ArrayXd DiffractionPlane::Gradient::over_phases() const {
  Eigen::ArrayXd result(plane_.scene_.points());
  for (Eigen::Index k = 0; k < result.size(); ++k) result[k] = over_phase(k);
  return result;
}

Eigen::ArrayXd DiffractionPlane::Gradient::over_heights(double factor) const {
  const Eigen::ArrayXd& per_height = plane_.scene_.per_height();
  Eigen::ArrayXd result(plane_.scene_.points());
  for (Eigen::Index k = 0; k < result.size(); ++k) result[k] = factor * per_height[k] * over_phase(k);
  return result;
}

double DiffractionPlane::energy_slope(double radius, const Eigen::ArrayXd& over_phases) const {
  return scene_.defocus_slope(dz()) * (over_phases * scene_.versine()).sum() -
         density(radius) * radius / (scene_.problem().focal_length + dz());
}

}  // namespace aberfit::internal
