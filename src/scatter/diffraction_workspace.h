#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "aberfit/scatter/diffraction_psf.h"
#include "diffraction_transform.h"

namespace aberfit {

/// Plans of one grid and one set of buffers per thread that ever worked at the same time.
struct DiffractionWorkspace::Buffers {
  std::unique_ptr<PupilTransform> transform;
  double padding = 0;
  std::vector<std::unique_ptr<PupilTransform::Buffers>> free;
  std::mutex mutex;

  const PupilTransform& prepare(int rows, int columns, double wanted_padding) {
    if (!transform || transform->rows() != rows || transform->columns() != columns ||
        padding != wanted_padding) {
      free.clear();
      transform = std::make_unique<PupilTransform>(rows, columns, wanted_padding);
      padding = wanted_padding;
    }
    return *transform;
  }
};

/// Buffers for as long as a thread needs them.
class BorrowedBuffers {
 public:
  explicit BorrowedBuffers(DiffractionWorkspace::Buffers& pool) : pool_(pool) {
    {
      const std::lock_guard lock(pool_.mutex);
      if (!pool_.free.empty()) {
        buffers_ = std::move(pool_.free.back());
        pool_.free.pop_back();
      }
    }
    if (!buffers_) buffers_ = std::make_unique<PupilTransform::Buffers>(*pool_.transform);
  }
  ~BorrowedBuffers() {
    const std::lock_guard lock(pool_.mutex);
    pool_.free.push_back(std::move(buffers_));
  }
  BorrowedBuffers(const BorrowedBuffers&) = delete;
  BorrowedBuffers& operator=(const BorrowedBuffers&) = delete;
  PupilTransform::Buffers& operator*() { return *buffers_; }

 private:
  DiffractionWorkspace::Buffers& pool_;
  std::unique_ptr<PupilTransform::Buffers> buffers_;
};

}  // namespace aberfit
