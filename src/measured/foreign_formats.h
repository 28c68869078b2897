#pragma once
#include <string>

namespace aberfit::internal {

/// Throws an InputError for a file of a format that is known by its first bytes or by its name, but not read:
/// what it is, and which way leads here. Returns where it is none of them.
void refuse_foreign_format(const std::string& path);

}  // namespace aberfit::internal
