/// Values that each rank has some of, together.
#pragma once

#include <mpi.h>

#include <numeric>
#include <vector>

namespace nanoweft {

/// The values of all ranks, rank after rank: on rank 0 alone, or `everywhere`. Collective. T is
/// copied as bytes; counts and places are those of values, so that 2^31 values fit, not bytes.
template <class T>
std::vector<T> ofAllRanks(const std::vector<T>& mine, MPI_Comm comm, bool everywhere = true) {
  int ranks, rank;
  MPI_Comm_size(comm, &ranks);
  MPI_Comm_rank(comm, &rank);
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(ranks)), places(counts.size());
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), 0);
  MPI_Datatype type;
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  std::vector<T> all;
  if (everywhere || rank == 0)
    all.resize(static_cast<std::size_t>(places.back()) + static_cast<std::size_t>(counts.back()));
  if (everywhere)
    MPI_Allgatherv(mine.data(), count, type, all.data(), counts.data(), places.data(), type, comm);
  else
    MPI_Gatherv(mine.data(), count, type, all.data(), counts.data(), places.data(), type, 0, comm);
  MPI_Type_free(&type);
  return all;
}

/// The largest `value` of all ranks. On all of them `of` becomes that of the rank that has it, of
/// equals the first. A value that is no number counts for nothing. Collective. T is copied as
/// bytes.
template <class T>
double largestOfRanks(double value, T& of, MPI_Comm comm) {
  struct {
    double value;
    int rank;
  } best{value, 0};
  MPI_Comm_rank(comm, &best.rank);
  MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
  MPI_Bcast(&of, sizeof of, MPI_BYTE, best.rank, comm);
  return best.value;
}

}  // namespace nanoweft
