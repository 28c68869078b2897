#include "surface_look.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "aberfit/core/constants.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/scene/segments.h"
#include "aberfit/trace/nominal_surface.h"

namespace aberfit::internal {
namespace {

const CartesianGrid& cells_of(const DiffractionPupil& pupil) {
  return std::get<CartesianGrid>(pupil.sample.structure);
}

Eigen::Index transform_size(const DiffractionPupil& pupil) {
  const CartesianGrid& cells = cells_of(pupil);
  return Eigen::Index(smooth_from(2 * std::max(cells.x.size(), cells.y.size())));
}

// The window is zero at the rim and at the rim of a hole, with a finite slope. Its side lobes fall as f^-5,
// faster than the PSD of a roughness.
Eigen::ArrayXd window_on(const PupilSample& sample, const Aperture& aperture) {
  const double radius = aperture_radius(aperture);
  const auto* annulus = std::get_if<AnnulusAperture>(&aperture);
  const double hole = annulus ? 0.5 * annulus->inner_diameter : 0;
  const Eigen::ArrayXd squared = (sample.x.square() + sample.y.square()).max(1e-12 * radius * radius);
  return (1 - squared / (radius * radius)).max(0) * (1 - hole * hole / squared).max(0);
}

// The fraction of the energy in the brightest hundredth of the pixels; the last pixel counts in part.
double share_of_brightest(std::vector<double>* light) {
  const double wanted = 0.01 * double(light->size());
  const auto whole = std::size_t(wanted);
  if (light->empty()) return std::nan("");
  std::nth_element(light->begin(), light->begin() + std::ptrdiff_t(whole), light->end(), std::greater<>());
  double all = 0, brightest = (wanted - double(whole)) * (*light)[whole];
  for (std::size_t i = 0; i < light->size(); ++i) {
    all += (*light)[i];
    if (i < whole) brightest += (*light)[i];
  }
  return brightest / all;
}

}  // namespace

SurfaceLook::SurfaceLook(const Task& task, Eigen::ArrayXd edges, double pitch, bool with_image)
    : pupil_(diffraction_pupil(without_segment_errors(task.aperture), kParaxial, pitch)),
      pitch_(pitch),
      phase_per_height_(4 * kPi / task.wavelength),
      with_image_(with_image),
      size_(transform_size(pupil_)),
      transform_(int(size_), int(size_)),
      window_(window_on(pupil_.sample, task.aperture)),
      departure_(departure_from_parabola(task.mirror, pupil_.sample)) {
  if (departure_.size() == 0) departure_ = Eigen::ArrayXd::Zero(pupil_.sample.size());
  find_steps(task.aperture);
  find_bins(edges);
  if (with_image_) find_rings();
}

void SurfaceLook::find_steps(const Aperture& aperture) {
  const PupilSample& sample = pupil_.sample;
  const CartesianGrid& cells = cells_of(pupil_);
  const double radius = aperture_radius(aperture);
  Eigen::ArrayXXi at = Eigen::ArrayXXi::Constant(cells.y.size() + 1, cells.x.size() + 1, -1);
  for (Eigen::Index k = 0; k < sample.size(); ++k)
    if (aperture_contains(aperture, sample.x[k], sample.y[k], 0))
      at(cells.row[std::size_t(k)], cells.column[std::size_t(k)]) = int(k);
  for (Eigen::Index k = 0; k < sample.size(); ++k) {
    const Eigen::Index row = cells.row[std::size_t(k)], column = cells.column[std::size_t(k)];
    if (at(row, column) < 0) continue;
    for (const bool along_x : {true, false}) {
      const int next = along_x ? at(row, column + 1) : at(row + 1, column);
      if (next < 0) continue;
      const double rho =
          std::hypot(sample.x[k] + sample.x[next], sample.y[k] + sample.y[next]) / (2 * radius);
      steps_.push_back({k, next, std::min(law::kSlopeZones - 1, int(rho * law::kSlopeZones)), along_x});
    }
  }
}

void SurfaceLook::find_bins(const Eigen::ArrayXd& edges) {
  bins_ = std::max<Eigen::Index>(0, edges.size() - 1);
  if (bins_ == 0) return;
  bin_of_.assign(std::size_t(size_ * size_), -1);
  const double step = 1 / (double(size_) * pitch_);
  for (Eigen::Index j = 0; j < size_; ++j)
    for (Eigen::Index k = 0; k < size_; ++k) {
      const double f = step * std::hypot(signed_index(j), signed_index(k));
      if (f < edges[0] || f >= edges[bins_]) continue;
      const auto above = std::upper_bound(edges.begin(), edges.end(), f);
      bin_of_[std::size_t(j * size_ + k)] = std::int16_t(above - edges.begin() - 1);
    }
}

void SurfaceLook::find_rings() {
  ring_of_.resize(std::size_t(size_ * size_));
  for (Eigen::Index j = 0; j < size_; ++j)
    for (Eigen::Index k = 0; k < size_; ++k)
      ring_of_[std::size_t(j * size_ + k)] = std::uint16_t(2 * std::hypot(signed_index(j), signed_index(k)));
}

HeightMap SurfaceLook::draw(const RadialPsd& psd, std::uint64_t seed) const {
  const CartesianGrid& cells = cells_of(pupil_);
  RandomSurfaceOptions options;
  options.seed = seed;
  HeightMap map =
      random_surface(psd, cells.y.size() + 2 * map_margin, cells.x.size() + 2 * map_margin, pitch_, options);
  map.x0 = cells.x[0] - double(map_margin) * pitch_;
  map.y0 = cells.y[0] - double(map_margin) * pitch_;
  return map;
}

Eigen::ArrayXd SurfaceLook::at_points(const HeightMap& map) const {
  const CartesianGrid& cells = cells_of(pupil_);
  Eigen::ArrayXd height(pupil_.sample.size());
  for (Eigen::Index k = 0; k < height.size(); ++k)
    height[k] = map.height(cells.row[std::size_t(k)] + map_margin, cells.column[std::size_t(k)] + map_margin);
  return height;
}

LookedAt SurfaceLook::operator()(Eigen::ArrayXd height) const {
  level(&height);
  LookedAt looked;
  looked.length_over_width = looked.bright_share = std::nan("");
  look_at_slopes(height, &looked);
  if (bins_ > 0) look_at_psd(height, &looked);
  if (with_image_) look_at_image(height, &looked);
  return looked;
}

// Removes piston and tilt by least squares over the grid cells.
void SurfaceLook::level(Eigen::ArrayXd* height) const {
  const PupilSample& sample = pupil_.sample;
  Eigen::MatrixXd shapes(sample.size(), 3);
  shapes.col(0).setOnes();
  shapes.col(1) = sample.x.matrix();
  shapes.col(2) = sample.y.matrix();
  const Eigen::MatrixXd weighted = (shapes.array().colwise() * pupil_.cover).matrix();
  const Eigen::VectorXd content = solve_symmetric(transposed_product(weighted, shapes),
                                                  Eigen::VectorXd(weighted.transpose() * height->matrix()));
  *height -= (shapes * content).array();
}

void SurfaceLook::look_at_slopes(const Eigen::ArrayXd& height, LookedAt* looked) const {
  double sum[law::kSlopeZones][2] = {}, count[law::kSlopeZones][2] = {};
  for (const Step& step : steps_) {
    sum[step.zone][step.along_x] += std::pow((height[step.to] - height[step.from]) / pitch_, 2);
    count[step.zone][step.along_x] += 1;
  }
  double all[2] = {}, cells[2] = {};
  for (int zone = 0; zone < law::kSlopeZones; ++zone)
    for (const int axis : {0, 1}) all[axis] += sum[zone][axis], cells[axis] += count[zone][axis];
  const double mean = all[0] / cells[0] + all[1] / cells[1];
  looked->slope_x_over_y = std::sqrt(all[1] / cells[1] / (all[0] / cells[0]));
  looked->zones = Eigen::ArrayXd::Constant(law::kSlopeZones, std::nan(""));
  for (int zone = 0; zone < law::kSlopeZones; ++zone)
    if (count[zone][0] > 0 && count[zone][1] > 0)
      looked->zones[zone] = std::sqrt((sum[zone][0] / count[zone][0] + sum[zone][1] / count[zone][1]) / mean);
}

Eigen::Index SurfaceLook::place(Eigen::Index point) const {
  const CartesianGrid& cells = cells_of(pupil_);
  return Eigen::Index(cells.row[std::size_t(point)]) * size_ + cells.column[std::size_t(point)];
}

void SurfaceLook::look_at_psd(const Eigen::ArrayXd& height, LookedAt* looked) const {
  std::vector<std::complex<double>> field(std::size_t(size_ * size_));
  for (Eigen::Index k = 0; k < height.size(); ++k) field[std::size_t(place(k))] = window_[k] * height[k];
  transform_(field.data());
  looked->psd = Eigen::ArrayXd::Zero(bins_);
  Eigen::ArrayXd count = Eigen::ArrayXd::Zero(bins_);
  for (std::size_t k = 0; k < field.size(); ++k) {
    if (bin_of_[k] < 0) continue;
    looked->psd[bin_of_[k]] += std::norm(field[k]);
    count[bin_of_[k]] += 1;
  }
  looked->psd *= pitch_ * pitch_ / window_.square().sum() / count;
}

// Pixels are half of lambda f/D about the axis, because an irradiance has no finer detail.
void SurfaceLook::look_at_image(const Eigen::ArrayXd& height, LookedAt* looked) const {
  std::vector<std::complex<double>> field(std::size_t(size_ * size_));
  for (Eigen::Index k = 0; k < height.size(); ++k)
    field[std::size_t(place(k))] =
        std::polar(pupil_.amplitude[k], phase_per_height_ * (height[k] + departure_[k]));
  transform_(field.data());
  std::vector<double> in_ring(std::size_t(2 * size_), 0.0);
  double total = 0;
  for (std::size_t k = 0; k < field.size(); ++k) {
    in_ring[ring_of_[k]] += std::norm(field[k]);
    total += std::norm(field[k]);
  }
  const auto ring_at = [&](double fraction) {
    std::size_t ring = 0;
    for (double sum = in_ring[0]; sum < fraction * total && ring + 1 < in_ring.size();)
      sum += in_ring[++ring];
    return ring;
  };
  const std::size_t inner = ring_at(0.35), outer = ring_at(0.9);
  std::vector<double> between;
  double light = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (Eigen::Index j = 0; j < size_; ++j)
    for (Eigen::Index k = 0; k < size_; ++k) {
      const std::size_t ring = ring_of_[std::size_t(j * size_ + k)];
      if (ring > outer) continue;
      const double one = std::norm(field[std::size_t(j * size_ + k)]), v = signed_index(j),
                   u = signed_index(k);
      if (ring >= inner) between.push_back(one);
      light += one, x += one * u, y += one * v;
      xx += one * u * u, xy += one * u * v, yy += one * v * v;
    }
  looked->bright_share = share_of_brightest(&between);
  x /= light, y /= light;
  xx = xx / light - x * x, xy = xy / light - x * y, yy = yy / light - y * y;
  const double middle = 0.5 * (xx + yy), apart = std::hypot(0.5 * (xx - yy), xy);
  looked->length_over_width = std::sqrt((middle + apart) / (middle - apart));
}

}  // namespace aberfit::internal
