#include "describe_verify.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "aberfit/study/published.h"
#include "describe_names.h"

namespace aberfit::internal {
namespace {

void describe(Visitor& v, PhaseSynthesis& phase) {
  v.quantity({"psd_level", "P0 as printed"}, phase.psd_level, kNumber, Range::positive());
  v.integer({"modes", "number of modes"}, phase.modes, 1, 100000000);
  v.quantity({"f_min", "lower edge of the modes [cycles/m]"}, phase.f_min, kFrequency, Range::positive());
  v.quantity({"f_max", "upper edge of the modes [cycles/m]"}, phase.f_max, kFrequency, Range::positive());
  v.check(phase.f_min < phase.f_max, "f_max", format_quantity(phase.f_max, kFrequency),
          "a spatial frequency above f_min = " + format_quantity(phase.f_min, kFrequency));
}

void describe(Visitor& v, IndependentTerms& terms) {
  v.integer({"n_max", "highest radial order; the lowest is 2"}, terms.n_max, 2, 300);
  v.quantity({"rms", "total RMS height [m]"}, terms.rms, kLength, Range{0, 1e-2, true, false});
  v.integer({"draws", "number of draws"}, terms.draws, 1, 1000000);
}

void describe(Visitor& v, FormulaInputs& inputs) {
  v.quantity({"gradient_x", "RMS phase gradient along x [rad/m]"}, inputs.gradient_x, kNumber,
             Range::non_negative());
  v.quantity({"gradient_y", "RMS phase gradient along y [rad/m]"}, inputs.gradient_y, kNumber,
             Range::non_negative());
  v.quantity({"wavelength", "[m]; absent: the study's"}, inputs.wavelength, kLength, Range{1e-12, 1e-2});
  v.quantity({"focal_length", "[m]; absent: the study's"}, inputs.focal_length, kLength, Range::positive());
  v.quantity({"diameter", "[m]; absent: the study's"}, inputs.diameter, kLength, Range::positive());
  v.quantity({"rms", "RMS height [m]"}, inputs.rms, kLength, Range::positive());
  v.quantity({"correlation_length", "[m]"}, inputs.correlation_length, kLength, Range::positive());
  v.quantity({"f_min", "[cycles/m]"}, inputs.f_min, kFrequency, Range::non_negative());
  v.quantity({"f_max", "[cycles/m]"}, inputs.f_max, kFrequency, Range::positive());
}

void describe(Visitor& v, PublishedNumber& number) {
  static const std::string formulas = fmt::format("{}", fmt::join(published_formulas(), ", "));
  static const std::string meaning = "formula to evaluate on inputs: " + formulas;
  v.text({"label", "what it is called there", Need::kRequired, "\"EE90 (HS)\""}, number.label, false);
  v.text({"quantity", "name of a quantity of the verify result; this, formula, or neither (reading only)",
          Need::kOptional, "\"harvey_shack.ee90_radius_m\""},
         number.quantity, true);
  v.text({"formula", meaning.c_str(), Need::kOptional, "\"mean_deflection\""}, number.formula, true);
  const auto& names = published_formulas();
  v.check(number.formula.empty() || std::find(names.begin(), names.end(), number.formula) != names.end(),
          "formula", '"' + number.formula + '"', formulas);
  v.check(number.formula.empty() || number.quantity.empty(), "formula", "a formula beside a quantity",
          "one of quantity and formula");
  v.object({"inputs", "what the formula works on"}, nullptr, [&](Visitor& i) { describe(i, number.inputs); });
  v.quantity({"value", "as printed", Need::kRequired, "76"}, number.value, kNumber, Range::any());
  v.text({"unit", "as printed", Need::kOptional, "\"um\""}, number.unit, true);
  v.quantity({"scale", "printed value times scale is the SI value", Need::kOptional, "1e-6"}, number.scale,
             kNumber, Range::any());
  v.check(number.scale != 0, "scale", "0", "a factor other than 0");
  v.text({"reading", "what holds and what does not, in a sentence"}, number.reading, true);
}

}  // namespace

void describe_verify(Visitor& v, VerifySpec& verify) {
  v.object({"verify", "what `verify` sets beside our own numbers"}, nullptr, [&](Visitor& w) {
    bool phase = verify.aside.published_phase.has_value();
    w.object({"published_phase", "phase synthesis by the published formula"}, &phase, [&](Visitor& p) {
      if (!verify.aside.published_phase) verify.aside.published_phase.emplace();
      describe(p, *verify.aside.published_phase);
    });
    bool terms = verify.aside.independent_terms.has_value();
    w.object({"independent_terms", "Zernikes drawn independently with equal variance"}, &terms,
             [&](Visitor& t) {
               if (!verify.aside.independent_terms) verify.aside.independent_terms.emplace();
               describe(t, *verify.aside.independent_terms);
             });
    std::vector<PublishedNumber>& numbers = verify.published;
    w.list(
        {"published", "printed numbers"}, numbers.size(), 0,
        [&](std::size_t count) { numbers.resize(count); },
        [&](Visitor& p, std::size_t i) { describe(p, numbers[i]); });
  });
}

}  // namespace aberfit::internal
