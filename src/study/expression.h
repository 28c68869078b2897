#pragma once
#include <functional>
#include <string>
#include <string_view>

namespace aberfit::internal {

/// Value of a name in an expression; throws std::invalid_argument for a name that it does not know.
using NamedValue = std::function<double(std::string_view name)>;

/// Value of an arithmetic expression: numbers, names (letters, digits, '_', '.'; the constants pi and
/// arcsec), + - * / ^ and parentheses with the usual precedence (^ to the right, above a sign before it),
/// comparisons < <= > >= that give 1 or 0 and bind least, and the functions sqrt exp log log10 sin cos asin
/// abs, min and max of two. Nothing else is understood, so a study file cannot make the program do anything
/// but arithmetic. Throws std::invalid_argument with a clause on what is wrong and where.
double evaluate_expression(std::string_view text, const NamedValue& value_of);

}  // namespace aberfit::internal
