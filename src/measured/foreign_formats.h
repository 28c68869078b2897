#pragma once
#include <string>

namespace aberfit::internal {

/// Throws InputError for a known format that we do not read, with a way to convert it. Returns otherwise.
void refuse_foreign_format(const std::string& path);

}  // namespace aberfit::internal
