#pragma once
#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"

namespace aberfit::internal {

/// The `psd` block, without its model, that the options of `aberfit psd FILE...` stand for. Throws InputError
/// for a text that is no value of its key. read_measured checks which keys are allowed.
nlohmann::ordered_json psd_options_block(const CommandLine& line);

}  // namespace aberfit::internal
