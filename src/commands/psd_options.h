#pragma once
#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"

namespace aberfit::internal {

/// The `psd` block, without its model, that the options of `aberfit psd FILE...` stand for. Throws InputError
/// for texts that are no value of their key; what the keys may be is for read_measured to say.
nlohmann::ordered_json psd_options_block(const CommandLine& line);

}  // namespace aberfit::internal
