#pragma once
#include "aberfit/focus/evaluate.h"
#include "encircled_radii.h"
#include "ring_through.h"

namespace aberfit {

struct FocusWorkspace::Buffers {
  std::vector<RadiusRequest> requests;
  std::vector<std::size_t> request_of;  // per statistic; its own number where it needs no radius
  RadiusBuffers radii;
  std::vector<RingBuffers> rings;           // per statistic, used by ring widths
  std::vector<RayGradient> ring_gradients;  // of the ring's radius, likewise
};

}  // namespace aberfit
