#pragma once
#include "aberfit/study/study.h"
#include "visitor.h"

namespace aberfit::internal {

/// Shows every key of the study format, version 1, with its place in `study`, to the visitor: the one
/// description of the format. Called on the root object.
void describe_study(Visitor& v, Study& study);

}  // namespace aberfit::internal
