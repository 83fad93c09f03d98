/// Runs of nanoweft from C++: the one header that other programs include.
///
///     #include <nanoweft/nanoweft.hpp>
///
///     int main() {
///       nanoweft::Run run(MPI_COMM_WORLD, {"-scene", "weave", "-weave_fibres", "8,8",
///                                          "-ts_max_steps", "1000"});
///       run.run();
///       std::cout << run.energies().elastic() << " eV\n";
///     }
///
/// With CMake: `find_package(nanoweft)` and `target_link_libraries(program nanoweft::nanoweft)`.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nanoweft/base/exceptions.hpp"

namespace nanoweft {

/// One run, from its options to its last state. What the program `nanoweft` would print and write
/// with the same options, this class prints and writes, too, so the tables, snapshots and
/// checkpoints (the stress of a tension test is in one) are files that the options name.
///
/// Quantities are in the units of the run: A, fs, eV, or with `-units si` m, s, J.
///
/// All ranks of the communicator make, run and destroy a Run together, before MPI_Finalize. Where
/// MPI or PETSc are not initialised, the first Run does that, and the last one that is destroyed
/// finalises what was initialised so; since MPI starts only once, a program with several runs one
/// after another calls MPI_Init itself. PETSc's options of the surrounding program (PETSC_OPTIONS,
/// .petscrc) and those of a Run do not mix.
///
/// Errors: InputError for options, files or a start that are wrong, RunError for a run that failed,
/// by all ranks together and with one line that says what and where. Other exceptions
/// (std::bad_alloc, and std::runtime_error from a library) may come on one rank alone, while the
/// others wait for it: end them with MPI_Abort. A misuse of this class is a std::logic_error.
class Run {
 public:
  /// Energies of the present step, and the accounts of the run so far.
  struct Energies {
    double stretch = 0, shear = 0, bending = 0, torsion = 0;  ///< of the bonds
    double pair = 0;                                          ///< between fibres
    double walls = 0;  ///< of contacts with walls, and of the motion of driven ones
    double kinetic = 0, rotational = 0;
    double damped = 0;    ///< taken out by damping, since the start
    double friction = 0;  ///< taken out by friction, since the start; no part of `damped`
    double external = 0;  ///< brought in by grips and loads, since the start
    double broken = 0;    ///< taken out with bonds that broke, since the start
    double heat = 0;      ///< brought in by the thermostat, since the start
    std::int64_t brokenBonds = 0;

    double elastic() const { return stretch + shear + bending + torsion; }
    double total() const { return elastic() + pair + walls + kinetic + rotational; }
  };

  struct Segment {
    std::int64_t fibre;                 ///< its fibre's id
    std::int32_t index;                 ///< its place along the fibre
    std::array<double, 3> position;     ///< centre, within the box in periodic directions
    std::array<double, 3> unwrapped;    ///< the same without wraps, continuous in time
    std::array<double, 4> orientation;  ///< unit quaternion w, x, y, z: body to space axes
    std::array<double, 3> velocity;     ///< space axes
    std::array<double, 3> angular;      ///< angular velocity, space axes
  };

  /// Builds the run and its first state. `options`: words as on the command line, option files
  /// (`"-options_file", "run.opts"`) included; later ones win. `threads`: of each rank; 0: as
  /// OMP_NUM_THREADS says, else a fair share of the cores, fewer for a small scene. Throws
  /// InputError.
  Run(MPI_Comm comm, const std::vector<std::string>& options, int threads = 0);
  ~Run();
  Run(Run&&) noexcept;
  Run& operator=(Run&&) noexcept;

  /// Makes all steps; once. `-wall_time` counts from the first Run. True when the run came to its
  /// end, false when `-wall_time` stopped it after it had written a checkpoint. Throws RunError.
  bool run();

  std::int64_t step() const;
  double time() const;
  /// Of all ranks, the same on each of them; only of a run that came to its end.
  Energies energies() const;
  /// Segments of all ranks.
  std::int64_t total() const;
  /// The segments of this rank, ordered by fibre and index: the first state before run(), the last
  /// one afterwards.
  std::vector<Segment> segments() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace nanoweft
