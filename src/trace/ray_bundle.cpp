#include "aberfit/trace/ray_bundle.h"

#include <algorithm>
#include <atomic>
#include <cassert>

#include "aberfit/core/parallel.h"
#include "aberfit/trace/nominal_surface.h"
#include "trace_kernel.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr Eigen::Index kChunk = 16384;  // number of rays that a thread takes at a time
constexpr int kPadding = 8;             // kernels need multiples of this number of rays

// Traces one run of at most kTraceBlock rays; a rest that does not fill a vector goes through padded copies.
int trace_some(InstructionSet set, const Mirror& mirror, const PupilSample& pupil, const SurfaceField* field,
               Eigen::Index begin, int count, RayBundle* rays) {
  const auto at = [begin](const Eigen::ArrayXd& a) { return a.data() + begin; };
  const FieldRun run = field ? FieldRun{at(field->height), at(field->slope_x), at(field->slope_y)}
                             : FieldRun{nullptr, nullptr, nullptr};
  const RayRun out{rays->x.data() + begin, rays->y.data() + begin, rays->tx.data() + begin,
                   rays->ty.data() + begin, rays->weight.data() + begin};
  const int whole = count - count % kPadding, rest = count - whole;
  int lost = trace_run(set, mirror, whole, at(pupil.x), at(pupil.y), at(pupil.weight), run, out);
  if (rest == 0) return lost;
  double in[6][kPadding] = {}, traced[5][kPadding];  // the padding is a ray at the vertex, never lost
  const double* from[6] = {at(pupil.x), at(pupil.y), at(pupil.weight), run.height, run.slope_x, run.slope_y};
  for (int a = 0; a < (field ? 6 : 3); ++a) std::copy_n(from[a] + whole, rest, in[a]);
  const FieldRun padded = field ? FieldRun{in[3], in[4], in[5]} : run;
  lost += trace_run(set, mirror, kPadding, in[0], in[1], in[2], padded,
                    {traced[0], traced[1], traced[2], traced[3], traced[4]});
  double* const to[5] = {out.x, out.y, out.tx, out.ty, out.weight};
  for (int a = 0; a < 5; ++a) std::copy_n(traced[a], rest, to[a] + whole);
  return lost;
}

// The known Zernikes of the mirror plus the surface error, which the kernels add to the rest of the mirror.
SurfaceField with_known_zernikes(const Mirror& mirror, const PupilSample& pupil, const SurfaceField* field,
                                 int threads) {
  SurfaceField sum = known_zernike_field(mirror, pupil, {threads, {}, {}});
  if (!field) return sum;
  sum.height += field->height;
  sum.slope_x += field->slope_x;
  sum.slope_y += field->slope_y;
  return sum;
}

void trace_any(const Mirror& mirror, const PupilSample& pupil, const SurfaceField* field, int threads,
               RayBundle* rays) {
  if (!mirror.zernike.empty()) {
    const SurfaceField sum = with_known_zernikes(mirror, pupil, field, threads);
    return trace_any(without_known_zernikes(mirror), pupil, &sum, threads, rays);
  }
  const Eigen::Index n = pupil.size();
  assert(!field || field->size() == n);
  for (Eigen::ArrayXd* a : {&rays->x, &rays->y, &rays->tx, &rays->ty, &rays->weight}) a->resize(n);
  const InstructionSet set = best_instruction_set();
  std::atomic<Eigen::Index> lost = 0;  // integers: the order of the chunks does not matter
  parallel_for(std::size_t((n + kChunk - 1) / kChunk), threads, [&](std::size_t chunk) {
    const Eigen::Index first = Eigen::Index(chunk) * kChunk, end = std::min(n, first + kChunk);
    Eigen::Index lost_here = 0;
    for (Eigen::Index begin = first; begin < end; begin += kTraceBlock)
      lost_here += trace_some(set, mirror, pupil, field, begin,
                              int(std::min<Eigen::Index>(kTraceBlock, end - begin)), rays);
    lost += lost_here;
  });
  rays->lost = lost;
}

}  // namespace

RayBundle trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field) {
  RayBundle rays;
  trace_any(mirror, pupil, &field, 1, &rays);
  return rays;
}

void trace(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field, int threads,
           RayBundle* rays) {
  trace_any(mirror, pupil, &field, threads, rays);
}

RayBundle trace_nominal(const Mirror& mirror, const PupilSample& pupil, int threads) {
  RayBundle rays;
  trace_any(mirror, pupil, nullptr, threads, &rays);
  return rays;
}

void trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                   const RayGradient& gradient, SurfaceField* result) {
  if (!mirror.zernike.empty()) {
    const SurfaceField sum = with_known_zernikes(mirror, pupil, &field, 1);
    return trace_adjoint(without_known_zernikes(mirror), pupil, sum, gradient, result);
  }
  const Eigen::Index n = gradient.all_rays ? pupil.size() : Eigen::Index(gradient.rays.size());
  assert(field.size() == pupil.size());
  for ([[maybe_unused]] const auto* d : {&gradient.d_x, &gradient.d_y, &gradient.d_tx, &gradient.d_ty})
    assert(d->empty() || Eigen::Index(d->size()) == n);
  result->resize(n);
  const InstructionSet set = best_instruction_set();
  // Inputs and outputs of the kernel, gathered in blocks that stay in the first-level cache.
  enum { kX, kY, kHeight, kSlopeX, kSlopeY, kDx, kDy, kDtx, kDty, kArrays };
  const double* const point[5] = {pupil.x.data(), pupil.y.data(), field.height.data(), field.slope_x.data(),
                                  field.slope_y.data()};
  constexpr int kBlock = 256;
  alignas(64) double in[kArrays][kBlock], out[3][kBlock];
  for (Eigen::Index begin = 0; begin < n; begin += kBlock) {
    const int count = int(std::min<Eigen::Index>(kBlock, n - begin));
    const int padded = (count + kPadding - 1) / kPadding * kPadding;
    for (auto& array : in) std::fill(array + count, array + padded, 0.0);
    for (int a = 0; a < 5; ++a) {
      if (gradient.all_rays) {
        std::copy_n(point[a] + begin, count, in[a]);
      } else {
        for (int k = 0; k < count; ++k) in[a][k] = point[a][gradient.rays[std::size_t(begin + k)]];
      }
    }
    const auto component = [&](const std::vector<double>& from, int to) {
      if (from.empty())
        std::fill_n(in[to], count, 0.0);
      else
        std::copy_n(from.data() + begin, count, in[to]);
    };
    component(gradient.d_x, kDx);
    component(gradient.d_y, kDy);
    component(gradient.d_tx, kDtx);
    component(gradient.d_ty, kDty);
    if (gradient.dz != 0.0) {
      for (int k = 0; k < count; ++k) in[kDtx][k] += gradient.dz * in[kDx][k];
      for (int k = 0; k < count; ++k) in[kDty][k] += gradient.dz * in[kDy][k];
    }
    adjoint_run(set, mirror, padded, in[kX], in[kY], {in[kHeight], in[kSlopeX], in[kSlopeY]},
                {in[kDx], in[kDy], in[kDtx], in[kDty], out[0], out[1], out[2]});
    std::copy_n(out[0], count, result->height.data() + begin);
    std::copy_n(out[1], count, result->slope_x.data() + begin);
    std::copy_n(out[2], count, result->slope_y.data() + begin);
  }
}

SurfaceField trace_adjoint(const Mirror& mirror, const PupilSample& pupil, const SurfaceField& field,
                           const RayGradient& gradient) {
  SurfaceField result;
  trace_adjoint(mirror, pupil, field, gradient, &result);
  return result;
}

}  // namespace aberfit
