#pragma once
#include <string>
#include <vector>

#include "file_purposes.h"

namespace aberfit::internal {

/// The names and symbols of this program that occur in `text`, with their meanings, for a reader who has only
/// the page.
std::vector<NamedPurpose> words_in(const std::string& text);

}  // namespace aberfit::internal
