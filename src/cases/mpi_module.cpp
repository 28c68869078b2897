#include "mpi_module.h"

#define OMPI_SKIP_MPICXX 1  // the C++ bindings are deprecated and cause warnings
#include <mpi.h>

#include <chrono>
#include <thread>

namespace aberfit::internal {
namespace {

constexpr int kAsk = 1, kWork = 2, kLeave = 3;

// MPI waits by polling, so we pause between polls to keep the processor free.
constexpr std::chrono::microseconds kBetweenLooks{200};

}  // namespace

extern "C" {

// Threads call MPI one at a time; in rank 0 one thread serves.
int aberfit_mpi_begin(int* rank, int* ranks) {
  int offered = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &offered) != MPI_SUCCESS) return 1;
  if (offered < MPI_THREAD_SERIALIZED) return 1;
  MPI_Comm_rank(MPI_COMM_WORLD, rank);
  MPI_Comm_size(MPI_COMM_WORLD, ranks);
  return 0;
}

void aberfit_mpi_ask(long* first, long* count) {
  long work[2] = {0, 0};
  MPI_Send(nullptr, 0, MPI_LONG, 0, kAsk, MPI_COMM_WORLD);
  for (int there = 0; !there;) {
    MPI_Iprobe(0, kWork, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (!there) std::this_thread::sleep_for(kBetweenLooks);
  }
  MPI_Recv(work, 2, MPI_LONG, 0, kWork, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  *first = work[0], *count = work[1];
}

void aberfit_mpi_serve(void (*next)(void* state, long* first, long* count), void (*between)(void* state),
                       void* state) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (int left = 0; left < ranks - 1;) {
    int there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
    if (!there) {
      between(state);
      std::this_thread::sleep_for(kBetweenLooks);
    } else if (status.MPI_TAG == kAsk) {
      MPI_Recv(nullptr, 0, MPI_LONG, status.MPI_SOURCE, kAsk, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      long work[2] = {0, 0};
      next(state, &work[0], &work[1]);
      MPI_Send(work, 2, MPI_LONG, status.MPI_SOURCE, kWork, MPI_COMM_WORLD);
    } else {
      MPI_Recv(nullptr, 0, MPI_LONG, status.MPI_SOURCE, kLeave, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      ++left;
    }
  }
}

void aberfit_mpi_leave() { MPI_Send(nullptr, 0, MPI_LONG, 0, kLeave, MPI_COMM_WORLD); }

void aberfit_mpi_end() { MPI_Finalize(); }

void aberfit_mpi_abort(int code) { MPI_Abort(MPI_COMM_WORLD, code); }
}
}  // namespace aberfit::internal
