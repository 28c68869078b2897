#pragma once
#include <cstddef>

namespace aberfit {

/// Memory for at least `bytes`, not initialised, on the boundary of a cache line; of 4 MB and more on that of
/// a huge page, which the system is asked for: a transform's columns lie a row apart, and on small pages each
/// of their numbers asks for another address translation. To be given to std::free. Throws std::bad_alloc.
void* aligned_memory(std::size_t bytes);

/// Has this process keep up to 256 MB of what it frees, but for blocks above 32 MB, where the C library is
/// GNU's. Arrays of a surface are made and left by the hundred, and pages that go back to the system with
/// each cost a tenth of a fit on many cells. For a program to call, once and first: a library leaves the
/// memory of its caller alone.
void keep_freed_memory();

}  // namespace aberfit
