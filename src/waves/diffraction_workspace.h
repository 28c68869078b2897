#pragma once
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "aberfit/waves/diffraction_psf.h"
#include "diffraction_plane.h"
#include "ring_search.h"

namespace aberfit {
namespace internal {

/// Searches of N(z) by ring radius and step; used by several threads.
class RingMemory {
 public:
  using Crossings = std::optional<RingCrossings>;
  bool follows = false;  ///< from one surface to the next
  std::optional<Crossings> find(double ring, double step) {
    const std::lock_guard lock(mutex_);
    const auto at = found_.find({ring, step});
    return at == found_.end() ? std::nullopt : std::optional<Crossings>(at->second);
  }
  void keep(double ring, double step, const Crossings& crossings) {
    const std::lock_guard lock(mutex_);
    found_[{ring, step}] = crossings;
  }
  /// For another surface or grid. What was found stays as the guess from which to follow.
  void move_on() {
    if (follows && !found_.empty()) last_ = std::move(found_);
    found_.clear();
  }
  /// Of the last surface that had any, for the ring that is the nearest to this one.
  Crossings near(double ring) const {
    constexpr double kAlike = 1.2;
    Crossings nearest;
    double least = kAlike;
    for (const auto& [key, crossings] : last_) {
      const double ratio = std::max(key.first / ring, ring / key.first);
      if (crossings && ratio < least) nearest = crossings, least = ratio;
    }
    return nearest;
  }

 private:
  std::mutex mutex_;
  std::map<std::pair<double, double>, Crossings> found_, last_;
};

}  // namespace internal

/// Tables of one pupil grid, and what is known of the surface that was looked at last: gradients are wanted
/// where values just were.
struct DiffractionWorkspace::Buffers {
  std::vector<DiffractionWorkspace> lines;  // of a band, one for each wavelength
  internal::RingMemory rings;

  std::unique_ptr<internal::DiffractionGrid> grid;
  std::map<double, std::unique_ptr<internal::FocusedField>> planes;

  void prepare(const internal::DiffractionScene& scene);
  /// Forgets the planes of another surface, all but the memory of those at `dz`.
  void look_at(const internal::DiffractionScene& scene, const std::vector<double>& dz);
  /// The plane at dz of the surface that is looked at, focused or not; null when memory for it is not to be
  /// had: planes of one surface are kept up to 512 MB. Not for several threads.
  internal::FocusedField* plane(double dz);

 private:
  // All that a plane is a function of.
  struct Surface {
    double focal_length = 0, wavelength = 0, pitch_x = 0, pitch_y = 0, total = 0;
    CartesianGrid grid;
    Eigen::ArrayXcd base;
    Eigen::ArrayXd versine;
    bool is(const internal::DiffractionScene& scene) const;
  };
  Surface surface_;
  double kept_ = 0;  // bytes of planes
  struct Size {
    int rows = 0, columns = 0;
    internal::Precision precision = internal::Precision::kDouble;
    double pitch_x = 0, pitch_y = 0, longest_lag = 0;
    std::shared_ptr<const MeanScatter> scatter = {};
    std::array<double, 2> shift = {};  // moves what is known of the mean
    bool operator==(const Size&) const = default;
  };
  Size size_;
};

}  // namespace aberfit
