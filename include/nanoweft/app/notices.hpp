/// Bits that every rank sets for itself and that all ranks come to know while they work on; and a
/// number, of which they come to know the largest.
#pragma once

#include <mpi.h>

#include <array>
#include <memory>

namespace nanoweft {

class Notices {
 public:
  Notices() : values_(std::make_unique<Values>()) {}
  ~Notices();
  Notices(const Notices&) = delete;
  Notices& operator=(const Notices&) = delete;

  /// Starts to tell all ranks of this rank's bits, of which there are 31, and its number >= 0.
  /// Collective.
  void begin(int mine, double number, MPI_Comm comm);
  /// This rank's own bits.
  int mine() const { return mine_; }
  /// The bits that any rank has set, once they have arrived. Ends what `begin` has started.
  int wait();
  /// The largest number, after `wait`.
  double largest() const { return values_->back(); }

 private:
  using Values = std::array<double, 32>;  ///< 1 for a bit that is set; the number

  int mine_ = 0;
  std::unique_ptr<Values> values_;
  MPI_Request request_ = MPI_REQUEST_NULL;
};

}  // namespace nanoweft
