#include "given_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"

namespace aberfit::internal {
namespace {

struct Energy {
  double radius, share;
  std::string key, name;
};

std::string said(const Energy& one) {
  return fmt::format("{} ({:.6g} % of the energy within {})", one.name, 100 * one.share,
                     format_quantity(one.radius, Dimension::kLength));
}

}  // namespace

void check_given_energies(const std::vector<Wanted>& wanted) {
  std::map<double, std::vector<Energy>> planes;
  for (const Wanted& one : wanted) {
    if (!one.value) continue;
    const std::string key(kind_of(one.statistic).key), name = statistic_name(one.statistic);
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&one.statistic))
      planes[ee->dz].push_back({*one.value, ee->fraction, fmt::format("ee{:.6g}", 100 * ee->fraction), name});
    else if (const auto* within = std::get_if<RingThrough>(&one.statistic); within && !within->is_point)
      planes[within->dz].push_back({within->ring_radius, *one.value, key, name});
  }
  for (auto& [dz, energies] : planes) {
    std::sort(energies.begin(), energies.end(),
              [](const Energy& one, const Energy& two) { return one.share < two.share; });
    for (std::size_t k = 1; k < energies.size(); ++k) {
      const Energy &less = energies[k - 1], &more = energies[k];
      if (less.share < more.share && less.radius >= more.radius)
        throw FieldError("target.statistics." + less.key, said(less) + " beside " + said(more),
                         "radii that grow with the energy fraction inside");
    }
  }
}

}  // namespace aberfit::internal
