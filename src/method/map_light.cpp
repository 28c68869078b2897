#include "aberfit/method/map_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/constants.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/spectrum/surface_psd.h"
#include "aberfit/trace/nominal_surface.h"
#include "aberfit/waves/diffraction_peak.h"

namespace aberfit {

namespace {

std::string length_words(double x) { return format_quantity(x, Dimension::kLength); }

MapPanel panel_of(HeightMap map) {
  MapPanel panel{std::move(map)};
  double sum = 0, squares = 0, low = kInfinity, high = -kInfinity;
  const double count = double(valid_count(panel.map));
  const auto each = [&](const auto& use) {
    for (const double h : panel.map.height.reshaped())
      if (std::isfinite(h)) use(h);
  };
  each([&](double h) { sum += h, low = std::min(low, h), high = std::max(high, h); });
  each([&](double h) { squares += std::pow(h - sum / count, 2); });
  panel.rms = std::sqrt(squares / count);
  panel.peak_to_valley = high - low;
  const SurfaceRms slopes = surface_rms(panel.map, {DetrendShape::kNone});
  panel.rms_slope_x = slopes.slope_x, panel.rms_slope_y = slopes.slope_y;
  return panel;
}

// First grid cell of an axis and number of cells that cover [low, high].
std::pair<Eigen::Index, Eigen::Index> covering(double first, double pitch, double low, double high) {
  const auto begin = Eigen::Index(std::floor((low - first) / pitch + 0.5 + 1e-9));
  const auto last = Eigen::Index(std::ceil((high - first) / pitch - 0.5 - 1e-9));
  return {begin, std::max<Eigen::Index>(1, last - begin + 1)};
}

// The map's points that cover the aperture, without values.
HeightMap points_over(const HeightMap& map, const Aperture& aperture) {
  const ApertureBox box = bounding_box(aperture);
  const auto [column, columns] = covering(map.x0, map.pitch_x, box.x0, box.x1);
  const auto [row, rows] = covering(map.y0, map.pitch_y, box.y0, box.y1);
  HeightMap over = map;
  over.x0 = map.x(column), over.y0 = map.y(row);
  over.height = Grid::Constant(rows, columns, kNaN);
  return over;
}

struct MapShift {
  MapShift(const HeightMap& from, const HeightMap& to)
      : row(std::lround((from.y0 - to.y0) / to.pitch_y)),
        column(std::lround((from.x0 - to.x0) / to.pitch_x)) {}
  Eigen::Index row, column;
};

bool is_mirror(const HeightMap& map, const Aperture& aperture, Eigen::Index row, Eigen::Index column) {
  return aperture_holds(aperture, map.x(column), map.y(row));
}

/// The mean scatter of a PSD without heights, by paraxial generalised Harvey-Shack. Without a mean spot,
/// encircled energies are plain sums over the lags of the pupil's cells, in the field of view of the map.
class ResidualScatter : public MeanScatter {
 public:
  ResidualScatter(const RadialPsd& psd, double wavelength)
      : psd_(psd), per_height_(4 * kPi / wavelength), moments_(psd_moments(psd)) {}

  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override {
    return (-per_height_ * per_height_ * structure_function(psd_, shear)).exp();
  }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override {
    return Eigen::ArrayXd::Zero(shear.size());
  }
  double encircled_energy(double) const override { return 0; }
  double encircled_energy_slope(double) const override { return 0; }
  double irradiance() const override { return 0; }
  double image_transfer(double) const override { return 0; }
  double rms_height() const override { return moments_.rms_height(); }
  double rms_slope_per_axis() const override { return moments_.rms_slope_per_axis(); }
  double scatter_rms() const override { return 2 * std::sqrt(2.0) * rms_slope_per_axis(); }
  double tis() const { return -std::expm1(-per_height_ * per_height_ * moments_.height_variance); }

 private:
  RadialPsd psd_;
  double per_height_;  // phase over height [rad/m]
  PsdMoments moments_;
};

int highest_degree(const TermSet& terms) {
  int degree = 1;  // piston and tilt are always fitted
  for (const ZernikeMode& mode : terms.zernike) degree = std::max(degree, mode.n);
  for (const int power : terms.spherical) degree = std::max(degree, power);
  return degree;
}

// The residual's PSD as a table. Throws std::invalid_argument where no PSD can be estimated.
TablePsd residual_table(const HeightMap& residual, const TermSet& terms, int threads) {
  PsdEstimatorOptions options;
  options.detrend.degree = 0;  // the shape is already removed
  options.find_lines = false;  // lines scatter, too
  const PsdEstimate estimate = estimate_psd(residual, options, threads);
  PsdFitOptions whole;
  whole.f_max = estimate.nyquist;  // includes what the instrument damps; the map has nothing beyond
  const SurfacePsd surface = surface_psd(estimate, fit_psd_model(estimate, whole));
  if (surface.psd.size() == 0)
    throw std::invalid_argument("every bin of its PSD shows the estimator, not the surface");
  TablePsd table;
  const auto add = [&](double f, double s) {
    if (!table.frequency.empty() && !(f > table.frequency.back())) return;
    table.frequency.push_back(f);
    table.psd.push_back(s);
  };
  // The PSD is constant within a bin, so that its variance equals that of the bin.
  const Eigen::Index bins = surface.psd.size();
  add(std::min(surface.low[0], zernike_cutoff(highest_degree(terms), terms.radius)), surface.psd[0]);
  for (Eigen::Index b = 0; b < bins; ++b) {
    add(surface.low[b] * (1 + 1e-9), surface.psd[b]);
    add(surface.high[b] * (1 - 1e-9), surface.psd[b]);
  }
  add(1 / std::sqrt(kPi * residual.pitch_x * residual.pitch_y), surface.psd[bins - 1]);
  return table;
}

// Null, with a reason, where there is no PSD or it scatters nothing.
std::shared_ptr<const ResidualScatter> scatter_of(const Task& task, const MapPanel& residual,
                                                  const TermSet& terms, int threads, ResidualPsd* rest) {
  if (4 * kPi * residual.rms / task.wavelength < law::kSmoothG) return nullptr;
  try {
    const RadialPsd psd{PsdModel(residual_table(residual.map, terms, threads))};
    auto scatter = std::make_shared<const ResidualScatter>(psd, task.wavelength);
    rest->f_min = psd.f_min(), rest->f_max = psd.f_max();
    rest->rms_height = scatter->rms_height();
    rest->tis = scatter->tis();
    return scatter;
  } catch (const std::invalid_argument& error) {
    rest->obstacle = error.what();
  }
  return nullptr;
}

struct MapPupil {
  DiffractionPupil pupil;
  Eigen::ArrayXd measured, terms, departure;  // departure: of the nominal mirror from a parabola
  double filled = 0;
};

MapPupil map_pupil(const Task& task, const MapPanel& measured, const TermSet& terms,
                   const Eigen::VectorXd& coefficients, int threads) {
  MapPupil all;
  HeightMap flat = measured.map;
  flat.height.setZero();
  Eigen::ArrayXd zero;
  all.pupil = diffraction_pupil(flat, task.aperture, &zero);
  const PupilSample& sample = all.pupil.sample;
  SurfaceField field;
  SurfaceOperator(terms, sample, focus_operator(FocusModel::kWaves, threads)).apply(coefficients, &field);
  all.terms = all.measured = field.height;
  const CartesianGrid& grid = std::get<CartesianGrid>(sample.structure);
  double inside = 0, filled = 0;
  for (Eigen::Index k = 0; k < sample.size(); ++k) {
    const Eigen::Index row = grid.row[std::size_t(k)], column = grid.column[std::size_t(k)];
    const double height = measured.map.height(row, column);
    if (std::isfinite(height)) all.measured[k] = height;
    if (!is_mirror(flat, task.aperture, row, column)) continue;  // an edge cell whose centre is outside
    inside += all.pupil.cover[k];
    if (!std::isfinite(height)) filled += all.pupil.cover[k];
  }
  all.filled = inside > 0 ? filled / inside : 0;
  all.departure = departure_from_parabola(task.mirror, sample);
  if (all.departure.size() == 0) all.departure = zero;
  return all;
}

class MapLamp {
 public:
  MapLamp(const Task& task, const MapPupil& of, int threads)
      : of_(of),
        problem_{of.pupil, task.mirror.focal_length, task.wavelength},
        airy_(task.wavelength * task.mirror.focal_length / (2 * aperture_radius(task.aperture))),
        square_(std::abs(of.pupil.pitch_x - of.pupil.pitch_y) <= 1e-9 * of.pupil.pitch_x),
        threads_(threads) {
    if (!square_) return;
    const PsfWindow middle{0.25 * airy_, 0.25 * airy_, 0};
    brightest_ =
        diffraction_psf(problem_, Eigen::ArrayXd::Zero(of.departure.size()), middle).intensity.maxCoeff();
  }

  double field_radius() const {
    return 0.5 * problem_.wavelength * problem_.focal_length / std::max(of_.pupil.pitch_x, of_.pupil.pitch_y);
  }
  double airy() const { return airy_; }
  bool square() const { return square_; }
  void scatter_by(std::shared_ptr<const MeanScatter> scatter) { problem_.scatter = std::move(scatter); }

  LitSurface numbers(const Eigen::ArrayXd& error, double* ring_fwhm = nullptr) {
    const Eigen::ArrayXd height = error + of_.departure;
    std::vector<Statistic> wanted = {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 0},
                                     EncircledEnergyRadius{0.9, 0}, SpotFwhm{0}};
    if (ring_fwhm) wanted.push_back(RingFwhm{});
    LitSurface lit;
    Eigen::VectorXd values;
    evaluate_diffraction(problem_, height, wanted, threads_, &workspace_, &values, nullptr);
    lit.ee50 = values[0], lit.ee80 = values[1], lit.ee90 = values[2], lit.spot_fwhm = values[3];
    if (ring_fwhm) *ring_fwhm = values[4];
    const DiffractionCheck check = check_diffraction(problem_, height, 0);
    for (const Warning& warning : check.warnings)
      if (warning.code == "psf-aliased" || warning.code == "psf-not-finite") lit.obstacle = warning.message;
    return lit;
  }
  void draw(const Eigen::ArrayXd& error, const Eigen::ArrayXd& radius, double half, LitSurface* lit) const {
    if (!lit->obstacle.empty()) return;
    const Eigen::ArrayXd height = error + of_.departure;
    lit->share = diffraction_encircled_energy(problem_, height, 0, radius);
    lit->strehl = diffraction_peak(problem_, height).strehl;
    if (!square_) return;
    lit->psf = diffraction_psf(problem_, height, {half, half / 160, 0});
    lit->psf.intensity /= brightest_;
  }

 private:
  const MapPupil& of_;
  DiffractionProblem problem_;
  double airy_ = 0;  // wavelength f/D [m]
  bool square_ = true;
  int threads_ = 1;
  double brightest_ = 0;  // peak of the pupil with zero height [1/m^2]
  DiffractionWorkspace workspace_;
};

double largest_ee90(const MapLight& light, double otherwise) {
  double largest = 0;
  for (const LitSurface* lit : light.columns())
    if (lit->obstacle.empty()) largest = std::max(largest, std::isfinite(lit->ee90) ? lit->ee90 : otherwise);
  return largest > 0 ? largest : otherwise;
}

void warn_of_map_light(const Task& task, const MapPanel& residual, MapLight* light) {
  if (light->filled_share > law::kNoteworthy)
    light->warnings.push_back(
        {"map-filled",
         fmt::format("{} of the aperture has no measured height. There the heights of the terms are used, "
                     "which are extrapolated at the rim. Give the aperture the size of the measured part",
                     format_quantity(light->filled_share, Dimension::kFraction))});
  const ResidualPsd& rest = light->rest;
  if (!(rest.rms_height > 0)) return;
  const double ratio = rest.rms_height / residual.rms;
  const double left = 1 - std::exp(-std::pow(4 * kPi * residual.rms / task.wavelength, 2));
  if (std::max(ratio, 1 / ratio) > law::kNoticedRatio && std::abs(left - rest.tis) > task.equivalence.margin)
    light->warnings.push_back(
        {"residual-psd-rms",
         fmt::format("the residual of the map has {} RMS, but its PSD only {}. It is not uniform over the "
                     "aperture (a turned-down rim, for example), so one PSD does not describe its scatter. "
                     "Take more terms (`terms.zernike.n_max`) or a smaller aperture",
                     length_words(residual.rms), length_words(rest.rms_height))});
}

}  // namespace

MapPanels map_panels(const HeightMap& map, const Aperture& aperture, const TermSet& terms,
                     const MapFitResult& fit, int threads) {
  HeightMap measured = points_over(map, aperture);
  const MapShift shift(measured, map);
  std::vector<Eigen::Index> valid;
  for (Eigen::Index row = 0; row < measured.rows(); ++row) {
    for (Eigen::Index column = 0; column < measured.columns(); ++column) {
      const Eigen::Index from_row = row + shift.row, from_column = column + shift.column;
      if (from_row < 0 || from_row >= map.rows() || from_column < 0 || from_column >= map.columns()) continue;
      const double height = map.height(from_row, from_column);
      if (!std::isfinite(height) || !is_mirror(measured, aperture, row, column)) continue;
      measured.height(row, column) = height - fit.mount(measured.x(column), measured.y(row));
      valid.push_back(row * measured.columns() + column);
    }
  }
  Eigen::ArrayXd x(Eigen::Index(valid.size())), y(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    x[k] = measured.x(valid[std::size_t(k)] % measured.columns());
    y[k] = measured.y(valid[std::size_t(k)] / measured.columns());
  }
  SurfaceField field;
  SurfaceOperator(terms, x, y, threads).apply(fit.coefficients, &field);
  HeightMap fitted = measured, residual = measured;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    fitted.height.data()[valid[std::size_t(k)]] = field.height[k];
    residual.height.data()[valid[std::size_t(k)]] -= field.height[k];
  }
  return {panel_of(std::move(measured)), panel_of(std::move(fitted)), panel_of(std::move(residual))};
}

MapLight map_light(const Task& task, const MapPanels& panels, const TermSet& terms, const MapFitResult& fit,
                   bool with_ring, int threads) {
  const MapPupil of = map_pupil(task, panels.measured, terms, fit.coefficients, threads);
  const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(of.terms.size());
  MapLight light;
  light.filled_share = of.filled;
  light.cells = of.terms.size();
  const auto scatter = scatter_of(task, panels.residual, terms, threads, &light.rest);
  MapLamp lamp(task, of, threads), rough(task, of, threads);
  rough.scatter_by(scatter);
  light.measured = lamp.numbers(of.measured);
  light.terms = lamp.numbers(of.terms, with_ring ? &light.ring_fwhm : nullptr);
  light.perfect = lamp.numbers(none);
  if (!light.rest.obstacle.empty())
    light.terms_and_rest.obstacle = light.rest.obstacle;
  else
    light.terms_and_rest = scatter ? rough.numbers(of.terms) : light.terms;

  const double field = lamp.field_radius(), ee90 = largest_ee90(light, field);
  // A picture shows a fifth more than the largest ee90, between 6 and 40 lambda f/D to either side. It has
  // 321 samples, at most a quarter of a grain apart.
  light.radius = Eigen::ArrayXd::LinSpaced(301, 0.0, std::min(1.2 * ee90, field));
  const double half = std::min(std::clamp(1.2 * ee90, 6 * lamp.airy(), 40 * lamp.airy()), 0.9 * field);
  lamp.draw(of.measured, light.radius, half, &light.measured);
  lamp.draw(of.terms, light.radius, half, &light.terms);
  lamp.draw(none, light.radius, half, &light.perfect);
  rough.draw(of.terms, light.radius, half, &light.terms_and_rest);
  warn_of_map_light(task, panels.residual, &light);
  return light;
}

}  // namespace aberfit
