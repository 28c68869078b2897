#include "aberfit/roughness/psd.h"

#include <algorithm>
#include <cassert>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/roughness/psd_in_band.h"
#include "psd_models.h"
#include "square.h"

namespace aberfit {
using namespace internal;

RadialPsd::RadialPsd(const PsdModel& model) {
  assert(psd_problem(model).empty());
  std::visit(Overloaded{[&](const SumPsd& sum) {
                          for (const PsdModel& part : sum.parts) {
                            const RadialPsd flat(part);
                            parts_.insert(parts_.end(), flat.parts_.begin(), flat.parts_.end());
                          }
                        },
                        [&]<class Model>(const Model& m) {
                          Part& part = parts_.emplace_back(Part{m, rules(m).factor(m), 0, kInfinity});
                          for (const ModelNumber& number : rules(m).numbers(std::get<Model>(part.model))) {
                            const PsdRole role = number.role;
                            if (role == PsdRole::kLowest || role == PsdRole::kFrequency)
                              part.f_min = number.values.front();
                            if (role == PsdRole::kHighest || role == PsdRole::kFrequency)
                              part.f_max = number.values.back();
                          }
                        }},
             model);
  find_band();
}

void RadialPsd::find_band() {
  breakpoints_.clear();
  f_min_ = parts_.empty() ? 0 : kInfinity;
  f_max_ = 0;
  for (const Part& part : parts_) {
    f_min_ = std::min(f_min_, part.f_min);
    f_max_ = std::max(f_max_, part.f_max);
    std::vector<double> bends = std::visit([](const auto& m) { return rules(m).bends(m); }, part.model);
    bends.insert(bends.end(), {part.f_min, part.f_max});
    for (const double f : bends)
      if (f >= part.f_min && f <= part.f_max && f > 0 && std::isfinite(f)) breakpoints_.push_back(f);
  }
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
}

double RadialPsd::operator()(double f) const {
  double sum = 0;
  for (const Part& part : parts_)
    if (f >= part.f_min && f <= part.f_max)
      sum += part.factor * std::visit([f](const auto& m) { return rules(m).shape(m, f); }, part.model);
  return sum;
}

RadialPsd RadialPsd::scaled(double height_factor) const {
  RadialPsd result = *this;
  for (Part& part : result.parts_) part.factor *= square(height_factor);
  return result;
}

RadialPsd RadialPsd::band(double f_min, double f_max) const {
  RadialPsd result;
  for (Part part : parts_) {
    part.f_min = std::max(part.f_min, f_min);
    part.f_max = std::min(part.f_max, f_max);
    if (part.f_min < part.f_max) result.parts_.push_back(part);
  }
  result.find_band();
  return result;
}

std::vector<PowerTerm> RadialPsd::low_frequency_terms() const {
  std::vector<PowerTerm> terms;
  for (const Part& part : parts_)
    if (part.f_min == 0) {
      PowerTerm term = std::visit([](const auto& m) { return rules(m).low_term(m); }, part.model);
      term.amplitude *= part.factor;
      terms.push_back(term);
    }
  return terms;
}

std::vector<PowerTerm> RadialPsd::high_frequency_terms() const {
  std::vector<PowerTerm> terms;
  for (const Part& part : parts_)
    if (std::isinf(part.f_max)) {
      PowerTerm term = std::visit([](const auto& m) { return rules(m).high_term(m); }, part.model);
      term.amplitude *= part.factor;
      if (term.amplitude > 0) terms.push_back(term);
    }
  return terms;
}

std::vector<PsdMember> psd_members(PsdModel& model) {
  return std::visit(Overloaded{[](SumPsd&) { return std::vector<PsdMember>(); },
                               [](auto& m) {
                                 const ModelNumbers numbers = rules(m).numbers(m);
                                 return std::vector<PsdMember>(numbers.begin(), numbers.end());
                               }},
                    model);
}

PsdModel scaled(PsdModel model, double heights, double frequencies) {
  if (auto* sum = std::get_if<SumPsd>(&model))
    for (PsdModel& part : sum->parts) part = scaled(part, heights, frequencies);
  const double at_high = std::visit(Overloaded{[](const SumPsd&) { return 0.0; },
                                               [](const auto& m) { return rules(m).high_term(m).exponent; }},
                                    model);
  for (const PsdMember& member : psd_members(model))
    for (double& x : member.values) switch (member.role) {
        case PsdRole::kRms:
          x *= heights;
          break;
        case PsdRole::kAmplitude:
          x *= heights * heights * std::pow(frequencies, at_high - 2);
          break;
        case PsdRole::kLength:
          x /= frequencies;
          break;
        case PsdRole::kExponent:
          break;
        case PsdRole::kLowest:
        case PsdRole::kHighest:
        case PsdRole::kFrequency:
          x *= frequencies;
          break;
        case PsdRole::kDensity:
          x *= heights * heights / (frequencies * frequencies);
          break;
      }
  return model;
}

std::optional<PsdModel> psd_in_band(const PsdModel& model, double f_min, double f_max) {
  const auto sum_inside = [&](const SumPsd& sum) -> std::optional<PsdModel> {
    SumPsd inside;
    for (const PsdModel& part : sum.parts)
      if (const std::optional<PsdModel> cut = psd_in_band(part, f_min, f_max)) inside.parts.push_back(*cut);
    if (inside.parts.empty()) return std::nullopt;
    return inside.parts.size() == 1 ? inside.parts.front() : PsdModel(inside);
  };
  return std::visit(Overloaded{sum_inside, [&](const auto& m) { return rules(m).cut(m, f_min, f_max); }},
                    model);
}

std::string band_text(double f_min, double f_max) {
  return std::isinf(f_max) ? fmt::format("from {:.9g} /m on", f_min)
                           : fmt::format("{:.9g} to {:.9g} /m", f_min, f_max);
}

std::string psd_formula(const PsdModel& model, double wavelength) {
  return std::visit(Overloaded{[&](const SumPsd& sum) {
                                 std::string text;
                                 for (const PsdModel& part : sum.parts) text += psd_formula(part, wavelength);
                                 return text;
                               },
                               [&](const auto& m) { return rules(m).formula(m, wavelength); }},
                    model);
}

}  // namespace aberfit
