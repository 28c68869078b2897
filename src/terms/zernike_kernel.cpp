#include "zernike_kernel.h"

#include <algorithm>
#include <cstdlib>

#include "aberfit/scene/zernike.h"

#define ABERFIT_KERNEL_BODY "../terms/zernike_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {

ZernikeRows zernike_rows(const std::vector<ZernikeMode>& modes) {
  std::vector<int> count;  // rows per m
  for (const ZernikeMode mode : modes) {
    require_zernike_mode(mode);
    const int m = std::abs(mode.m), k = (mode.n - m) / 2;
    if (m >= int(count.size())) count.resize(std::size_t(m) + 1, 0);
    count[std::size_t(m)] = std::max(count[std::size_t(m)], k + 1);
  }

  ZernikeRows rows;
  rows.first.push_back(0);
  std::vector<double> lambda;  // per row
  for (int m = 0; m < int(count.size()); ++m) {
    double leading = 1.0;
    for (int k = 0; k < count[std::size_t(m)]; ++k) {
      const double s = 2.0 * k + m, kk = double(k) * k * (double(k) + m) * (double(k) + m);
      rows.recurrence.push_back(m == 0 ? 0.0 : -2.0 * m * m / (s * (s + 2.0)));
      rows.recurrence.push_back(k == 0 ? 0.0 : 16.0 * kk / (s * s * (s - 1.0) * (s + 1.0)));
      lambda.push_back(leading);
      leading *= (s + 1.0) * (s + 2.0) / (4.0 * (k + 1.0) * (k + m + 1.0));
    }
    rows.first.push_back(int(lambda.size()));
  }

  for (const ZernikeMode mode : modes) {
    const int m = std::abs(mode.m);
    const std::size_t row = std::size_t(rows.first[std::size_t(m)] + (mode.n - m) / 2);
    rows.slot.push_back(2 * row + (mode.m < 0 ? 1 : 0));
    rows.scale.push_back(zernike_norm(mode) * lambda[row]);
  }
  return rows;
}

void zernike_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, PointBlock* block) {
  ABERFIT_KERNEL(set, forward)(rows.m_max(), rows.first.data(), rows.recurrence.data(), packed, block);
}

int ZernikeRows::longest() const {
  int longest = 0;
  for (std::size_t m = 0; m + 1 < first.size(); ++m) longest = std::max(longest, first[m + 1] - first[m]);
  return longest;
}

double* lane_sums(const ZernikeRows& rows, std::vector<CacheLine>* lanes) {
  const std::size_t wanted = std::size_t(rows.longest()) * 2;
  if (lanes->size() < wanted) lanes->resize(wanted);
  return lanes->front().lane;
}

void zernike_adjoint(InstructionSet set, const ZernikeRows& rows, const PointBlock& block,
                     std::vector<CacheLine>* lanes, double* packed) {
  if (rows.rows() == 0) return;
  double* const sums = lane_sums(rows, lanes);
  ABERFIT_KERNEL(set, adjoint)(rows.m_max(), rows.first.data(), rows.recurrence.data(), block, sums, packed);
}

}  // namespace aberfit::internal
