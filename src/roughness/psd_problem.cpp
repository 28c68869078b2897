#include <fmt/format.h>

#include <cmath>

#include "aberfit/roughness/psd.h"

namespace aberfit {
namespace {

constexpr double kHighestEnd = 1e30;  // largest f_max [cycles/m]; atoms correspond to 1e10

// Comparisons are negated so that NaN is a problem too.
bool positive(double x) { return x > 0 && std::isfinite(x); }

std::string rms_problem(double rms) {
  return positive(rms) ? "" : fmt::format("rms is {:g} m, it must be positive and finite", rms);
}

std::string band_problem(double f_min, double f_max) {
  if (!(f_min >= 0) || !std::isfinite(f_min))
    return fmt::format("f_min is {:g} /m, it must be finite and not negative", f_min);
  if (!(f_max > f_min))
    return fmt::format("f_max ({:g} /m) must be greater than f_min ({:g} /m)", f_max, f_min);
  // From 1e77 on, powers of f_max overflow, so integrals would be wrong without notice.
  if (std::isfinite(f_max) && f_max > kHighestEnd)
    return fmt::format(
        "f_max is {:g} /m, it must be at most {:g} /m; leave it out for a band without upper end", f_max,
        kHighestEnd);
  return "";
}

std::string first_of(std::initializer_list<std::string> problems) {
  for (const std::string& problem : problems)
    if (!problem.empty()) return problem;
  return "";
}

std::string problem(const UniformPsd& m) {
  std::string basic = first_of({rms_problem(m.rms), band_problem(m.f_min, m.f_max)});
  if (!basic.empty()) return basic;
  return std::isfinite(m.f_max)
             ? ""
             : "a uniform PSD needs a finite f_max: its height variance grows without bound";
}

std::string problem(const KCorrelationPsd& m) {
  std::string basic = first_of({rms_problem(m.rms), band_problem(m.f_min, m.f_max)});
  if (!basic.empty()) return basic;
  if (!positive(m.correlation))
    return fmt::format("B is {:g} m, it must be positive and finite", m.correlation);
  if (!positive(m.exponent))
    return fmt::format("the exponent is {:g}, it must be positive and finite", m.exponent);
  if (std::isinf(m.f_max) && !(m.exponent > 2))
    return fmt::format(
        "without f_max the 2-D exponent must be greater than 2 for a finite height variance, it is {:g}",
        m.exponent);
  return "";
}

std::string problem(const PowerLawPsd& m) {
  if (m.rms.has_value() == m.amplitude.has_value())
    return "a power law needs exactly one of rms and amplitude";
  if (m.rms && !rms_problem(*m.rms).empty()) return rms_problem(*m.rms);
  if (m.amplitude && !positive(*m.amplitude))
    return fmt::format("the amplitude is {:g} m^4, it must be positive and finite", *m.amplitude);
  if (!std::isfinite(m.exponent)) return fmt::format("the exponent is {:g}, it must be finite", m.exponent);
  std::string band = band_problem(m.f_min, m.f_max);
  if (!band.empty() || m.amplitude) return band;
  if (m.f_min == 0 && !(m.exponent < 2))
    return fmt::format(
        "from f_min = 0 the exponent must be less than 2 for a finite height variance, it is {:g}; give "
        "f_min or "
        "amplitude",
        m.exponent);
  if (std::isinf(m.f_max) && !(m.exponent > 2))
    return fmt::format(
        "without f_max the exponent must be greater than 2 for a finite height variance, it is {:g}; give "
        "f_max "
        "or amplitude",
        m.exponent);
  return "";
}

std::string problem(const GaussianPsd& m) {
  if (!rms_problem(m.rms).empty()) return rms_problem(m.rms);
  return positive(m.correlation_length)
             ? ""
             : fmt::format("the correlation length is {:g} m, it must be positive and finite",
                           m.correlation_length);
}

std::string problem(const TablePsd& m) {
  if (m.frequency.size() != m.psd.size())
    return fmt::format("the table has {} frequencies but {} PSD values", m.frequency.size(), m.psd.size());
  if (m.frequency.size() < 2)
    return fmt::format("the table has {} points, at least 2 are needed", m.frequency.size());
  for (std::size_t i = 0; i < m.frequency.size(); ++i) {
    if (!positive(m.frequency[i]))
      return fmt::format("table point {}: the frequency is {:g} /m, it must be positive and finite", i + 1,
                         m.frequency[i]);
    if (!positive(m.psd[i]))
      return fmt::format("table point {}: the PSD is {:g} m^4, it must be positive and finite", i + 1,
                         m.psd[i]);
    if (i > 0 && !(m.frequency[i] > m.frequency[i - 1]))
      return fmt::format("table point {}: the frequency {:g} /m does not exceed the one before, {:g} /m",
                         i + 1, m.frequency[i], m.frequency[i - 1]);
  }
  return "";
}

std::string problem(const SumPsd& m) {
  if (m.parts.empty()) return "a sum needs at least one part";
  for (std::size_t i = 0; i < m.parts.size(); ++i) {
    const std::string text = psd_problem(m.parts[i]);
    if (!text.empty()) return fmt::format("part {} of the sum: {}", i + 1, text);
  }
  return "";
}

}  // namespace

std::string psd_problem(const PsdModel& model) {
  return std::visit([](const auto& m) { return problem(m); }, model);
}

}  // namespace aberfit
