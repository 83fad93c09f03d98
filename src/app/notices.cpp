#include "nanoweft/app/notices.hpp"

namespace nanoweft {

Notices::~Notices() {
  // After an error of this rank alone MPI may still write there.
  if (request_ != MPI_REQUEST_NULL) static_cast<void>(values_.release());
}

void Notices::begin(int mine, double number, MPI_Comm comm) {
  mine_ = mine;
  for (std::size_t bit = 0; bit + 1 < values_->size(); ++bit) (*values_)[bit] = mine >> bit & 1;
  values_->back() = number;
  int ranks;
  MPI_Comm_size(comm, &ranks);
  if (ranks > 1)
    MPI_Iallreduce(MPI_IN_PLACE, values_->data(), static_cast<int>(values_->size()), MPI_DOUBLE,
                   MPI_MAX, comm, &request_);
}

int Notices::wait() {
  MPI_Wait(&request_, MPI_STATUS_IGNORE);
  int bits = 0;
  for (std::size_t bit = 0; bit + 1 < values_->size(); ++bit)
    if ((*values_)[bit] > 0) bits |= 1 << bit;
  return bits;
}

}  // namespace nanoweft
