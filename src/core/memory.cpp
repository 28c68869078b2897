#include "aberfit/core/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>
#ifdef __linux__
#include <sys/mman.h>
#endif
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace aberfit {
namespace {

constexpr std::size_t kCacheLine = 64, kHugePage = std::size_t(1) << 21;

}  // namespace

void* aligned_memory(std::size_t bytes) {
  const bool large = bytes >= 2 * kHugePage;
  const std::size_t boundary = large ? kHugePage : kCacheLine;
  if (bytes > std::size_t(PTRDIFF_MAX) - boundary) throw std::bad_alloc();
  const std::size_t whole = std::max((bytes + boundary - 1) / boundary, std::size_t(1)) * boundary;
  void* const memory = std::aligned_alloc(boundary, whole);
  if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  // Only whole pages inside the block. This is advice; without it everything works.
  if (large) madvise(memory, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
  return memory;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
  return double(usage.ru_maxrss);
#else
  return 1024.0 * double(usage.ru_maxrss);
#endif
}

double machine_memory() { return double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE)); }

void keep_freed_memory() {
#ifdef __GLIBC__
  if (mallopt(M_MMAP_THRESHOLD, 32 << 20)) mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

}  // namespace aberfit
