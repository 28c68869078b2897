#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"

namespace aberfit::internal {

/// Statistics in two lists with their original indices: those that waves compute themselves, and those that
/// are properties of the traced surface.
struct SplitStatistics {
  std::vector<Statistic> own, geometric;
  std::vector<std::size_t> own_place, geometric_place;

  template <typename Predicate>
  SplitStatistics(const std::vector<Statistic>& all, const Predicate& is_geometric) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const bool rays = is_geometric(all[k]);
      (rays ? geometric : own).push_back(all[k]);
      (rays ? geometric_place : own_place).push_back(k);
    }
  }
};

}  // namespace aberfit::internal
