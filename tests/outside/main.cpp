// A program that knows nanoweft by its installed header alone: two runs and a refusal with MPI of
// its own, or with the argument `alone` one run that starts and ends MPI.
#include <cstdio>
#include <nanoweft/nanoweft.hpp>

using nanoweft::Run;

static void runWeave() {
  Run run(MPI_COMM_WORLD,
          {"-scene", "weave", "-weave_fibres", "4,4", "-weave_segments", "20", "-damping_local",
           "0.4", "-ts_max_steps", "50", "-progress_interval", "0"});
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  try {
    run.energies();
    std::printf("energies before the run\n");
  } catch (const std::logic_error&) {
  }
  const bool done = run.run();
  double sums[2] = {0, 0};  // number of all segments, and the sum of their heights
  for (const Run::Segment& s : run.segments()) {
    sums[0] += 1;
    sums[1] += s.position[2];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  if (rank == 0)
    std::printf("result %d %lld %.0f %.17g %.17g\n", done, static_cast<long long>(run.step()),
                sums[0], sums[1], run.energies().elastic());
}

static void runOnAFloor() {
  Run run(MPI_COMM_WORLD,
          {"-scene", "fibre", "-fibre_segments", "8", "-pair", "none", "-walls", "floor",
           "-floor_point", "0,0,-6.5", "-floor_axis", "0,0,1", "-floor_modulus", "20",
           "-ts_max_steps", "10", "-progress_interval", "0"});
  run.run();
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) std::printf("floor %.17g %.17g\n", run.energies().total(), run.energies().walls);
}

static void runNonsense() {
  try {
    const Run run(MPI_COMM_WORLD, {"-scene", "weave", "-weave_fibers", "4,4"});
  } catch (const nanoweft::InputError& error) {
    std::printf("refused %s\n", error.what());
  }
}

int main(int argc, char** argv) {
  if (argc > 1) {
    runWeave();
    return 0;
  }
  MPI_Init(&argc, &argv);
  runWeave();
  runWeave();
  runOnAFloor();
  runNonsense();
  MPI_Finalize();
}
