#include <petscsys.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <tuple>

#include "nanoweft/app/option_files.hpp"
#include "nanoweft/app/simulation.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/nanoweft.hpp"

namespace nanoweft {

namespace {

/// Keeps PETSc, and MPI with it, initialised as long as there is any Run.
class PetscInUse {
 public:
  explicit PetscInUse(MPI_Comm comm) {
    int over;
    MPI_Finalized(&over);
    if (over) throw std::logic_error("nanoweft::Run: MPI has been finalised");
    PetscBool running;
    petsc(PetscInitialized(&running));
    if (!running) start(comm);
    ++users;
  }
  ~PetscInUse() {
    if (--users > 0 || !startedHere) return;
    startedHere = false;
    PetscFinalize();
  }
  PetscInUse(const PetscInUse&) = delete;
  PetscInUse& operator=(const PetscInUse&) = delete;

 private:
  static void start(MPI_Comm comm) {
    int mpi;
    MPI_Initialized(&mpi);
    if (mpi) PETSC_COMM_WORLD = comm;
    // Signals belong to the surrounding program, and files in its folder are none of ours.
    petsc(initialisePetsc("nanoweft", {}));
    startedHere = true;
  }

  static inline int users = 0;
  static inline bool startedHere = false;
};

/// PETSc's database with the options of one run alone.
class OptionDatabase {
 public:
  OptionDatabase() { petsc(PetscOptionsCreate(&options_)); }
  ~OptionDatabase() { PetscOptionsDestroy(&options_); }
  OptionDatabase(const OptionDatabase&) = delete;
  OptionDatabase& operator=(const OptionDatabase&) = delete;
  PetscOptions get() const { return options_; }

 private:
  PetscOptions options_ = nullptr;
};

/// While it lives, PETSc has the options of one run and keeps its errors for exceptions.
class PetscScope {
 public:
  explicit PetscScope(const OptionDatabase& database) {
    PetscOptionsPush(database.get());
    keepPetscErrors();
  }
  ~PetscScope() {
    PetscPopErrorHandler();
    PetscOptionsPop();
  }
  PetscScope(const PetscScope&) = delete;
  PetscScope& operator=(const PetscScope&) = delete;
};

std::array<double, 3> triple(const double* from) {
  return {from[0], from[1], from[2]};
}

}  // namespace

class Run::Implementation {
 public:
  Implementation(MPI_Comm comm, const std::vector<std::string>& words, int threads) : petsc_(comm) {
    const PetscScope scope(database_);
    insertOptions(readOptions(comm, words));
    Options options;
    auto plan = std::make_unique<RunPlan>(comm, options);
    if (options.helpWanted())
      throw InputError("-help: `nanoweft --help` prints the options; a Run has no help");
    Team team;
    team.asked = threads > 0 ? threads : threadsPerRank(comm);
    team.atMost = threads <= 0 && std::getenv("OMP_NUM_THREADS") == nullptr;
    simulation_ = std::make_unique<Simulation>(std::make_unique<RunParts>(std::move(plan), team));
  }
  ~Implementation() {
    const PetscScope scope(database_);
    simulation_.reset();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  bool run() {
    if (called_) throw std::logic_error("nanoweft::Run: run() has been called");
    called_ = true;
    const PetscScope scope(database_);
    ended_ = simulation_->run() == Ending::done;
    return ended_;
  }
  const State& state() const { return *simulation_->parts().state; }
  const nanoweft::Energies& energies() const {
    if (!ended_)
      throw std::logic_error("nanoweft::Run: energies are known when run() has come to its end");
    return *simulation_->energies();
  }

 private:
  PetscInUse petsc_;
  OptionDatabase database_;
  std::unique_ptr<Simulation> simulation_;
  bool called_ = false, ended_ = false;
};

Run::Run(MPI_Comm comm, const std::vector<std::string>& options, int threads)
    : implementation_(std::make_unique<Implementation>(comm, options, threads)) {}
Run::~Run() = default;
Run::Run(Run&&) noexcept = default;
Run& Run::operator=(Run&&) noexcept = default;

bool Run::run() {
  return implementation_->run();
}

std::int64_t Run::step() const {
  return implementation_->state().step;
}

double Run::time() const {
  return implementation_->state().time;
}

std::int64_t Run::total() const {
  return implementation_->state().total();
}

Run::Energies Run::energies() const {
  const nanoweft::Energies& e = implementation_->energies();
  return {.stretch = e.stretch,
          .shear = e.shear,
          .bending = e.bending,
          .torsion = e.torsion,
          .pair = e.pair,
          .walls = e.walls,
          .kinetic = e.kinetic,
          .rotational = e.rotational,
          .damped = e.damped,
          .friction = e.friction,
          .external = e.external,
          .broken = e.broken,
          .heat = e.heat,
          .brokenBonds = e.brokenBonds};
}

std::vector<Run::Segment> Run::segments() const {
  const State& s = implementation_->state();
  std::vector<Segment> segments;
  segments.reserve(static_cast<std::size_t>(s.owned()));
  for (int i = 0; i < s.owned(); ++i) {
    const Quatd q = s.orientation(i);
    Segment segment{s.fibre[i],
                    s.chain[2 * i],
                    triple(s.pose + 8 * i),
                    {},
                    {q.w, q.x, q.y, q.z},
                    triple(s.velocity + 3 * i),
                    triple(s.angular + 3 * i)};
    const Vec3d unwrapped = s.box.unwrapped(s.pose + 8 * i, s.image + 3 * i);
    segment.unwrapped = {unwrapped.x, unwrapped.y, unwrapped.z};
    segments.push_back(segment);
  }
  std::ranges::sort(segments, {}, [](const Segment& a) { return std::tuple(a.fibre, a.index); });
  return segments;
}

}  // namespace nanoweft
