#pragma once
#include <string>
#include <string_view>

namespace aberfit {

/// SHA-256 (FIPS 180-4) as 64 hexadecimal digits, as `sha256sum` prints it.
std::string content_hash(std::string_view bytes);

}  // namespace aberfit
