#include "diffraction_workspace.h"

#include <algorithm>
#include <cmath>

namespace aberfit {
using namespace internal;

namespace {

constexpr double kMostKept = 512e6;  // bytes

template <typename Array>
bool same(const Array& a, const Array& b) {
  return a.size() == b.size() && (a == b).all();
}

}  // namespace

DiffractionWorkspace::DiffractionWorkspace() : buffers_(std::make_unique<Buffers>()) {}
DiffractionWorkspace::~DiffractionWorkspace() = default;
void DiffractionWorkspace::follow_rings() { buffers_->rings.follows = true; }
DiffractionWorkspace::DiffractionWorkspace(DiffractionWorkspace&&) noexcept = default;
DiffractionWorkspace& DiffractionWorkspace::operator=(DiffractionWorkspace&&) noexcept = default;

bool DiffractionWorkspace::Buffers::Surface::is(const DiffractionScene& scene) const {
  const DiffractionProblem& problem = scene.problem();
  return focal_length == problem.focal_length && wavelength == problem.wavelength &&
         pitch_x == problem.pupil.pitch_x && pitch_y == problem.pupil.pitch_y && total == scene.total() &&
         same(base, scene.base()) && same(versine, scene.versine()) && same(grid.x, scene.grid().x) &&
         same(grid.y, scene.grid().y) && grid.row == scene.grid().row && grid.column == scene.grid().column;
}

const DiffractionGrid& DiffractionWorkspace::Buffers::prepare(const DiffractionScene& scene) {
  const DiffractionProblem& problem = scene.problem();
  const auto* directions = std::get_if<DirectionGrid>(&problem.pupil.sample.structure);
  const Size wanted{scene.rows(),          scene.columns(),
                    problem.padding,       problem.pupil.pitch_x,
                    problem.pupil.pitch_y, scene.longest_lag(),
                    problem.scatter,       directions ? directions->shift : std::array<double, 2>{}};
  if (!grid || !(size_ == wanted)) {
    free.clear();
    planes_.clear();
    rings.move_on();
    surface_ = {};
    grid = std::make_unique<DiffractionGrid>(scene);
    size_ = wanted;
  }
  return *grid;
}

void DiffractionWorkspace::Buffers::look_at(const DiffractionScene& scene, const std::vector<double>& dz) {
  if (surface_.is(scene)) return;
  const DiffractionProblem& problem = scene.problem();
  surface_ = {problem.focal_length, problem.wavelength, problem.pupil.pitch_x, problem.pupil.pitch_y,
              scene.total(),        scene.grid(),       scene.base(),          scene.versine()};
  rings.move_on();
  std::erase_if(planes_,
                [&](const auto& plane) { return std::find(dz.begin(), dz.end(), plane.first) == dz.end(); });
  for (auto& [at, plane] : planes_) plane->dz = std::nan("");
}

FocusedField* DiffractionWorkspace::Buffers::plane(double dz) {
  const auto found = planes_.find(dz);
  if (found != planes_.end()) return found->second.get();
  const double bytes =
      double(grid->transform.focal_size() + 2 * std::size_t(surface_.base.size())) * sizeof(double);
  if (double(planes_.size() + 1) * bytes > kMostKept) return nullptr;
  return planes_.emplace(dz, std::make_unique<FocusedField>(grid->transform)).first->second.get();
}

}  // namespace aberfit
