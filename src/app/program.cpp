#include "nanoweft/app/program.hpp"

#include <omp.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
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

/// What is wrong with an options file, or nothing. PETSc itself would leave all ranks but the first
/// waiting for a file that is not there or has a line that is no option.
std::string problemInOptionsFile(const std::string& file, int depth) {
  const std::string what = "-options_file " + file + ": ";
  std::error_code code;
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file, code)) return what + "cannot be read";
  if (depth > 10) return what + "files that include each other";
  if (file.ends_with(".yaml") || file.ends_with(".yml")) return "";
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find('\0') != std::string::npos) return what + "is not a text file";
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, value;
    if (!(words >> name)) continue;
    if (name[0] != '-' && name != "alias")
      return what + format("line %d: '%s' is no option (options begin with -)", number,
                           name.substr(0, 40).c_str());
    std::string rest;
    words >> value;
    if (words >> rest && name != "alias" && value[0] != '"' && value[0] != '\'')
      return what + format("line %d: '%s' after the value; one option on a line", number,
                           rest.substr(0, 40).c_str());
    if (name == "-options_file" && !value.empty())
      if (const std::string problem = problemInOptionsFile(value, depth + 1); !problem.empty())
        return problem;
  }
  return "";
}

bool isOption(const char* word) {
  return word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
}

std::string problemInArguments(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    if (!isOption(argv[k]) && (k == 1 || !isOption(argv[k - 1])))
      return std::string("'") + argv[k] +
             "' is no option; option files are given with -options_file NAME";
    if (std::strcmp(argv[k], "-options_file")) continue;
    if (k + 1 == argc) return "-options_file needs the name of a file";
    if (const std::string problem = problemInOptionsFile(argv[k + 1], 0); !problem.empty())
      return problem;
  }
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
    PetscBool versionOnly;
    petsc(PetscOptionsHasName(nullptr, nullptr, "-version", &versionOnly));
    if (versionOnly) {
      PetscPrintf(comm, "nanoweft %s\n", NANOWEFT_VERSION);
      return 0;
    }
    Options options;
    Simulation simulation(comm, options, threads, std::getenv("OMP_NUM_THREADS") == nullptr);
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
    agree<InputError>(MPI_COMM_WORLD, rank == 0 ? problemInArguments(argc, argv) : "");
    keepPetscErrors();
    if (PetscInitialize(&argc, &argv, nullptr, help) != 0) {
      report(rank, "the options cannot be read", 1);
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
