#pragma once
#include "aberfit/method/frontier.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// Returns the end of the modelled part of the band, and the effect of the rest. rays: of the fit.
BandUse band_use(const Task& task, const Groundwork& ground, const TermSet& terms, Eigen::Index rays);

}  // namespace aberfit
