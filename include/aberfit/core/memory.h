#pragma once
#include <cstddef>

namespace aberfit {

/// Uninitialised memory for at least `bytes`, aligned to a cache line; from 4 MB on aligned to a huge page,
/// which the system is advised to use. The numbers of a transform's column lie a row apart, so on small pages
/// each needs its own address translation. Release it with std::free. Throws std::bad_alloc.
void* aligned_memory(std::size_t bytes);

/// Makes GNU's C library keep freed memory in the process. Blocks below 32 MB come from this memory, and only
/// more than 256 MB at its end go back to the system. A fit allocates hundreds of surface arrays, and the
/// system would map their pages each time. A program calls it once, first. The library itself does not,
/// because the memory belongs to its caller.
void keep_freed_memory();

/// The peak memory of this process so far, and the memory of the machine [bytes].
double peak_memory();
double machine_memory();

}  // namespace aberfit
