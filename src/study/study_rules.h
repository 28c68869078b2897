#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Rules that join several blocks of a study, or need what its files hold. Throws InputError at the key that
/// breaks one.
void check_rules(const Study& study);

}  // namespace aberfit::internal
