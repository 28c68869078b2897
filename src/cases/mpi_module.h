#pragma once

// What the module aberfit_mpi offers, a shared library of its own that is loaded by a program that mpirun has
// started: all others need no Open MPI. Plain C, found by name.
namespace aberfit::internal {
extern "C" {

/// Begins MPI. 0 where that succeeds.
int aberfit_mpi_begin(int* rank, int* ranks);
/// Ranks but 0: asks rank 0 for work. first: a number, count: how many from there; 0: there is none left.
void aberfit_mpi_ask(long* first, long* count);
/// Rank 0: answers with what `next` says until every other rank has left. between: called now and then.
void aberfit_mpi_serve(void (*next)(void* state, long* first, long* count), void (*between)(void* state),
                       void* state);
/// Ranks but 0: tells rank 0 that nothing more is to come.
void aberfit_mpi_leave(void);
/// Ends MPI in order; abort: ends all ranks at once.
void aberfit_mpi_end(void);
void aberfit_mpi_abort(int code);
}
}  // namespace aberfit::internal
