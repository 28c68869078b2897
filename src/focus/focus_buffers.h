#pragma once
#include "aberfit/focus/evaluate.h"
#include "encircled_radii.h"
#include "ring_through.h"

namespace aberfit {

struct FocusWorkspace::Buffers {
  std::vector<internal::RadiusRequest> requests;
  std::vector<std::size_t> request_of;  // per statistic; its own number where it needs no radius
  internal::RadiusBuffers radii;
  std::vector<internal::RingBuffers> rings;  // per statistic, used by ring widths
  std::vector<RayGradient> ring_gradients;   // of the ring's radius, likewise
};

}  // namespace aberfit
