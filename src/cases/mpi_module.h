#pragma once

// Interface of the module aberfit_mpi, a separate shared library. Only a program started by mpirun loads it,
// so others need no Open MPI. Plain C, found by name.
namespace aberfit::internal {
extern "C" {

/// Starts MPI; 0 on success.
int aberfit_mpi_begin(int* rank, int* ranks);
/// For ranks except 0: requests `count` cases from `first` on; count 0: none is left.
void aberfit_mpi_ask(long* first, long* count);
/// For rank 0: answers with `next` until all other ranks have left. between: called now and then.
void aberfit_mpi_serve(void (*next)(void* state, long* first, long* count), void (*between)(void* state),
                       void* state);
/// For ranks except 0: tells rank 0 that no more requests follow.
void aberfit_mpi_leave(void);
/// Ends MPI in order; abort: ends all ranks at once.
void aberfit_mpi_end(void);
void aberfit_mpi_abort(int code);
}
}  // namespace aberfit::internal
