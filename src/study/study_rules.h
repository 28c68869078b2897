#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Checks rules that join several blocks of a study or need the contents of its files. Throws InputError at
/// the key that breaks one.
void check_rules(const Study& study);

}  // namespace aberfit::internal
