#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// The `verify` block.
void describe_verify(Visitor& v, VerifySpec& verify);

}  // namespace aberfit::internal
