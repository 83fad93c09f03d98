/// Messages to a few ranks that do not know they will receive them.
#pragma once

#include <petscsys.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

/// Sends each vector to its rank; returns what arrived as (rank, vector), in order of ranks.
/// Collective. T is copied as bytes.
template <class T>
std::vector<std::pair<int, std::vector<T>>> deliver(MPI_Comm comm,
                                                    const std::map<int, std::vector<T>>& outgoing) {
  std::vector<PetscMPIInt> to;
  std::vector<int> sizes;
  for (const auto& [rank, items] : outgoing) {
    to.push_back(rank);
    sizes.push_back(static_cast<int>(items.size()));
  }
  PetscMPIInt count;
  PetscMPIInt* from;
  int* incomingSizes;
  petsc(PetscCommBuildTwoSided(comm, 1, MPI_INT, static_cast<PetscMPIInt>(to.size()), to.data(),
                               sizes.data(), &count, &from, &incomingSizes));
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return from[a] < from[b]; });
  std::vector<std::pair<int, std::vector<T>>> incoming;
  for (int k : order)
    incoming.emplace_back(from[k], std::vector<T>(static_cast<std::size_t>(incomingSizes[k])));
  petsc(PetscFree(from));
  petsc(PetscFree(incomingSizes));

  MPI_Datatype type;
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  constexpr int tag = 7401;
  std::vector<MPI_Request> requests;
  for (auto& [rank, items] : incoming)
    MPI_Irecv(items.data(), static_cast<int>(items.size()), type, rank, tag, comm,
              &requests.emplace_back());
  for (const auto& [rank, items] : outgoing)
    MPI_Isend(items.data(), static_cast<int>(items.size()), type, rank, tag, comm,
              &requests.emplace_back());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  MPI_Type_free(&type);
  return incoming;
}

}  // namespace nanoweft
