#include "expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "aberfit/core/constants.h"

namespace aberfit::internal {
namespace {

using Unary = double (*)(double);
constexpr std::array<std::pair<std::string_view, Unary>, 8> kUnary = {{
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"exp", [](double x) { return std::exp(x); }},
    {"log", [](double x) { return std::log(x); }},
    {"log10", [](double x) { return std::log10(x); }},
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"asin", [](double x) { return std::asin(x); }},
    {"abs", [](double x) { return std::abs(x); }},
}};

// Recursive descent, one function for each level of precedence.
class ExpressionParser {
 public:
  ExpressionParser(std::string_view text, const NamedValue& value_of) : text_(text), value_of_(value_of) {}

  double whole() {
    const double value = comparison();
    if (peek() != '\0') fail("an operator or the end");
    return value;
  }

 private:
  static constexpr int kDeepest = 200;  // nested parentheses and signs; a stack is finite

  double comparison() {
    const double left = sum();
    const char c = peek();
    if (c != '<' && c != '>') return left;
    ++at_;
    const bool or_equal = at_ < text_.size() && text_[at_] == '=';
    if (or_equal) ++at_;
    const double right = sum();
    return c == '<' ? (or_equal ? left <= right : left < right) : (or_equal ? left >= right : left > right);
  }
  double sum() {
    double value = product();
    for (char c = peek(); c == '+' || c == '-'; c = peek()) {
      ++at_;
      value = c == '+' ? value + product() : value - product();
    }
    return value;
  }
  double product() {
    double value = signed_power();
    for (char c = peek(); c == '*' || c == '/'; c = peek()) {
      ++at_;
      value = c == '*' ? value * signed_power() : value / signed_power();
    }
    return value;
  }
  double signed_power() {
    if (++depth_ > kDeepest) fail("fewer nested parentheses and signs");
    double value;
    if (take('-')) {
      value = -signed_power();
    } else {
      value = primary();
      if (take('^')) value = std::pow(value, signed_power());
    }
    --depth_;
    return value;
  }
  double primary() {
    const char c = peek();
    if (take('(')) {
      const double value = comparison();
      if (!take(')')) fail("')'");
      return value;
    }
    if ((c >= '0' && c <= '9') || c == '.') return number();
    if (is_letter(c)) return named();
    fail("a number, a name or '('");
  }
  double number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc{}) fail("a number");
    at_ = std::size_t(end - text_.data());
    return value;
  }
  double named() {
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           (is_letter(text_[at_]) || (text_[at_] >= '0' && text_[at_] <= '9') || text_[at_] == '.'))
      ++at_;
    const std::string_view name = text_.substr(begin, at_ - begin);
    if (take('(')) return function(name);
    if (name == "pi") return kPi;
    if (name == "arcsec") return kPi / 180 / 3600;
    return value_of_(name);
  }
  double function(std::string_view name) {
    const double first = comparison();
    if (name == "min" || name == "max") {
      if (!take(',')) fail("a second value after ','");
      const double second = comparison();
      if (!take(')')) fail("')'");
      return name == "min" ? std::min(first, second) : std::max(first, second);
    }
    if (!take(')')) fail("')'");
    for (const auto& [known, apply] : kUnary)
      if (known == name) return apply(first);
    throw std::invalid_argument(fmt::format(
        "no function \"{}\"; there are sqrt, exp, log, log10, sin, cos, asin, abs, min, max", name));
  }

  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  char peek() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  [[noreturn]] void fail(const char* wanted) const {
    throw std::invalid_argument(fmt::format("{} at character {} of \"{}\"", wanted, at_ + 1, text_));
  }

  std::string_view text_;
  const NamedValue& value_of_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

double evaluate_expression(std::string_view text, const NamedValue& value_of) {
  return ExpressionParser(text, value_of).whole();
}

}  // namespace aberfit::internal
