#include "aberfit/scene/light.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace aberfit {

Light::Light(std::vector<LightLine> lines) : lines_(std::move(lines)) {
  double all = 0;
  for (const LightLine& line : lines_) {
    if (!(line.wavelength > 0 && line.share > 0 && std::isfinite(line.wavelength + line.share)))
      throw std::invalid_argument("wavelengths and their shares must be positive and finite");
    all += line.share;
  }
  if (lines_.empty()) throw std::invalid_argument("light needs at least one wavelength");
  for (LightLine& line : lines_) line.share /= all;
}

double Light::mean_wavelength() const {
  if (!is_band()) return lines_.front().wavelength;
  double sum = 0;
  for (const LightLine& line : lines_) sum += line.share * line.wavelength;
  return sum;
}

double Light::shortest() const {
  double least = lines_.front().wavelength;
  for (const LightLine& line : lines_) least = std::min(least, line.wavelength);
  return least;
}

double Light::longest() const {
  double most = lines_.front().wavelength;
  for (const LightLine& line : lines_) most = std::max(most, line.wavelength);
  return most;
}

Light& Light::operator*=(double ratio) {
  for (LightLine& line : lines_) line.wavelength *= ratio;
  return *this;
}

Light band_of_light(double from, double to, int count) {
  std::vector<LightLine> lines;
  for (int k = 0; k < count; ++k) lines.push_back({from + (to - from) * (k + 0.5) / count, 1.0 / count});
  return Light(std::move(lines));
}

}  // namespace aberfit
