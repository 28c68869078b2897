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

/// Results of ring searches by ring radius and step; several threads may use it.
class RingMemory {
 public:
  using Crossings = std::optional<RingCrossings>;
  bool follows = false;  ///< whether a search starts from the previous surface
  std::optional<Crossings> find(double ring, double step) {
    const std::lock_guard lock(mutex_);
    const auto at = found_.find({ring, step});
    return at == found_.end() ? std::nullopt : std::optional<Crossings>(at->second);
  }
  void keep(double ring, double step, const Crossings& crossings) {
    const std::lock_guard lock(mutex_);
    found_[{ring, step}] = crossings;
  }
  /// Call this for another surface or grid. Old results become starting values.
  void move_on() {
    if (follows && !found_.empty()) last_ = std::move(found_);
    found_.clear();
  }
  /// Crossings of the previous surface for the ring nearest in radius.
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

/// Tables of one pupil grid and data of the last surface, whose gradients often follow its values.
struct DiffractionWorkspace::Buffers {
  std::vector<DiffractionWorkspace> lines;  // for a band, one per wavelength
  internal::RingMemory rings;

  std::unique_ptr<internal::DiffractionGrid> grid;
  std::map<double, std::unique_ptr<internal::FocusedField>> planes;

  void prepare(const internal::DiffractionScene& scene);
  /// Drops the planes of another surface, but keeps the memory of those at `dz`.
  void look_at(const internal::DiffractionScene& scene, const std::vector<double>& dz);
  /// The plane at dz of the current surface, focused or not; null when memory is short. Planes of one surface
  /// are kept up to 512 MB. Only one thread may call it.
  internal::FocusedField* plane(double dz);

 private:
  // Everything that a plane depends on.
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
    std::array<double, 2> shift = {};  // shifts change the stored mean spots
    bool operator==(const Size&) const = default;
  };
  Size size_;
};

}  // namespace aberfit
