#include "nanoweft/app/program.hpp"

#include <hdf5.h>
#include <omp.h>
#include <strings.h>

#include <algorithm>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <thread>
#include <type_traits>

#include "nanoweft/app/option_files.hpp"
#include "nanoweft/app/signals.hpp"
#include "nanoweft/app/simulation.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/threads.hpp"

namespace nanoweft {

namespace {

constexpr const char* introduction =
    "nanoweft: fabrics, films and yarns of nano- and microfibres by the mesoscopic distinct "
    "element method.\n"
    "  mpirun -n 4 nanoweft -options_file run.opts\n"
    "OMP_NUM_THREADS sets the threads of each rank. PETSc's own options follow with -help.\n";

/// Seconds that a rank that failed waits for the others to fail, too.
constexpr double patience = 5.0;

/// What PETSc says about its own options, on rank 0.
std::string petscHelp;

PetscErrorCode keepPetscHelp(MPI_Comm comm, const char* pattern, ...) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  if (rank != 0) return 0;
  char text[8192];
  std::size_t length = 0;
  va_list arguments;
  va_start(arguments, pattern);
  const PetscErrorCode code = PetscVSNPrintf(text, sizeof text, pattern, &length, arguments);
  va_end(arguments);
  petscHelp += text;
  return code;
}

int report(int rank, const char* message, int status) {
  if (rank == 0) std::fprintf(stderr, "nanoweft: error: %s\n", message);
  return status;
}

/// The ranks of a run, with a way to find out whether all of them have come to the same end.
class Ranks {
 public:
  Ranks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    // A communicator of its own, since the other ranks may be communicating on theirs.
    MPI_Comm_dup(MPI_COMM_WORLD, &ends_);
  }
  ~Ranks() { MPI_Comm_free(&ends_); }
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int rank() const { return rank_; }

  /// Ends this rank after an error that the ranks have not agreed on. When all ranks come here, all
  /// leave in step; otherwise the others may be waiting for this rank, so MPI ends them.
  int fail(const std::string& message, int status) const {
    MPI_Request request;
    MPI_Ibarrier(ends_, &request);
    const bool together = arrived(request);
    if (together) return report(rank_, message.c_str(), status);
    std::fprintf(stderr, "nanoweft: error: rank %d: %s\n", rank_, message.c_str());
    std::fflush(stderr);
    MPI_Abort(MPI_COMM_WORLD, status);
    return status;
  }

  /// Throws `Error` on all ranks when a call that all have made failed on any.
  template <class Error>
  void agreeOnCall(PetscErrorCode code, const char* what) const {
    const std::string problem = code == 0 ? "" : what + (": " + petscMessage(code));
    MPI_Request request;
    MPI_Ibarrier(ends_, &request);
    if (code == 0) {
      MPI_Wait(&request, MPI_STATUS_IGNORE);
    } else if (!arrived(request)) {
      std::fprintf(stderr, "nanoweft: error: %s\n", problem.c_str());
      std::fflush(stderr);
      MPI_Abort(MPI_COMM_WORLD, std::is_same_v<Error, InputError> ? 1 : 2);
    }
    agree<Error>(ends_, problem);
  }

 private:
  static bool arrived(MPI_Request& request) {
    const double begin = MPI_Wtime();
    for (int done = 0; !done;) {
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      if (done) return true;
      if (MPI_Wtime() - begin > patience) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  int rank_ = 0;
  MPI_Comm ends_;
};

void printVersions(int rank) {
  if (rank != 0) return;
  int length = 0;
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  MPI_Get_library_version(mpi, &length);
  std::string library(mpi);
  library.resize(std::min(library.size(), library.find_first_of(",\n")));
  PetscInt major, minor, patch;
  PetscGetVersionNumber(&major, &minor, &patch, nullptr);
  unsigned h[3];
  H5get_libversion(h, h + 1, h + 2);
  std::printf("nanoweft %s\nPETSc %d.%d.%d, %s, HDF5 %u.%u.%u\n", NANOWEFT_VERSION,
              static_cast<int>(major), static_cast<int>(minor), static_cast<int>(patch),
              library.c_str(), h[0], h[1], h[2]);
}

void printHelp(MPI_Comm comm, const Options& options, bool brief) {
  PetscPrintf(comm, "%s", introduction);
  options.printHelp(comm);
  int rank;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0 && !brief) std::printf("Of PETSc\n%s", petscHelp.c_str());
}

int runWithPetsc(MPI_Comm comm, bool briefHelp, const CoreWatch& cores) {
  const int threads = threadsPerRank(comm);
  omp_set_dynamic(0);
  omp_set_num_threads(threads);
  Options options;
  auto plan = std::make_unique<RunPlan>(comm, options);
  if (options.helpWanted()) {
    printHelp(comm, options, briefHelp);
    return 0;
  }
  const Team team{threads, std::getenv("OMP_NUM_THREADS") == nullptr, 1, cores};
  Simulation simulation(std::make_unique<RunParts>(std::move(plan), team));
  return static_cast<int>(simulation.run());
}

/// Turns errors into messages and exit statuses.
template <class Work>
int guarded(const Ranks& ranks, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    return report(ranks.rank(), error.what(), 1);
  } catch (const RunError& error) {
    return report(ranks.rank(), error.what(), 2);
  } catch (const Interrupted& stop) {
    if (ranks.rank() == 0) std::printf("%s; nothing has been computed or written\n", stop.what());
    return 3;
  } catch (const std::bad_alloc&) {
    return ranks.fail("there is not enough memory", 2);
  } catch (const std::exception& error) {
    return ranks.fail(std::string("internal error: ") + error.what(), 2);
  }
}

/// PETSc crashes when it cannot write its history.
std::string problemOfHistory(const GivenOptions& given) {
  for (const GivenOption& o : given.list) {
    if (strcasecmp(o.name.c_str(), "-history") != 0) continue;
    const char* home = std::getenv("HOME");
    const std::string file =
        o.value && !o.value->empty() ? *o.value : std::string(home ? home : "") + "/.petschistory";
    if (!std::ofstream(file, std::ios::app)) return "-history " + file + ": cannot be written";
  }
  return "";
}

void startPetsc(const Ranks& ranks, const GivenOptions& given, int argc, char** argv) {
  agree<InputError>(MPI_COMM_WORLD, ranks.rank() == 0 ? problemOfHistory(given) : "");
  keepPetscErrors();
  // readOptions has read these; PETSc must not read them again.
  unsetenv("PETSC_OPTIONS");
  unsetenv("PETSC_OPTIONS_YAML");
  PetscHelpPrintf = keepPetscHelp;
  const PetscErrorCode code = initialisePetsc(argc > 0 ? argv[0] : "nanoweft", given);
  ranks.agreeOnCall<InputError>(code, "PETSc cannot start with these options");
}

bool asksForVersion(int argc, char** argv) {
  return std::any_of(argv + std::min(argc, 1), argv + argc, [](const std::string& word) {
    return word == "--version" || word == "-version";
  });
}

int runWithMpi(int argc, char** argv, const CoreWatch& cores) {
  const Ranks ranks;
  return guarded(ranks, [&] {
    GivenOptions given;
    given.version = asksForVersion(argc, argv);
    if (!given.version) given = readOptions(MPI_COMM_WORLD, argc, argv);
    if (given.version) {
      printVersions(ranks.rank());
      return 0;
    }
    startPetsc(ranks, given, argc, argv);
    const int status =
        guarded(ranks, [&] { return runWithPetsc(PETSC_COMM_WORLD, given.briefHelp, cores); });
    ranks.agreeOnCall<RunError>(PetscFinalize(), "PETSc cannot finish");
    return status;
  });
}

}  // namespace

int runProgram(int argc, char** argv) {
  secondsSinceStart();
  const CoreWatch cores;
  catchSignals();
  int provided, rank;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  catchCrashes(rank);
  const int status = runWithMpi(argc, argv, cores);
  MPI_Finalize();
  return status;
}

}  // namespace nanoweft
