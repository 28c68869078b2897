#pragma once
#include <cstddef>
#include <functional>

namespace aberfit {

/// Calls body(i) for i = 0 .. count-1 on at most `threads` threads. The bodies must be independent. Store
/// sums over i per i and add them in order afterwards; then the thread count changes no bit of a result. If
/// bodies throw, it throws the exception of the smallest i.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Number of processors that this process may use, at least 1.
int available_threads();

}  // namespace aberfit
