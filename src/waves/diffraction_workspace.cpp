#include "diffraction_workspace.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace aberfit {
using namespace internal;

namespace {

constexpr double kMostKept = 512e6;  // bytes

double bytes_of(const DiffractionGrid& grid, Eigen::Index points) {
  const PupilTransform& transform = grid.transform;
  return double(transform.focal_size() * bytes_of_number(transform.precision())) +
         double(points) * sizeof(std::complex<double>);
}

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
  return focal_length == problem.focal_length && wavelength == double(problem.wavelength) &&
         pitch_x == problem.pupil.pitch_x && pitch_y == problem.pupil.pitch_y && total == scene.total() &&
         same(base, scene.base()) && same(versine, scene.versine()) && same(grid.x, scene.grid().x) &&
         same(grid.y, scene.grid().y) && grid.row == scene.grid().row && grid.column == scene.grid().column;
}

void DiffractionWorkspace::Buffers::prepare(const DiffractionScene& scene) {
  const DiffractionProblem& problem = scene.problem();
  const auto* directions = std::get_if<DirectionGrid>(&problem.pupil.sample.structure);
  const Precision precision = problem.single_precision ? Precision::kSingle : Precision::kDouble;
  const Size wanted{scene.rows(),
                    scene.columns(),
                    precision,
                    problem.pupil.pitch_x,
                    problem.pupil.pitch_y,
                    scene.longest_lag(),
                    problem.scatter,
                    directions ? directions->shift : std::array<double, 2>{}};
  const Eigen::ArrayXcd perfect = problem.scatter ? scene.nominal_base() : Eigen::ArrayXcd();
  if (!grid || !(size_ == wanted) || !same(grid->perfect, perfect)) {
    planes.clear();
    grid.reset();
    kept_ = 0;
    rings.move_on();
    surface_ = {};
    grid = std::make_unique<DiffractionGrid>(scene, precision);
    size_ = wanted;
  }
}

void DiffractionWorkspace::Buffers::look_at(const DiffractionScene& scene, const std::vector<double>& dz) {
  if (surface_.is(scene)) return;
  const DiffractionProblem& problem = scene.problem();
  surface_ = {problem.focal_length, problem.wavelength, problem.pupil.pitch_x, problem.pupil.pitch_y,
              scene.total(),        scene.grid(),       scene.base(),          scene.versine()};
  rings.move_on();
  kept_ = 0;
  std::erase_if(planes,
                [&](const auto& plane) { return std::find(dz.begin(), dz.end(), plane.first) == dz.end(); });
  for (auto& [at, plane] : planes) {
    plane->dz = std::nan("");
    kept_ += bytes_of(*grid, surface_.base.size());
  }
}

FocusedField* DiffractionWorkspace::Buffers::plane(double dz) {
  const auto found = planes.find(dz);
  if (found != planes.end()) return found->second.get();
  const double bytes = bytes_of(*grid, surface_.base.size());
  if (kept_ + bytes > kMostKept) return nullptr;
  kept_ += bytes;
  return planes.emplace(dz, std::make_unique<FocusedField>(grid->transform)).first->second.get();
}

}  // namespace aberfit
