#pragma once
#include "aberfit/core/errors.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Throws InputError if the study asks for central differences, which no fit can use.
inline void require_analytic_normals(const Study& study) {
  if (study.trace.central_difference_step)
    throw InputError(study.path, "/trace/normals", "central differences in a fit",
                     "\"analytic\" normals; only `verify` and `trace` allow central differences");
}

}  // namespace aberfit::internal
