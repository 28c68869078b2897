#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "aberfit/core/text.h"
#include "aberfit/study/published.h"
#include "describe.h"
#include "expression.h"

namespace aberfit::internal {
namespace {

void describe(Visitor& v, PhaseSynthesis& phase) {
  v.quantity({"psd_level", "P0 as printed"}, phase.psd_level, kNumber, Range::positive());
  v.integer({"modes", "number of modes"}, phase.modes, 1, 100000000);
  v.quantity({"f_min", "lower edge of the modes [cycles/m]"}, phase.f_min, kFrequency, Range::positive());
  v.quantity({"f_max", "upper edge of the modes [cycles/m]"}, phase.f_max, kFrequency, Range::positive());
  require_band(v, phase.f_min, phase.f_max);
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

// Only the grammar: what its names mean is known once there are quantities.
void check_expression(Visitor& v, const char* key, const std::string& text) {
  std::string problem;
  try {
    if (!text.empty()) evaluate_expression(text, [](std::string_view) { return 1.0; });
  } catch (const std::invalid_argument& error) {
    problem = error.what();
  }
  v.check(problem.empty(), key, '"' + text + '"', problem);
}

std::string listed(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

// An empty text, or one of the words.
void check_word(Visitor& v, const char* key, const std::string& text, const std::vector<std::string>& words) {
  v.check(text.empty() || std::find(words.begin(), words.end(), text) != words.end(), key, '"' + text + '"',
          listed(words));
}

void describe(Visitor& v, PublishedNumber& number) {
  static const std::string meaning = "formula to evaluate on inputs: " + listed(published_formulas());
  v.text({"id", "stable key of the number", kOptional, "\"hs-ee90\""}, number.id, true);
  v.text({"section", "where it stands there"}, number.section, true);
  v.text({"label", "what it is called there", kRequired, "\"EE90 (HS)\""}, number.label, false);
  v.text({"quantity",
          "name of a quantity of the verify result; this, formula, expression, or none (reading only)",
          kOptional, "\"harvey_shack.ee90_radius_m\""},
         number.quantity, true);
  v.text({"formula", meaning.c_str(), kOptional, "\"mean_deflection\""}, number.formula, true);
  check_word(v, "formula", number.formula, published_formulas());
  v.text({"expression",
          "arithmetic on quantities of the result and on printed.ID, the printed value of another row [SI]; "
          "comparisons give 1 or 0",
          kOptional, "\"2.146*scene.focal_length_m*printed.deflection_x\""},
         number.expression, true);
  check_expression(v, "expression", number.expression);
  const int sources =
      int(!number.formula.empty()) + int(!number.quantity.empty()) + int(!number.expression.empty());
  v.check(sources < 2, number.formula.empty() ? "expression" : "formula", "more than one of them",
          "one of quantity, formula and expression");
  v.object({"inputs", "what the formula works on"}, nullptr, [&](Visitor& i) { describe(i, number.inputs); });
  v.text({"printed", "as printed, digit for digit; may be words", kOptional, "\"1.57e-5\""}, number.printed,
         true);
  v.quantity({"value", "the same as a number; absent: that of printed, if it is one", kOptional, "76"},
             number.value, kNumber, Range::any());
  const std::optional<double> printed = parse_finite(number.printed);
  v.check(!printed || !number.value || *printed == *number.value, "value",
          number.value ? fmt::format("{}", *number.value) : "", "the number in printed, " + number.printed);
  if (!number.value) number.value = printed;
  v.boolean({"derived", "not printed there, but follows from what is"}, number.derived);
  v.text({"unit", "as printed", kOptional, "\"um\""}, number.unit, true);
  v.quantity({"scale", "printed value times scale is the SI value", kOptional, "1e-6"}, number.scale, kNumber,
             Range::any());
  v.check(number.scale != 0, "scale", "0", "a factor other than 0");
  v.quantity({"within", "relative difference that still holds; absent: half of the last printed digit",
              kOptional, "0.002"},
             number.within, kNumber, Range::non_negative());
  v.text({"holds", "what has to be true instead: an expression, with ours and printed in the printed unit",
          kOptional, "\"ours < printed\""},
         number.holds, true);
  check_expression(v, "holds", number.holds);
  v.text({"verdict", "where nothing is computed, or what it is called if the comparison holds", kOptional,
          "\"reading\""},
         number.verdict, true);
  check_word(v, "verdict", number.verdict, published_verdicts());
  v.text({"picture", "name of a picture of verify that shows it", kOptional, "\"ring_through\""},
         number.picture, true);
  v.text({"reading", "what holds and what does not, in a sentence"}, number.reading, true);
}

}  // namespace

void describe_verify(Visitor& v, VerifySpec& verify) {
  v.object({"verify", "what `verify` sets beside our own numbers"}, nullptr, [&](Visitor& w) {
    w.integer({"draws",
               "surfaces drawn for the ensemble means, a multiple of 16; absent: as many as the margin needs",
               kOptional, "256"},
              verify.aside.draws, 2, 1000000);
    w.optional_object({"published_phase", "phase synthesis by the published formula"},
                      verify.aside.published_phase, describe);
    w.optional_object({"independent_terms", "Zernikes drawn independently with equal variance"},
                      verify.aside.independent_terms, describe);
    std::vector<PublishedNumber>& numbers = verify.published;
    w.list(
        {"published", "printed numbers"}, numbers.size(), 0,
        [&](std::size_t count) { numbers.resize(count); },
        [&](Visitor& p, std::size_t i) { describe(p, numbers[i]); });
  });
}

}  // namespace aberfit::internal
