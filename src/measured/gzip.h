#pragma once
#include <string>
#include <string_view>

namespace aberfit::internal {

/// Returns true for bytes that begin as gzip does.
bool is_gzip(std::string_view bytes);

/// Returns the content of a gzip file of one member below 4 GiB, checked by its CRC. Throws InputError.
std::string unpacked_gzip(const std::string& path, std::string_view bytes);

}  // namespace aberfit::internal
