#pragma once
#include "aberfit/method/frontier.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// Where the modelled part of the band ends, and what the rest would be worth. rays: of the fit.
BandUse band_use(const Task& task, const Groundwork& ground, const TermSet& terms, Eigen::Index rays);

}  // namespace aberfit
