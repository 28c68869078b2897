#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/k_correlation.h"
#include "aberfit/roughness/psd_integrals.h"
#include "log_slope.h"
#include "one_minus.h"
#include "power_waves.h"
#include "square.h"

// PsdRules of each PSD model. The concept PsdModelType at the end lists all that a model needs, so a model
// that lacks a part does not compile.
namespace aberfit::internal {

/// A number of a model, with d ln S/dp inside the band for a given factor. That of heights, of ends of the
/// band and of tables is the same for all models (psd_derivative.cpp).
struct ModelNumber : PsdMember {
  LogSlope slope;
};
using ModelNumbers = std::vector<ModelNumber>;

template <class Value>
struct TypedNumber {
  TypedNumber(const char* a_key, PsdRole a_role, Value& a_value, const LogSlope& a_slope)
      : key(a_key), role(a_role), value(a_value), slope(a_slope) {}
  const char* key;
  PsdRole role;
  Value& value;
  LogSlope slope;
};
auto rms_of(auto& value) { return TypedNumber("rms", PsdRole::kRms, value, {}); }
inline auto lowest(double& value) { return TypedNumber("f_min", PsdRole::kLowest, value, {}); }
inline auto highest(double& value) { return TypedNumber("f_max", PsdRole::kHighest, value, {}); }

inline std::span<double> values_of(double& value) { return {&value, 1}; }
inline std::span<double> values_of(std::vector<double>& values) { return values; }
inline std::span<double> values_of(std::optional<double>& value) {
  return value ? std::span(&*value, 1) : std::span<double>();
}
template <class Model, class... Values>
ModelNumbers all_numbers(const Model&, const TypedNumber<Values>&... numbers) {
  static_assert(sizeof(Model) == (sizeof(Values) + ...), "every number of a PSD model belongs to its list");
  return {ModelNumber{{numbers.key, numbers.role, values_of(numbers.value)}, numbers.slope}...};
}

/// A model in a band, times a factor.
struct PsdPiece {
  double factor, f_min, f_max;
  bool has_no_ends() const { return !(f_min > 0 || std::isfinite(f_max)); }
};

inline bool is_positive(double x) { return x > 0 && std::isfinite(x); }  // NaN is not

/// int_1^q t^(p-1) dt = (q^p - 1)/p, without cancellation for p near 0 or q near 1; q may be infinite (p <
/// 0).
inline double power_integral(double p, double log_q) { return p == 0 ? log_q : std::expm1(p * log_q) / p; }

/// The model in a narrower band, where its S does not change.
template <class Model>
std::optional<PsdModel> narrowed(Model m, double f_min, double f_max);

template <class Model>
struct PsdRules;
template <class Model>
constexpr PsdRules<Model> rules(const Model&) {
  return {};
}

template <>
struct PsdRules<UniformPsd> {
  using Model = UniformPsd;
  static ModelNumbers numbers(Model& m) {
    return all_numbers(m, rms_of(m.rms), lowest(m.f_min), highest(m.f_max));
  }
  static std::string problem(const Model& m) {
    return std::isfinite(m.f_max)
               ? ""
               : "a uniform PSD needs a finite f_max: its height variance grows without bound";
  }
  static double shape(const Model&, double) { return 1.0; }
  static double factor(const Model& m) {
    return square(m.rms) / (kPi * (m.f_max - m.f_min) * (m.f_max + m.f_min));
  }
  static PowerTerm low_term(const Model&) { return {1.0, 0.0}; }
  static PowerTerm high_term(const Model&) { return {0.0, 0.0}; }
  static std::vector<double> bends(const Model&) { return {}; }
  static double mean_slope(const Model&, const LogSlope&) { return 0; }
  static constexpr auto cut = narrowed<Model>;
  static std::optional<double> structure(const Model&, const PsdPiece& in, double r) {
    // For narrow bands the difference of the discs would lose digits.
    if (in.f_max - in.f_min < 0.1 * in.f_max) return std::nullopt;
    const auto disc = [r](double f) { return kPi * f * f * one_minus_jinc(2 * kPi * r * f); };
    return in.factor * (disc(in.f_max) - disc(in.f_min));
  }
  static std::vector<PowerStretch> stretches(const Model&, const PsdPiece& in) {
    return {PowerStretch(in.f_min, in.f_max, 0)};
  }
  static std::string formula(const Model& m, double) {
    return fmt::format("# PSD: S2(f) = {:.9g} m^4 for {}\n", RadialPsd(m)(0.5 * (m.f_min + m.f_max)),
                       band_text(m.f_min, m.f_max));
  }
};

template <>
struct PsdRules<KCorrelationPsd> {
  using Model = KCorrelationPsd;
  static ModelNumbers numbers(Model& m) {
    return all_numbers(m, rms_of(m.rms),
                       TypedNumber("B", PsdRole::kLength, m.correlation,
                                   {.knee = -m.exponent / m.correlation, .correlation = m.correlation}),
                       TypedNumber("exponent", PsdRole::kExponent, m.exponent,
                                   {.log_knee = -0.5, .correlation = m.correlation}),
                       lowest(m.f_min), highest(m.f_max));
  }
  static std::string problem(const Model& m) {
    if (!is_positive(m.correlation))
      return fmt::format("B is {:g} m, it must be positive and finite", m.correlation);
    if (!is_positive(m.exponent))
      return fmt::format("the exponent is {:g}, it must be positive and finite", m.exponent);
    if (std::isinf(m.f_max) && !(m.exponent > 2))
      return fmt::format(
          "without f_max the 2-D exponent must be greater than 2 for a finite height variance, it is {:g}",
          m.exponent);
    return "";
  }
  static double shape(const Model& m, double f) {
    return std::exp(-0.5 * m.exponent * std::log1p(square(m.correlation * f)));
  }
  static double factor(const Model& m) {
    // With v = 1 + (B f)^2 the height variance is pi/B^2 int v^(-c/2) dv.
    const double v_min = 1 + square(m.correlation * m.f_min);
    const double step = square(m.correlation) * (m.f_max - m.f_min) * (m.f_max + m.f_min);
    const double p = 1 - 0.5 * m.exponent;
    const double integral = std::pow(v_min, p) * power_integral(p, std::log1p(step / v_min));
    return square(m.rms) / (kPi / square(m.correlation) * integral);
  }
  static PowerTerm low_term(const Model&) { return {1.0, 0.0}; }
  static PowerTerm high_term(const Model& m) { return {1.0, m.exponent, 1 / m.correlation}; }
  static std::vector<double> bends(const Model& m) { return {1 / m.correlation}; }
  static double mean_slope(const Model& m, const LogSlope& slope) {
    // With v = 1 + (B f)^2 = exp(w) the height variance is int v^(p - 1) dv = int exp(p w) dw, p = 1 - c/2.
    const double p = 1 - 0.5 * m.exponent;
    const double low = std::log1p(square(m.correlation * m.f_min)),
                 high = std::isfinite(m.f_max) ? std::log1p(square(m.correlation * m.f_max)) : kInfinity;
    const double all = exponential_integral(0, p, low, high);
    double sum = 0;
    if (slope.log_knee != 0) sum += slope.log_knee * exponential_integral(1, p, low, high) / all;
    if (slope.knee != 0) sum += slope.knee * (1 - exponential_integral(0, p - 1, low, high) / all);
    return sum;
  }
  static constexpr auto cut = narrowed<Model>;
  static std::optional<double> structure(const Model& m, const PsdPiece& in, double r) {
    const double nu = 0.5 * m.exponent - 1;
    if (!in.has_no_ends() || nu > 60) return std::nullopt;  // K_nu overflows for larger nu
    return kPi * in.factor / (square(m.correlation) * nu) * one_minus_matern(nu, 2 * kPi * r / m.correlation);
  }
  static std::vector<PowerStretch> stretches(const Model&, const PsdPiece&) { return {}; }
  static std::string formula(const Model& m, double wavelength) {
    const double f = std::max(m.f_min, std::min(1 / m.correlation, m.f_max));
    const double a = RadialPsd(m)(f) * std::pow(1 + std::pow(m.correlation * f, 2), 0.5 * m.exponent);
    const Model whole = k_correlation_model({a, m.correlation, m.exponent}, 0, 1 / wavelength);
    return fmt::format(
        "# PSD: S2(f) = A / (1 + (B f)^2)^(C/2) for {}, A = {:.9g} um^4, B = {:.9g} um, C = {:.9g}; "
        "two-sided, two-dimensional, of heights of the surface\n"
        "# PSD: of K-correlation models by sigma, B, s (s = C) from f = 0 to 1/wavelength, sigma = {:.9g} m. "
        "A program without a lowest frequency would scatter all of it; the band above has {:.9g} m\n",
        band_text(m.f_min, m.f_max), a * 1e24, m.correlation * 1e6, m.exponent, whole.rms, m.rms);
  }
};

template <>
struct PsdRules<PowerLawPsd> {
  using Model = PowerLawPsd;
  static ModelNumbers numbers(Model& m) {
    return all_numbers(m, rms_of(m.rms), TypedNumber("amplitude", PsdRole::kAmplitude, m.amplitude, {}),
                       TypedNumber("exponent", PsdRole::kExponent, m.exponent, {.log_f = -1}),
                       lowest(m.f_min), highest(m.f_max));
  }
  static std::string problem(const Model& m) {
    if (m.rms.has_value() == m.amplitude.has_value())
      return "a power law needs exactly one of rms and amplitude";
    if (m.amplitude && !is_positive(*m.amplitude))
      return fmt::format("the amplitude is {:g} m^4, it must be positive and finite", *m.amplitude);
    if (!std::isfinite(m.exponent)) return fmt::format("the exponent is {:g}, it must be finite", m.exponent);
    if (m.amplitude) return "";
    if (m.f_min == 0 && !(m.exponent < 2))
      return fmt::format(
          "from f_min = 0 the exponent must be less than 2 for a finite height variance, it is {:g}; give "
          "f_min or amplitude",
          m.exponent);
    if (std::isinf(m.f_max) && !(m.exponent > 2))
      return fmt::format(
          "without f_max the exponent must be greater than 2 for a finite height variance, it is {:g}; give "
          "f_max or amplitude",
          m.exponent);
    return "";
  }
  static double shape(const Model& m, double f) { return std::pow(f, -m.exponent); }
  static double factor(const Model& m) {
    if (m.amplitude) return *m.amplitude;
    const double p = 2 - m.exponent;
    const double integral = m.f_min > 0
                                ? std::pow(m.f_min, p) * power_integral(p, std::log(m.f_max / m.f_min))
                                : std::pow(m.f_max, p) / p;
    return square(*m.rms) / (2 * kPi * integral);
  }
  static PowerTerm low_term(const Model& m) { return {1.0, m.exponent}; }
  static PowerTerm high_term(const Model& m) { return {1.0, m.exponent}; }
  static std::vector<double> bends(const Model&) { return {}; }
  static double mean_slope(const Model& m, const LogSlope& slope) {
    const double p = 2 - m.exponent, low = m.f_min > 0 ? std::log(m.f_min) : -kInfinity,
                 high = std::log(m.f_max), edge = std::isfinite(high) ? high : low;
    return slope.log_f * (edge + exponential_integral(1, p, low - edge, high - edge) /
                                     exponential_integral(0, p, low - edge, high - edge));
  }
  static constexpr auto cut = narrowed<Model>;
  static std::optional<double> structure(const Model&, const PsdPiece&, double) { return std::nullopt; }
  static std::vector<PowerStretch> stretches(const Model& m, const PsdPiece& in) {
    return {PowerStretch(in.f_min, in.f_max, m.exponent)};
  }
  static std::string formula(const Model& m, double) {
    const double f = m.f_min > 0 ? m.f_min : m.f_max;
    return fmt::format("# PSD: S2(f) = {:.9g} m^4 (f / (1 /m))^-{:.9g} for {}\n",
                       m.amplitude ? *m.amplitude : RadialPsd(m)(f) * std::pow(f, m.exponent), m.exponent,
                       band_text(m.f_min, m.f_max));
  }
};

template <>
struct PsdRules<GaussianPsd> {
  using Model = GaussianPsd;
  static ModelNumbers numbers(Model& m) {
    return all_numbers(m, rms_of(m.rms),
                       TypedNumber("correlation_length", PsdRole::kLength, m.correlation_length,
                                   {.square = -2 * kPi * kPi * m.correlation_length}));
  }
  static std::string problem(const Model& m) {
    return is_positive(m.correlation_length)
               ? ""
               : fmt::format("the correlation length is {:g} m, it must be positive and finite",
                             m.correlation_length);
  }
  static double shape(const Model& m, double f) { return std::exp(-square(kPi * m.correlation_length * f)); }
  static double factor(const Model& m) { return kPi * square(m.correlation_length * m.rms); }
  static PowerTerm low_term(const Model&) { return {1.0, 0.0}; }
  static PowerTerm high_term(const Model&) { return {0.0, 0.0}; }  // falls faster than any power
  static std::vector<double> bends(const Model& m) { return {1 / (kPi * m.correlation_length)}; }
  static double mean_slope(const Model& m, const LogSlope& slope) {
    return slope.square / square(kPi * m.correlation_length);  // <f^2> = 1/(pi l)^2
  }
  // A table, whose chords err by h^2/8 of the second derivative of log S = -(pi l f)^2 in log f, 4 (pi l
  // f)^2.
  static std::optional<PsdModel> cut(const Model& m, double f_min, double f_max) {
    constexpr double kInterpolation = 1e-3;  // allowed relative error of S between the rows
    constexpr double kWidestStep = 0.3;      // in log f
    if (f_min <= 0 && std::isinf(f_max)) return m;
    const RadialPsd psd(m);
    const double scale = kPi * m.correlation_length;
    const double first = std::max(f_min, 1e-6 / scale), last = std::min(f_max, std::sqrt(60.0) / scale);
    if (!(first < last)) return std::nullopt;
    TablePsd table;
    // The second derivative grows by at most exp(2 kWidestStep) in a step; half the allowed error covers
    // that.
    for (double f = first; f < last * (1 - 1e-9);) {
      table.frequency.push_back(f);
      f *= std::exp(std::min(kWidestStep, std::sqrt(8 * 0.5 * kInterpolation) / (2 * scale * f)));
    }
    table.frequency.push_back(last);
    for (const double f : table.frequency) table.psd.push_back(psd(f));
    return table;
  }
  static std::optional<double> structure(const Model& m, const PsdPiece& in, double r) {
    if (!in.has_no_ends()) return std::nullopt;
    return -in.factor / (kPi * square(m.correlation_length)) * std::expm1(-square(r / m.correlation_length));
  }
  static std::vector<PowerStretch> stretches(const Model&, const PsdPiece&) { return {}; }
  static std::string formula(const Model& m, double) {
    return fmt::format("# PSD: S2(f) = pi l^2 sigma^2 exp(-(pi l f)^2), sigma = {:.9g} m, l = {:.9g} m\n",
                       m.rms, m.correlation_length);
  }
};

template <>
struct PsdRules<TablePsd> {
  using Model = TablePsd;
  static ModelNumbers numbers(Model& m) {
    return all_numbers(m, TypedNumber("frequency", PsdRole::kFrequency, m.frequency, {}),
                       TypedNumber("psd", PsdRole::kDensity, m.psd, {}));
  }
  static std::string problem(const Model& m) {
    if (m.frequency.size() != m.psd.size())
      return fmt::format("the table has {} frequencies but {} PSD values", m.frequency.size(), m.psd.size());
    if (m.frequency.size() < 2)
      return fmt::format("the table has {} points, at least 2 are needed", m.frequency.size());
    for (std::size_t i = 0; i < m.frequency.size(); ++i) {
      if (!is_positive(m.frequency[i]))
        return fmt::format("table point {}: the frequency is {:g} /m, it must be positive and finite", i + 1,
                           m.frequency[i]);
      if (!is_positive(m.psd[i]))
        return fmt::format("table point {}: the PSD is {:g} m^4, it must be positive and finite", i + 1,
                           m.psd[i]);
      if (i > 0 && !(m.frequency[i] > m.frequency[i - 1]))
        return fmt::format("table point {}: the frequency {:g} /m does not exceed the one before, {:g} /m",
                           i + 1, m.frequency[i], m.frequency[i - 1]);
    }
    return "";
  }
  static double shape(const Model& m, double f) {
    const auto above = std::upper_bound(m.frequency.begin(), m.frequency.end(), f);
    const std::size_t i =
        std::clamp<std::ptrdiff_t>(above - m.frequency.begin(), 1, std::ptrdiff_t(m.frequency.size()) - 1);
    const double slope = std::log(m.psd[i] / m.psd[i - 1]) / std::log(m.frequency[i] / m.frequency[i - 1]);
    return m.psd[i - 1] * std::pow(f / m.frequency[i - 1], slope);
  }
  static double factor(const Model&) { return 1.0; }
  static PowerTerm low_term(const Model&) { return {0.0, 0.0}; }  // zero outside
  static PowerTerm high_term(const Model&) { return {0.0, 0.0}; }
  static std::vector<double> bends(const Model& m) { return m.frequency; }
  static double mean_slope(const Model&, const LogSlope&) { return 0; }
  static std::optional<PsdModel> cut(const Model& m, double f_min, double f_max) {
    const RadialPsd psd(m);
    const double low = std::max(f_min, m.frequency.front()), high = std::min(f_max, m.frequency.back());
    if (!(low < high)) return std::nullopt;
    Model table;
    const auto add = [&](double f, double s) {
      table.frequency.push_back(f);
      table.psd.push_back(s);
    };
    if (low > m.frequency.front()) add(low, psd(low));
    for (std::size_t i = 0; i < m.frequency.size(); ++i)
      if (const double f = m.frequency[i]; f >= f_min && f <= f_max && (table.frequency.empty() || f > low))
        add(f, m.psd[i]);
    if (high < m.frequency.back() && high > table.frequency.back()) add(high, psd(high));
    return table;
  }
  static std::optional<double> structure(const Model&, const PsdPiece&, double) { return std::nullopt; }
  static std::vector<PowerStretch> stretches(const Model& m, const PsdPiece& in) {
    std::vector<PowerStretch> stretches;
    for (std::size_t i = 0; i + 1 < m.frequency.size(); ++i) {
      const double a = m.frequency[i], b = m.frequency[i + 1];
      if (a < in.f_max && b > in.f_min)
        stretches.emplace_back(std::max(a, in.f_min), std::min(b, in.f_max),
                               -std::log(m.psd[i + 1] / m.psd[i]) / std::log(b / a));
    }
    return stretches;
  }
  static std::string formula(const Model&, double) {
    return "# PSD: it is a table, in the file of the PSD\n";
  }
};

template <class Model>
std::optional<PsdModel> narrowed(Model m, double f_min, double f_max) {
  const RadialPsd psd(m);
  const double low = std::max(m.f_min, f_min), high = std::min(m.f_max, f_max);
  if (!(low < high)) return std::nullopt;
  for (const ModelNumber& number : rules(m).numbers(m))
    if (number.role == PsdRole::kRms)
      for (double& rms : number.values) rms = std::sqrt(radial_moment(psd, 0, f_min, f_max));
  m.f_min = low;
  m.f_max = high;
  return m;
}

/// All that a model needs. f: inside the band [cycles/m].
template <class Model>
concept PsdModelType = requires(const Model& m, Model& changed, const LogSlope& slope, const PsdPiece& in,
                                double f, double r, double wavelength) {
  // Every number with its key, role and derivative.
  { PsdRules<Model>::numbers(changed) } -> std::same_as<ModelNumbers>;
  // The problem of this model, as for psd_problem; heights and band are checked for all models alike.
  { PsdRules<Model>::problem(m) } -> std::same_as<std::string>;
  // S = factor shape(f); the factor belongs to the rms, if one is set.
  { PsdRules<Model>::shape(m, f) } -> std::same_as<double>;
  { PsdRules<Model>::factor(m) } -> std::same_as<double>;
  // Limits of the shape for f -> 0 and f -> infinity, if the band goes there; amplitude 0: it vanishes.
  { PsdRules<Model>::low_term(m) } -> std::same_as<PowerTerm>;
  { PsdRules<Model>::high_term(m) } -> std::same_as<PowerTerm>;
  // Frequencies where the shape changes its course.
  { PsdRules<Model>::bends(m) } -> std::same_as<std::vector<double>>;
  // Mean of d ln S/dp, weighted by the height variance, in closed form. It is subtracted if the rms stays
  // constant, because S is then divided by an integral over the band.
  { PsdRules<Model>::mean_slope(m, slope) } -> std::same_as<double>;
  // psd_in_band.
  { PsdRules<Model>::cut(m, f, f) } -> std::same_as<std::optional<PsdModel>>;
  // C(0) - C(r) of a piece in closed form, or nothing: then it is integrated. Stretches: where S is a power.
  { PsdRules<Model>::structure(m, in, r) } -> std::same_as<std::optional<double>>;
  { PsdRules<Model>::stretches(m, in) } -> std::same_as<std::vector<PowerStretch>>;
  { PsdRules<Model>::formula(m, wavelength) } -> std::same_as<std::string>;
};
template <class Model>
struct WithAllRules {
  static_assert(PsdModelType<Model>, "a part of this PSD model is missing from its PsdRules");
};
template <class... Models>
struct WithAllRules<std::variant<Models...>> : WithAllRules<Models>... {};
template struct WithAllRules<PsdModelOr<TablePsd>>;

}  // namespace aberfit::internal
