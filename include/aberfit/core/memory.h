#pragma once
#include <cstddef>

namespace aberfit {

/// Memory for at least `bytes`, not initialised, on the boundary of a cache line; of 4 MB and more on that of
/// a huge page, which the system is asked for: a transform's columns lie a row apart, and on small pages each
/// of their numbers asks for another address translation. To be given to std::free. Throws std::bad_alloc.
void* aligned_memory(std::size_t bytes);

/// Where the C library is GNU's: blocks below 32 MB come from memory that the process has, and go back to the
/// system when more than 256 MB lie free at its end. Arrays of a surface are made and left by the hundred,
/// and pages that come and go with each cost a tenth of a fit on many cells. For a program to call, once and
/// first: a library leaves the memory of its caller alone.
void keep_freed_memory();

/// The most memory that this process has held so far, and the memory of the machine [bytes].
double peak_memory();
double machine_memory();

}  // namespace aberfit
