#include "nanoweft/app/program.hpp"

#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "nanoweft/app/signals.hpp"
#include "nanoweft/app/simulation.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr const char* help =
    "nanoweft: fabrics, films and yarns of nano- and microfibres by the mesoscopic distinct "
    "element method.\n"
    "  mpirun -n 4 nanoweft -options_file run.opts\n"
    "OMP_NUM_THREADS sets the threads of each rank. Options of nanoweft stand after PETSc's.\n";

/// OMP_NUM_THREADS, or a fair share of the cores that this rank may use.
int threadsPerRank(MPI_Comm comm) {
  if (std::getenv("OMP_NUM_THREADS")) return omp_get_max_threads();
  MPI_Comm node;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  int ranks;
  MPI_Comm_size(node, &ranks);
  MPI_Comm_free(&node);
  const int usable = omp_get_num_procs(),
            cores = static_cast<int>(std::thread::hardware_concurrency());
  // A bound rank has its cores for itself; unbound ones share them all.
  return usable < cores ? usable : std::max(1, usable / ranks);
}

/// PETSc would leave all ranks but the first waiting for an options file that is not there.
std::string missingOptionsFile(int argc, char** argv) {
  for (int k = 1; k + 1 < argc; ++k)
    if (!std::strcmp(argv[k], "-options_file") && !std::ifstream(argv[k + 1]))
      return std::string("-options_file ") + argv[k + 1] + ": cannot be read";
  return "";
}

int report(int rank, const char* message, int status) {
  if (rank == 0) std::fprintf(stderr, "nanoweft: error: %s\n", message);
  return status;
}

int runWithPetsc(MPI_Comm comm, int rank) {
  try {
    const int threads = threadsPerRank(comm);
    omp_set_dynamic(0);
    omp_set_num_threads(threads);
    Options options;
    Simulation simulation(comm, options, threads);
    if (!simulation.runnable()) return 0;
    catchSignals();
    return static_cast<int>(simulation.run());
  } catch (const InputError& error) {
    return report(rank, error.what(), 1);
  } catch (const RunError& error) {
    return report(rank, error.what(), 2);
  } catch (const std::exception& error) {
    // Not agreed among the ranks: the others may be waiting for this one.
    std::fprintf(stderr, "nanoweft: internal error on rank %d: %s\n", rank, error.what());
    MPI_Abort(comm, 2);
    return 2;
  }
}

}  // namespace

int runProgram(int argc, char** argv) {
  int provided, rank;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  int status;
  try {
    agree<InputError>(MPI_COMM_WORLD, rank == 0 ? missingOptionsFile(argc, argv) : "");
    keepPetscErrors();
    if (PetscInitialize(&argc, &argv, nullptr, help) != 0) {
      report(0, "the options cannot be read", 1);
      MPI_Abort(MPI_COMM_WORLD, 1);
    }
    status = runWithPetsc(PETSC_COMM_WORLD, rank);
    PetscFinalize();
  } catch (const InputError& error) {
    status = report(rank, error.what(), 1);
  }
  MPI_Finalize();
  return status;
}

}  // namespace nanoweft
