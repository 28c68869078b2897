#pragma once
#include <cstddef>
#include <functional>

namespace aberfit {

/// Calls body(i) for i = 0 .. count-1 on at most `threads` threads. The bodies must be independent; anything
/// that is summed over i is to be stored per i and added in order afterwards, so that the thread count
/// changes no bit of a result. Throws what the body of the smallest i throws that does.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Number of processors this process may use, at least 1.
int available_threads();

}  // namespace aberfit
