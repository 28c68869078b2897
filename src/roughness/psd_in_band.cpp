#include "aberfit/roughness/psd_in_band.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

constexpr double kInterpolation = 1e-3;  // allowed relative error of S between the rows of a Gaussian
constexpr double kWidestStep = 0.3;      // in log f

// log S = -(pi l f)^2 has the second derivative 4 (pi l f)^2 in log f; a chord of width h errs by h^2/8 of
// it.
TablePsd gaussian_table(const GaussianPsd& model, double f_min, double f_max) {
  const RadialPsd psd(model);
  const double scale = kPi * model.correlation_length;
  const double first = std::max(f_min, 1e-6 / scale);
  const double last = std::min(f_max, std::sqrt(60.0) / scale);
  TablePsd table;
  if (!(first < last)) return table;
  // The second derivative grows by at most exp(2 kWidestStep) in a step; half the allowed error covers that.
  for (double f = first; f < last * (1 - 1e-9);) {
    table.frequency.push_back(f);
    f *= std::exp(std::min(kWidestStep, std::sqrt(8 * 0.5 * kInterpolation) / (2 * scale * f)));
  }
  table.frequency.push_back(last);
  for (const double f : table.frequency) table.psd.push_back(psd(f));
  return table;
}

TablePsd cut_table(const TablePsd& model, double f_min, double f_max) {
  const RadialPsd psd(model);
  const double low = std::max(f_min, model.frequency.front()), high = std::min(f_max, model.frequency.back());
  TablePsd table;
  if (!(low < high)) return table;
  const auto add = [&](double f, double s) {
    table.frequency.push_back(f);
    table.psd.push_back(s);
  };
  if (low > model.frequency.front()) add(low, psd(low));
  for (std::size_t i = 0; i < model.frequency.size(); ++i)
    if (const double f = model.frequency[i]; f >= f_min && f <= f_max && (table.frequency.empty() || f > low))
      add(f, model.psd[i]);
  if (high < model.frequency.back() && high > table.frequency.back()) add(high, psd(high));
  return table;
}

struct Cutter {
  double f_min, f_max;

  std::optional<PsdModel> operator()(const UniformPsd& m) const { return inside(m, true); }
  std::optional<PsdModel> operator()(const KCorrelationPsd& m) const { return inside(m, true); }
  std::optional<PsdModel> operator()(const PowerLawPsd& m) const { return inside(m, !m.amplitude); }
  std::optional<PsdModel> operator()(const GaussianPsd& m) const {
    if (f_min <= 0 && std::isinf(f_max)) return m;
    const TablePsd table = gaussian_table(m, f_min, f_max);
    return table.frequency.empty() ? std::nullopt : std::optional<PsdModel>(table);
  }
  std::optional<PsdModel> operator()(const TablePsd& m) const {
    const TablePsd table = cut_table(m, f_min, f_max);
    return table.frequency.empty() ? std::nullopt : std::optional<PsdModel>(table);
  }
  std::optional<PsdModel> operator()(const SumPsd& m) const {
    SumPsd inside;
    for (const PsdModel& part : m.parts)
      if (const std::optional<PsdModel> cut = psd_in_band(part, f_min, f_max)) inside.parts.push_back(*cut);
    if (inside.parts.empty()) return std::nullopt;
    return inside.parts.size() == 1 ? inside.parts.front() : PsdModel(inside);
  }

 private:
  // Keeps the type of the model; S inside the band does not change.
  template <class Model>
  std::optional<PsdModel> inside(Model m, bool has_rms) const {
    const double low = std::max(m.f_min, f_min), high = std::min(m.f_max, f_max);
    if (!(low < high)) return std::nullopt;
    if (has_rms) m.rms = std::sqrt(radial_moment(RadialPsd(m), 0, f_min, f_max));
    m.f_min = low;
    m.f_max = high;
    return m;
  }
};

}  // namespace

std::optional<PsdModel> psd_in_band(const PsdModel& model, double f_min, double f_max) {
  return std::visit(Cutter{f_min, f_max}, model);
}

}  // namespace aberfit
