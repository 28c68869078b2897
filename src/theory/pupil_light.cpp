#include "pupil_light.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/bessel.h"
#include "log_hankel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// The taper begins and ends at these fractions of the field of view. Near the edge of the field, energy from
// beyond comes back in from the other side. There the error of the pixelated aperture edge is largest, too.
// So the taper is wide for steep phases. Else it is narrow, because transfer_beyond adds the energy of edges.
constexpr double kNarrowTaper = 0.25, kWideTaper = 0.5, kTaperWidth = 0.2;
// The taper begins at this multiple of the distance that belongs to the steepest slope.
constexpr double kTaperPerSlope = 4;
constexpr double kTapers = 8;  // number of different tapers, so that planes can use the same grid
// The taper of rings begins some diffraction widths beyond the cone of rays.
constexpr double kBeyondCone = 1.5, kStepsBeyondCone = 60, kTaperOfRings = 1.3;
// Shear times the taper's start; above it the energy beyond the taper has a transfer below 1e-6.
constexpr double kShort = 6;
constexpr int kNodesBeyond = 64;  // for at most 11 cycles
// The same product, from which the irradiance resolves b; the power j of b needs j times as much.
constexpr double kSeenApart = 2;
// Cycles of the outermost irradiance that the 24 nodes of a panel resolve.
constexpr double kCyclesOfLightPanel = 3.5;
// Shortest radius over the outer radius, shortest distance times the longest shear, and shortest shear times
// the longest distance. The part inside is about 1e-6.
constexpr double kNear = 1e-3;
constexpr double kTurnOfRings = 1;     // largest change of J0's argument between rings [rad]
constexpr Eigen::Index kTogether = 8;  // number of shears through which an interpolating polynomial goes
// Weights at the ends of the trapezoid rule (Gregory), to the sixth order.
constexpr double kGregory[] = {95 / 288.0, 317 / 240.0, 23 / 30.0, 793 / 720.0, 157 / 160.0};

constexpr double kCellsPerSlenderness = 16;
constexpr std::size_t kBundle = 2 * kLines;

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

// Moments at the nodes of the basis, from moments of a^i b^j.
Eigen::ArrayXd at_nodes(const Eigen::MatrixXd& monomials, const MomentBasis& basis) {
  const int degree = int(monomials.rows()) - 1, most = std::min(degree, basis.order - 1);
  const Eigen::MatrixXd to_chebyshev = shifted_chebyshev(degree);
  const Eigen::MatrixXd of_degree = to_chebyshev * monomials * to_chebyshev.transpose();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(basis.order, basis.order);
  for (int p = 0; p <= most; ++p)
    for (int q = 0; q <= std::min(most, degree - p); ++q) all(p, q) = of_degree(p, q);
  return basis.at_nodes(all);
}

// Lagrange weights of kTogether values at 0, 1, 2, ... for the position `place`.
Eigen::Array<double, 1, Eigen::Dynamic> lagrange(double place) {
  Eigen::Array<double, 1, Eigen::Dynamic> weight = Eigen::Array<double, 1, kTogether>::Ones();
  for (Eigen::Index i = 0; i < kTogether; ++i)
    for (Eigen::Index j = 0; j < kTogether; ++j)
      if (j != i) weight[i] *= (place - double(j)) / double(i - j);
  return weight;
}

// Transfer at shears x [m] of the energy that a taper from `edge` to `end` removes, if the irradiance falls
// with the cube of the distance; 1 at x = 0. Beyond `end`, where all is removed, the integral of J0(2 pi x
// d)/d^2 is closed but for the integral of J0 from `end` on: 1 less that up to `end`.
Eigen::ArrayXd transfer_beyond(const Eigen::ArrayXd& x, double edge, double end) {
  constexpr int n = kNodesBeyond;
  const Quadrature across = gauss_legendre(n, edge, end), inside = gauss_legendre(n, 0, end);
  const Eigen::ArrayXd taken =
      across.weights * across.nodes.unaryExpr([&](double d) { return (1 - taper(d, edge, end)) / (d * d); });
  Eigen::ArrayXd z(2 * n + 1), j0(z.size()), j1(z.size()), result = Eigen::ArrayXd::Zero(x.size());
  for (Eigen::Index k = 0; k < x.size() && x[k] * edge < kShort; ++k) {
    const double turn = 2 * pi * x[k];
    z << turn * across.nodes, turn * inside.nodes, turn * end;
    bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
    const double of_j0 = turn * (inside.weights * j0.segment(n, n)).sum();
    result[k] = ((taken * j0.head(n)).sum() + j0[2 * n] / end - turn * (1 - of_j0 + j1[2 * n])) /
                (taken.sum() + 1 / end);
  }
  return result;
}

// Means of a^i b^j over points with the given squares and weights. b is a times the square of a cosine.
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

double slenderness(const Aperture& aperture) {
  double edges = 0;
  for (const Outline& outline : aperture_outlines(aperture))
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
      edges += std::hypot(b[0] - a[0], b[1] - a[1]);
    }
  if (const auto* circle = std::get_if<CircleAperture>(&aperture)) edges = pi * circle->diameter;
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture))
    edges = pi * (annulus->diameter + annulus->inner_diameter);
  return edges * 2 * aperture_radius(aperture) / aperture_area(aperture);
}

double cells_for_edges(const Aperture& aperture) { return kCellsPerSlenderness * slenderness(aperture); }

PupilCells::PupilCells(const PupilField& field, int cells)
    : PupilCells(field.aperture(), field.focal_length(), field.outer(), cells) {
  wavelength_ = field.wavelength();
  path_.resize(square_.size());
  departure_ = Eigen::ArrayXd::Zero(square_.size());
  for (Eigen::Index k = 0; k < square_.size(); ++k) {
    const double sine2 = square_[k] * std::pow(outer_ / focal_length_, 2);
    path_[k] = sine2 / (1 + std::sqrt(1 - sine2));
    const auto cell = std::size_t(k);
    if (field.has_departure())
      departure_[k] = field.departure_phase(grid().x[grid().column[cell]], grid().y[grid().row[cell]]);
  }
  if (const auto segments = erring_segments(field.aperture())) set_segments(*segments);
}

// The phase of a height h is 4 pi q/lambda times h, q the obliquity. Over a shear P within one segment, a
// slope changes it by 4 pi/lambda times P across and P/(2q - 1) along the direction from the axis. The decay
// uses the mean of these squares over the mirror.
void PupilCells::set_segments(const Segments& segments) {
  segments_.resize(segments.all().size());
  fade_.resize(square_.size());
  double stretch2 = 0;
  for (Eigen::Index k = 0; k < fade_.size(); ++k) {
    const double x = pupil_.sample.x[k], y = pupil_.sample.y[k];
    const double turn2 = std::pow(4 * pi / wavelength_ * pupil_.obliquity[k], 2);
    segments_[pupil_.sample.segment[std::size_t(k)]].number.push_back(k);
    fade_[k] = std::exp(-0.5 * turn2 * segments.variance(pupil_.sample.segment[std::size_t(k)], x, y));
    stretch2 += 0.5 * pupil_.sample.weight[k] * (1 + 1 / std::pow(2 * pupil_.obliquity[k] - 1, 2));
  }
  for (const Segments::Segment& segment : segments.all()) longest_ = std::max(longest_, 2 * segment.radius);
  std::erase_if(segments_, [](const SegmentCells& cells) { return cells.number.empty(); });
  const auto place = [](const SegmentCells& cells, const std::vector<std::uint32_t>& all,
                        std::vector<std::uint32_t>* places) {
    for (const Eigen::Index k : cells.number) places->push_back(all[std::size_t(k)]);
    const auto [low, high] = std::minmax_element(places->begin(), places->end());
    const std::uint32_t first = *low, count = *high - first + 1;
    for (std::uint32_t& one : *places) one -= first;
    return Eigen::Index(count);
  };
  for (SegmentCells& cells : segments_) {
    cells.columns = place(cells, grid().column, &cells.column);
    cells.rows = place(cells, grid().row, &cells.row);
    double faded = 0, all = 0;
    for (const Eigen::Index k : cells.number) {
      const double light = std::pow(pupil_.amplitude[k], 2);
      faded += light * fade_[k] * fade_[k];
      all += light;
    }
    cells.kept = faded / all;
  }
  decay_ = 0.5 * stretch2 * std::pow(4 * pi / wavelength_ * segments.tip_tilt(), 2);
}

LitCells PupilCells::lit(double dz) const {
  return {columns(), rows(), grid().column, grid().row, pupil_.amplitude, phase(dz), square_};
}

LitCells LitCells::part(const SegmentCells& cells) const {
  const auto n = Eigen::Index(cells.number.size());
  LitCells result{cells.columns,     cells.rows,        cells.column,     cells.row,
                  Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index from = cells.number[std::size_t(k)];
    result.amplitude[k] = amplitude[from];
    result.phase[k] = phase[from];
    result.square[k] = square[from];
  }
  return result;
}

PupilCells::PupilCells(const Aperture& aperture, int cells)
    : PupilCells(aperture, kParaxial, aperture_radius(aperture), cells) {
  path_ = departure_ = Eigen::ArrayXd::Zero(square_.size());
}

PupilCells::PupilCells(const Aperture& aperture, double focal_length, double outer, int cells)
    : pupil_(diffraction_pupil(aperture, focal_length, 2 * outer / cells)),
      focal_length_(focal_length),
      outer_(outer),
      square_(pupil_.amplitude.size()) {
  for (Eigen::Index k = 0; k < square_.size(); ++k)
    square_[k] = (std::pow(grid().x[grid().column[std::size_t(k)]], 2) +
                  std::pow(grid().y[grid().row[std::size_t(k)]], 2)) /
                 (outer_ * outer_);
}

Eigen::MatrixXd PupilCells::mean(int degree) const {
  return mean_of_aperture(square_, pupil_.amplitude * (pupil_.sample.weight / pupil_.cover).sqrt(), degree);
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
  std::vector<Above> above(grid().x.size());
  Eigen::Index last_row = -2, last_column = -2;
  for (Eigen::Index k = 0; k < all.size(); ++k) {
    const Eigen::Index row = grid().row[std::size_t(k)], column = grid().column[std::size_t(k)];
    if (row == last_row && column == last_column + 1) most = std::max(most, std::abs(all[k] - all[k - 1]));
    last_row = row;
    last_column = column;
    Above& one = above[std::size_t(column)];
    if (one.row == row - 1) most = std::max(most, std::abs(all[k] - one.phase));
    one = {row, all[k]};
  }
  return most / (2 * pi * pitch());
}

FocalGrid::FocalGrid(const Samples& samples, double taper)
    : samples_(samples),
      taper_(taper),
      rings_(samples.y / 2 + 1, samples.x / 2 + 1, double(finest()) / samples.x, double(finest()) / samples.y,
             0.5 * taper_end() * finest()),
      along_x_(samples.x),
      along_y_(samples.y),
      no_shift_(line_phases<double>(finest(), 0, 1)) {
  for (int row = 0; row < samples_.y; ++row)
    if (rings_.columns_within(std::min(row, samples_.y - row)) > 0) kept_.push_back(row);
}

namespace {

// Even, a product of small primes, and enough for the grid points of a side plus the longest shear.
int samples_along(Eigen::Index side, Eigen::Index shear) {
  int samples = int(side + shear) + 1;
  do samples = int(smooth_from(samples + 1));
  while (samples % 2 != 0);
  return samples;
}

}  // namespace

FocalGrid::Samples FocalGrid::samples_for(const PupilCells& cells, double end) {
  const auto shear = Eigen::Index(std::ceil(end / cells.pitch()));
  return {samples_along(cells.columns(), shear), samples_along(cells.rows(), shear)};
}

FocalGrid::Samples FocalGrid::samples_for_segments(const PupilCells& cells, double end) {
  Eigen::Index columns = 0, rows = 0;
  for (const SegmentCells& segment : cells.segments()) {
    columns = std::max(columns, segment.columns);
    rows = std::max(rows, segment.rows);
  }
  const auto shear = Eigen::Index(std::ceil(std::min(end, cells.longest_in_a_segment()) / cells.pitch()));
  return {samples_along(columns, shear), samples_along(rows, shear)};
}

struct FocalGrid::Workspace {
  std::vector<double> bundles, line, work;
  std::vector<std::vector<double>> half_way;  // each field, transformed along columns
  std::vector<Eigen::ArrayXd> field;          // eight rows of each field
  Eigen::ArrayXXd both, other, values;
};

FocalGrid::~FocalGrid() = default;

double FocalGrid::taper_end() const { return taper_ + kTaperWidth; }

double FocalGrid::taper_for(const PupilCells& cells, double steepest) {
  const double wanted = std::ceil(kTapers * kTaperPerSlope * 2 * cells.pitch() * steepest) / kTapers;
  return std::clamp(wanted, kNarrowTaper, kWideTaper);
}

std::unique_ptr<FocalGrid::Workspace> FocalGrid::workspace() const {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<Workspace>();
  std::unique_ptr<Workspace> one = std::move(idle_.back());
  idle_.pop_back();
  return one;
}

// Transforms a field, held in bundles of columns, along columns. Returns the kept rows.
void FocalGrid::columns_out(Eigen::Index of_cells, Workspace* work, std::vector<double>* kept) const {
  const LineKernels<double>& kernels = line_kernels<double>(best_instruction_set());
  const std::size_t rows = std::size_t(of_cells), blocks = work->bundles.size() / (rows * kBundle);
  kept->resize(kept_.size() * blocks * kBundle);
  for (std::size_t block = 0; block < blocks; ++block) {
    kernels.columns_out(along_y_.steps(), no_shift_.data(), 1, work->bundles.data() + block * rows * kBundle,
                        kBundle, int(rows), work->line.data(), kBundle, work->work.data());
    for (std::size_t k = 0; k < kept_.size(); ++k)
      std::copy_n(work->line.data() + std::size_t(kept_[k]) * kBundle, kBundle,
                  kept->data() + (k * blocks + block) * kBundle);
  }
}

Eigen::ArrayXXd FocalGrid::ring_sums(const LitCells& cells, int powers_of_square,
                                     const std::vector<std::vector<double>>& products) const {
  const LineKernels<double>& kernels = line_kernels<double>(best_instruction_set());
  std::unique_ptr<Workspace> space = workspace();
  auto& [bundles, line, work, half_way, field, both, other, values] = *space;
  const Eigen::Index n = cells.phase.size();
  const std::size_t rows = std::size_t(cells.rows),
                    blocks = (std::size_t(cells.columns) + kLines - 1) / kLines;
  line.resize(std::size_t(samples_.y) * kBundle);
  work.resize(kBundle * (3 * std::size_t(finest()) + 24));
  half_way.resize(std::size_t(powers_of_square) + 1);
  Eigen::ArrayXd sine(n), cosine(n);
  sin_cos(cells.phase.data(), int(n), sine.data(), cosine.data());
  sine *= cells.amplitude;
  cosine *= cells.amplitude;
  for (std::vector<double>& one : half_way) {
    bundles.assign(blocks * rows * kBundle, 0.0);
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::size_t column = cells.column[std::size_t(k)], row = cells.row[std::size_t(k)];
      double* const at = bundles.data() + (column / kLines * rows + row) * kBundle + column % kLines;
      at[0] += cosine[k];
      at[kLines] += sine[k];
    }
    columns_out(cells.rows, space.get(), &one);
    sine *= cells.square;
    cosine *= cells.square;
  }

  const auto count = Eigen::Index(products.size());
  Eigen::ArrayXXd sums = Eigen::ArrayXXd::Zero(count, rings_.lengths());
  const Eigen::Index most = rings_.columns_within(0);
  field.resize(half_way.size());
  for (Eigen::ArrayXd& one : field) one.resize(Eigen::Index(samples_.x) * kBundle);
  both.resize(kLines, most);
  other.resize(kLines, most);
  values.resize(count, kLines * most);
  for (std::size_t first = 0; first < kept_.size(); first += kLines) {
    const double* lines[kLines] = {};
    for (std::size_t i = 0; i < field.size(); ++i) {
      for (std::size_t l = 0; l < kLines && first + l < kept_.size(); ++l)
        lines[l] = half_way[i].data() + (first + l) * blocks * kBundle;
      kernels.rows_out(along_x_.steps(), 1, no_shift_.data(), lines, int(cells.columns), field[i].data(),
                       work.data());
    }
    // Samples c and -c of eight rows at a time.
    using Rows = Eigen::Map<const Eigen::ArrayXXd, 0, Eigen::OuterStride<kBundle>>;
    const auto at = [&](std::size_t i, Eigen::Index from, Eigen::Index part) {
      return Rows(field[i].data() + from * kBundle + part, kLines, most, Eigen::OuterStride<kBundle>());
    };
    for (Eigen::Index p = 0; p < count; ++p) {
      const std::vector<double>& powers = products[std::size_t(p)];
      both.setZero();
      other.setZero();
      for (std::size_t k = 0; 2 * k < powers.size(); ++k) {
        const std::size_t last = powers.size() - 1 - k;
        const double weight = last == k ? powers[k] : powers[k] + powers[last];
        if (weight == 0) continue;
        both += weight * (at(last, 0, 0) * at(k, 0, 0) + at(last, 0, kLines) * at(k, 0, kLines));
        const Eigen::Index from = samples_.x - most;
        other += weight * (at(last, from, 0) * at(k, from, 0) + at(last, from, kLines) * at(k, from, kLines));
      }
      for (Eigen::Index c = 1; c < most; ++c) both.col(c) += other.col(most - c);
      values.row(p) = both.reshaped().transpose();
    }
    for (std::size_t l = 0; l < kLines && first + l < kept_.size(); ++l) {
      const int from_axis = std::min(kept_[first + l], samples_.y - kept_[first + l]);
      const std::uint32_t* const ring = rings_.length_of(from_axis);
      for (Eigen::Index c = 0; c < rings_.columns_within(from_axis); ++c)
        sums.col(ring[c]) += values.col(c * kLines + Eigen::Index(l));
    }
  }
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(space));
  return sums;
}

std::shared_ptr<const Eigen::MatrixXd> FocalGrid::bessel(const Eigen::ArrayXd& x,
                                                         const Eigen::ArrayXd& distance) const {
  const auto same = [](const Eigen::ArrayXd& one, const Eigen::ArrayXd& two) {
    return one.size() == two.size() && (one == two).all();
  };
  {
    const std::lock_guard lock(mutex_);
    if (last_bessel_ && same(x, last_x_) && same(distance, last_distance_)) return last_bessel_;
  }
  Eigen::ArrayXd z(distance.size()), unused(distance.size());
  Eigen::MatrixXd all(distance.size(), x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    z = 2 * pi * x[k] * distance;
    bessel_j0_j1(z.data(), int(z.size()), all.col(k).data(), unused.data());
  }
  const std::lock_guard lock(mutex_);
  last_x_ = x;
  last_distance_ = distance;
  return last_bessel_ = std::make_shared<const Eigen::MatrixXd>(std::move(all));
}

std::vector<PupilLight::Product> PupilLight::products(int degree) {
  std::vector<Product> all;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j) all.push_back({i, j});
  return all;
}

std::vector<double> PupilLight::of_powers(const Product& product) {
  std::vector<double> powers{1};
  const auto times = [&](double scale, double sign) {
    powers.push_back(0);
    for (std::size_t k = powers.size(); k-- > 0;)
      powers[k] = scale * (powers[k] + (k > 0 ? sign * powers[k - 1] : 0.0));
  };
  for (int k = 0; k < product.i; ++k) times(0.5, 1);
  for (int k = 0; k < 2 * product.j; ++k) times(1, -1);
  return powers;
}

namespace {

// Sums over the irradiance on a grid, by distance from the axis.
struct LightOnGrid {
  const FocalGrid* grid = nullptr;
  Eigen::ArrayXd distance;
  Eigen::MatrixXd light;  // one column per product

  // pitch: of the pupil grid [m]; total: all energy. Energy beyond the taper is left out.
  LightOnGrid(const FocalGrid& on, const Eigen::ArrayXXd& ring_sums, double pitch, double total, double edge,
              double end)
      : grid(&on) {
    const Eigen::Index nodes = on.rings().nodes();
    const double step = 1 / (LagTable::kNodesPerLag * on.finest() * pitch);
    distance = step * Eigen::ArrayXd::LinSpaced(nodes, 0.0, double(nodes - 1));
    const Eigen::ArrayXd left = distance.unaryExpr([&](double d) { return taper(d, edge, end); });
    light.resize(nodes, ring_sums.rows());
    for (Eigen::Index l = 0; l < ring_sums.rows(); ++l)
      light.col(l) = left * on.rings().to_nodes(ring_sums.row(l).transpose()) / (on.count() * total);
  }
  Eigen::ArrayXd within() const { return light.colwise().sum().transpose().array(); }
  // One row per shear x [m].
  Eigen::ArrayXXd transfer(const Eigen::ArrayXd& x) const {
    const std::shared_ptr<const Eigen::MatrixXd> bessel = grid->bessel(x, distance);
    Eigen::ArrayXXd at(x.size(), light.cols());
    for (Eigen::Index k = 0; k < x.size(); ++k) at.row(k) = bessel->col(k).transpose().lazyProduct(light);
    return at;
  }
};

}  // namespace

PupilLight PupilLight::of_cells(const PupilCells& cells, const FocalGrid& grid, const FocalGrid* of_segments,
                                int degree, double dz) {
  std::vector<std::vector<double>> all;
  for (const Product& product : products(degree)) all.push_back(of_powers(product));
  PupilLight result;
  result.degree = degree;
  result.outer = cells.outer();
  result.mean = cells.mean(degree);
  result.edge = 0.5 * grid.taper() / cells.pitch();
  result.end = 0.5 * grid.taper_end() / cells.pitch();
  const auto light_on = [&](const FocalGrid& on, const Eigen::ArrayXXd& sums) {
    return LightOnGrid(on, sums, cells.pitch(), cells.pupil().total, result.edge, result.end);
  };
  LitCells lit = cells.lit(dz);
  if (cells.segments().empty()) {
    const LightOnGrid light = light_on(grid, grid.ring_sums(lit, 2 * degree, all));
    result.within = light.within();
    result.sums = [light](const Eigen::ArrayXd& x) { return light.transfer(x); };
    return result;
  }
  const auto of_one = Eigen::Index(all.size());
  Eigen::ArrayXXd whole = Eigen::ArrayXXd::Zero(of_one, of_segments->rings().lengths()), faded = whole;
  for (const SegmentCells& segment : cells.segments()) {
    const Eigen::ArrayXXd sums = of_segments->ring_sums(lit.part(segment), 2 * degree, all);
    whole += sums;
    if (cells.fade_is_even()) faded += segment.kept * sums;
  }
  lit.amplitude *= cells.fade();
  if (!cells.fade_is_even())
    for (const SegmentCells& segment : cells.segments())
      faded += of_segments->ring_sums(lit.part(segment), 2 * degree, all);
  const LightOnGrid between = light_on(grid, grid.ring_sums(lit, 2 * degree, all)),
                    within = light_on(*of_segments, whole), counted = light_on(*of_segments, faded);
  result.within = between.within() - counted.within() + within.within();
  result.sums = [between, within, counted, decay = cells.decay(),
                 longest = cells.longest_in_a_segment()](const Eigen::ArrayXd& x) {
    Eigen::ArrayXXd sums = between.transfer(x);
    // Longer shears do not fit into a segment; their sums would come from the next period.
    const Eigen::Index inside = (x <= longest).count();
    const Eigen::ArrayXd shorter = x.head(inside);
    Eigen::ArrayXXd kept = within.transfer(shorter);
    kept.colwise() *= (-decay * shorter.square()).exp();
    sums.topRows(inside) += kept - counted.transfer(shorter);
    return sums;
  };
  return result;
}

PupilLight PupilLight::of_rings(const PupilField& field, int degree, double dz) {
  const double inner = field.inner(), outer = field.outer(), longest = 2 * outer;
  PupilLight result;
  result.degree = degree;
  result.outer = outer;
  result.edge = kBeyondCone * field.steepest(dz) / (2 * pi) + kStepsBeyondCone / longest;
  result.end = kTaperOfRings * result.edge;
  const LogHankel to_focus(std::max(inner, kNear * outer), outer, kNear / longest, result.end, kTurnOfRings);
  const Eigen::ArrayXd r = to_focus.x(), square = (r / outer).square(), distance = to_focus.y();
  const Eigen::Index n = r.size(), lights = distance.size();
  Eigen::ArrayXd amplitude(n), phase(n), sine(n), cosine(n), rule = Eigen::ArrayXd::Ones(n);
  field.along_radius(dz, r, &amplitude, &phase);
  sin_cos(phase.data(), int(n), sine.data(), cosine.data());
  for (std::size_t k = 0; k < std::size(kGregory); ++k)
    rule[Eigen::Index(k)] = rule[n - 1 - Eigen::Index(k)] = kGregory[k];
  const Eigen::ArrayXd ring = 2 * pi * to_focus.step() * rule * r.square() * amplitude.square();
  const double total = ring.sum();
  result.mean = mean_of_aperture(square, ring, degree);
  std::vector<Eigen::ArrayXcd> field_of;
  Eigen::ArrayXd weight = rule * r * amplitude;
  for (int i = 0; i <= 2 * degree; ++i, weight *= square) {
    field_of.emplace_back(weight * cosine + std::complex<double>(0, 1) * (weight * sine));
    to_focus(&field_of.back());
  }

  const LogHankel to_shear(distance[0], result.end, kNear / result.end, longest,
                           2 * pi * result.end * longest * to_focus.step());
  const Eigen::ArrayXd x = to_shear.y();
  const std::vector<Product> all = products(degree);
  const Eigen::ArrayXd left =
      distance.unaryExpr([&](double d) { return taper(d, result.edge, result.end) / total; });
  Eigen::ArrayXXd sums(x.size(), Eigen::Index(all.size()));
  result.within.resize(sums.cols());
  for (std::size_t l = 0; l < all.size(); ++l) {
    const std::vector<double> powers = of_powers(all[l]);
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(lights);
    for (std::size_t k = 0; k < powers.size(); ++k) {
      const Eigen::ArrayXcd &one = field_of[powers.size() - 1 - k], &two = field_of[k];
      sum += powers[k] * (one.real() * two.real() + one.imag() * two.imag());
    }
    sum *= left;
    result.within[Eigen::Index(l)] = 2 * pi * to_focus.step() * sum.sum();
    Eigen::ArrayXcd light = (sum / distance).cast<std::complex<double>>();
    to_shear(&light);
    sums.col(Eigen::Index(l)) = light.real() / x;
  }
  result.sums = [sums, from = std::log(x[0]), step = to_shear.step()](const Eigen::ArrayXd& shears) {
    Eigen::ArrayXXd at(shears.size(), sums.cols());
    for (Eigen::Index k = 0; k < shears.size(); ++k) {
      const double place = std::max(0.0, (std::log(std::max(shears[k], 1e-300)) - from) / step);
      const Eigen::Index first =
          std::clamp<Eigen::Index>(Eigen::Index(place) - kTogether / 2 + 1, 0, sums.rows() - kTogether);
      at.row(k) = lagrange(place - double(first)).matrix() * sums.middleRows(first, kTogether).matrix();
    }
    return at;
  };
  return result;
}

LightMoments::LightMoments(PupilLight light, const MomentBasis& basis)
    : light_(std::move(light)), basis_(basis), products_(PupilLight::products(light_.degree)) {}

double LightMoments::resolved() const { return kCyclesOfLightPanel / light_.end; }

Eigen::ArrayXd LightMoments::whole(const Eigen::MatrixXd& mean, const MomentBasis& basis) {
  return at_nodes(mean, basis);
}

// Converts sums of the products into sums of a^i b^j.
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
  Eigen::ArrayXXd result(x.size(), basis_.order * basis_.order);
  const Eigen::ArrayXXd of_light = light_.sums(x);
  const Eigen::ArrayXd beyond = transfer_beyond(x, light_.edge, light_.end);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    Eigen::ArrayXd sums = of_light.row(k).transpose();
    for (std::size_t l = 0; l < products_.size(); ++l)
      if (products_[l].j == 0)
        sums[Eigen::Index(l)] +=
            beyond[k] * (light_.mean(products_[l].i, 0) - light_.within[Eigen::Index(l)]);
    Eigen::MatrixXd all = monomials(sums, std::pow(x[k] / light_.outer, 2));
    // For close points b is a small difference over a small shear, so it takes its mean over the aperture.
    for (int j = 1; j <= light_.degree; ++j) {
      const double known = std::pow(std::min(1.0, x[k] * light_.edge / (kSeenApart * j)), 2 * j);
      for (int i = 0; i + j <= light_.degree; ++i)
        all(i, j) = (known > 0 ? known * all(i, j) : 0.0) + (1 - known) * sums[0] * light_.mean(i, j);
    }
    result.row(k) = at_nodes(all, basis_).transpose();
  }
  return result;
}

}  // namespace aberfit::internal
