#pragma once
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace aberfit::internal {

/// The number that all of `text` is; nothing for "0.3 to 2.9" or "about 5".
inline std::optional<double> number_of(std::string_view text) {
  double value = 0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace aberfit::internal
