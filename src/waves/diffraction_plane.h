#pragma once
#include <Eigen/Core>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/lag_table.h"
#include "diffraction_otf.h"
#include "diffraction_transform.h"

namespace aberfit::internal {

/// Phase differences of neighbouring grid cells.
struct PhaseSteps {
  double largest = 0;        ///< [rad]
  double aliased_share = 0;  ///< fraction of the pairs above pi
};

/// Data that all planes of one surface share. It refers to the problem, which must outlive it.
class DiffractionScene {
 public:
  /// Throws std::invalid_argument for a pupil without cells, heights that are not finite or of the wrong
  /// number, and lengths that are not positive.
  DiffractionScene(const DiffractionProblem& problem, const Eigen::ArrayXd& height, int threads);

  const DiffractionProblem& problem() const { return problem_; }
  /// Cells by f times the direction cosine, or by position if the pupil is paraxial.
  const CartesianGrid& grid() const { return grid_; }
  int rows() const { return int(grid_.y.size()); }
  int columns() const { return int(grid_.x.size()); }
  Eigen::Index points() const { return base_.size(); }
  /// amplitude exp(-4 pi i h/(lambda (1 + t^2)))
  const Eigen::ArrayXcd& base() const { return base_; }
  /// The same for the mirror without roughness.
  Eigen::ArrayXcd nominal_base() const;
  /// Index of each point's cell in a field laid out for transforms.
  const std::vector<std::uint32_t>& places() const { return places_; }
  /// 1 - cos theta of every point, theta its ray's angle with the axis; half rho^2/f^2 in a paraxial pupil.
  const Eigen::ArrayXd& versine() const { return versine_; }
  /// d phase/d height [rad/m].
  const Eigen::ArrayXd& per_height() const { return per_height_; }
  double finer_pitch() const { return std::min(problem_.pupil.pitch_x, problem_.pupil.pitch_y); }
  /// Longest lag inside the pupil, in units of the finer pitch.
  double longest_lag() const { return longest_lag_; }
  /// Total energy that passes the aperture, in squared amplitudes of cells.
  double total() const { return problem_.pupil.total; }
  /// Axial irradiance of the perfect parabola in the focus, in total energy per squared period of the PSF.
  double perfect_irradiance() const;
  /// Fraction of the energy beyond the field of view, by Parseval's theorem.
  double energy_outside() const { return 1 - problem_.pupil.amplitude.square().sum() / total(); }
  /// u = pitch/(lambda (f+dz)) [1/m] for the finer pitch; a radius times u is in periods of the PSF.
  double per_period(double dz) const {
    return finer_pitch() / (problem_.wavelength * (problem_.focal_length + dz));
  }
  /// Largest radius [m] for which an encircled energy exists.
  double largest_radius(double dz) const {
    return problem_.scatter ? problem_.focal_length + dz : field_radius(dz);
  }
  /// Half the field of view [m].
  double field_radius(double dz) const {
    const double coarser = std::max(problem_.pupil.pitch_x, problem_.pupil.pitch_y);
    return 0.5 * problem_.wavelength * (problem_.focal_length + dz) / coarser;
  }
  /// False for planes at or behind the mirror's vertex and for a dz that is not finite.
  bool has_plane(double dz) const { return std::isfinite(dz) && problem_.focal_length + dz > 0; }
  /// Defocus phase over the versine [rad], and its derivative with respect to dz [rad/m].
  double defocus(double dz) const;
  double defocus_slope(double dz) const;
  /// Largest values over all planes between the two.
  PhaseSteps phase_steps(const Eigen::ArrayXd& height, double dz_low, double dz_high) const;

 private:
  Eigen::ArrayXcd base_of(const Eigen::ArrayXd& height, int threads) const;

  const DiffractionProblem& problem_;
  const CartesianGrid& grid_;
  Eigen::ArrayXcd base_;
  Eigen::ArrayXd versine_, per_height_;
  std::vector<std::uint32_t> places_;
  double longest_lag_ = 0;
};

/// exp(i phase)
Eigen::ArrayXcd unit_phasors(const Eigen::ArrayXd& phase);

/// Kernels of circles that fits need repeatedly, for several threads. Storing them changes no bit of a
/// result.
class KernelMemory {
 public:
  /// The kernel of a circle, stored or made by build(AlignedArray* kernel); null when there is no room.
  template <typename Build>
  const AlignedArray* find(double q, const PupilTransform& transform, const Build& build) {
    const std::size_t size = transform.kernel_size();
    const Precision precision = transform.precision();
    {
      const std::lock_guard lock(mutex_);
      if (const auto at = kept_.find(q); at != kept_.end()) return at->second.get();
      if (double(kept_.size() + 1) * double(size * bytes_of_number(precision)) > kMostKept) return nullptr;
    }
    auto made = std::make_unique<AlignedArray>(size, precision);
    build(made.get());
    const std::lock_guard lock(mutex_);
    return kept_.emplace(q, std::move(made)).first->second.get();
  }

 private:
  static constexpr double kMostKept = 256e6;  // bytes
  std::mutex mutex_;
  std::map<double, std::unique_ptr<AlignedArray>> kept_;
};

/// The field in one plane and its derived quantities. Its memory serves one plane after the other.
struct FocusedField {
  explicit FocusedField(const PupilTransform& transform)
      : focal(transform.focal_size(), transform.precision()) {}
  double dz = std::nan("");  ///< NaN: not focused yet
  bool own_mean = false;     ///< true: with the mean spot of this plane, not of the focus
  AlignedArray focal;
  Eigen::ArrayXcd field;  ///< at the pupil points
  RadialOtf otf;
  Eigen::ArrayXcd along_x, along_y;  ///< set at the first request
};

/// Working memory of one thread.
struct DiffractionBench {
  explicit DiffractionBench(const PupilTransform& transform) : buffers(transform), focused(transform) {}
  PupilTransform::Buffers buffers;
  FocusedField focused;
};

/// Unused working memory for one grid. Allocating it anew for each plane would take a sixth of a large fit.
class DiffractionBenches {
 public:
  std::unique_ptr<DiffractionBench> take(const PupilTransform& transform) {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<DiffractionBench> bench = std::move(free_.back());
        free_.pop_back();
        return bench;
      }
    }
    auto made = std::make_unique<DiffractionBench>(transform);
    const std::lock_guard lock(mutex_);
    free_.reserve(++made_);
    return made;
  }
  void give_back(std::unique_ptr<DiffractionBench> bench) noexcept {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(bench));  // has room for all
  }

 private:
  std::mutex mutex_;
  std::size_t made_ = 0;
  std::vector<std::unique_ptr<DiffractionBench>> free_;
};

/// Data that all planes of one pupil grid share.
struct DiffractionGrid {
  explicit DiffractionGrid(const DiffractionScene& scene, Precision precision = Precision::kDouble);
  PupilTransform transform;
  LagTable lags;
  mutable KernelMemory kernels;
  mutable DiffractionBenches benches;
  // These are for roughness that is not part of the heights.
  Eigen::ArrayXcd perfect;          ///< nominal field base of the mean spots
  Eigen::ArrayXd factor;            ///< H at the lengths of `lags`; empty: 1
  Eigen::ArrayXd along_x, along_y;  ///< H at the lags (m, 0) and (0, m)
  /// C_m^0 H_whole at the nodes of `lags` in the plane dz, as energy fractions. It is computed at the first
  /// request; several threads may call it. scratch: an unfocused field, which is overwritten.
  const Eigen::ArrayXd& mean_at(const DiffractionScene& scene, double dz, PupilTransform::Buffers* buffers,
                                FocusedField* scratch) const;
  /// Returns whether the mean spot beyond the field of view differs between the plane dz and the focus.
  bool has_own_mean(const DiffractionScene& scene, double dz) const;

 private:
  void set_scatter(const DiffractionScene& scene);
  Eigen::ArrayXd whole_;  // H_whole at the lengths of `lags`
  mutable std::mutex mutex_;
  mutable std::map<double, Eigen::ArrayXd> means_;
  mutable std::map<double, bool> own_;
};

/// Sums of C_m over the lags of each length for the field in `focal`, as energy fractions per area of a cell.
Eigen::ArrayXd lag_sums(const DiffractionScene& scene, const DiffractionGrid& grid, const AlignedArray& focal,
                        PupilTransform::Buffers* buffers);

/// Borrows the working memory of a grid for a thread.
class BorrowedBench {
 public:
  explicit BorrowedBench(const DiffractionGrid& grid)
      : grid_(grid), bench_(grid.benches.take(grid.transform)) {
    bench_->focused.dz = std::nan("");  // another surface's plane
  }
  ~BorrowedBench() { grid_.benches.give_back(std::move(bench_)); }
  BorrowedBench(const BorrowedBench&) = delete;
  BorrowedBench& operator=(const BorrowedBench&) = delete;
  DiffractionBench* operator->() { return bench_.get(); }

 private:
  const DiffractionGrid& grid_;
  std::unique_ptr<DiffractionBench> bench_;
};

/// The PSF of a scene in one plane, in borrowed memory. A `focused` with a dz must belong to the same scene.
class DiffractionPlane {
 public:
  DiffractionPlane(const DiffractionScene& scene, const DiffractionGrid& grid,
                   PupilTransform::Buffers& buffers, FocusedField& focused);

  /// The mean spot that supplies energy beyond the grid: that of the focus, or that of the plane if it is
  /// known and differs. The latter is worthwhile for planes that are evaluated repeatedly.
  enum class Mean { kInFocus, kInPlane };
  /// Moves to the plane z = f + dz by two transforms, unless it is already there.
  void focus(double dz, Mean mean = Mean::kInFocus);
  double dz() const { return focused_.dz; }
  /// Encircled energy as a fraction, and its derivative with respect to the radius [1/m].
  struct InCircle {
    double energy, density;
  };
  /// Encircled energy at `radius` and dz with the mean spot of that plane, minus that with the mean spot of
  /// the focus. It depends on no surface and is smooth in dz. The object leaves its current plane.
  InCircle light_of_own_mean(double radius, double dz);

  /// Radii are in [m]; energies are fractions.
  double energy(double radius) const { return otf().energy(radius * unit_); }
  double density(double radius) const { return otf().density(radius * unit_) * unit_; }  ///< [1/m]
  std::optional<double> radius(double fraction);
  const RadialOtf& otf() const { return focused_.otf; }

  /// C_m along the lags (m, 0) and (0, m), m >= 0, as energy fractions.
  const Eigen::ArrayXcd& along_x() {
    correlate_along_axes();
    return focused_.along_x;
  }
  const Eigen::ArrayXcd& along_y() {
    correlate_along_axes();
    return focused_.along_y;
  }

  /// Refers to the result of a transform back to the pupil, valid until the next request to the plane.
  class Gradient {
   public:
    explicit Gradient(const DiffractionPlane& plane) : plane_(plane) {}
    Eigen::ArrayXd over_phases() const;                      ///< at every pupil point [1/rad]
    Eigen::ArrayXd over_heights(double factor = 1.0) const;  ///< times `factor` [1/m]

   private:
    double over_phase(Eigen::Index k) const;
    const DiffractionPlane& plane_;
  };
  /// Gradient of energy(radius): one transform, two for a new radius. remember: keeps the kernel for later.
  Gradient energy_gradient(double radius, bool remember = false);
  /// Gradient of the sum of `weights` times the values of `otf`: two transforms.
  Gradient sum_gradient(const Eigen::ArrayXd& weights);
  /// Gradient of Re sum_m (g_x C_(m,0) + g_y C_(0,m)), m >= 0: one transform.
  Gradient axis_gradient(const Eigen::ArrayXcd& g_x, const Eigen::ArrayXcd& g_y);
  /// d energy(radius)/d dz: the phases change with dz, and the PSF scales with f + dz.
  double energy_slope(double radius, const Eigen::ArrayXd& over_phases) const;

 private:
  void correlate_along_axes();
  void build_kernel(const Eigen::ArrayXd& weights, AlignedArray* kernel);

  const DiffractionScene& scene_;
  const DiffractionGrid& grid_;
  PupilTransform::Buffers& buffers_;
  FocusedField& focused_;
  double unit_ = 0;
};

}  // namespace aberfit::internal
