#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit {

/// The `verify` block.
void describe_verify(Visitor& v, VerifySpec& verify);

}  // namespace aberfit
