/// The whole program: MPI, PETSc, one run, exit status.
#pragma once

namespace nanoweft {

/// 0 done, 1 bad input, 2 run failed, 3 stopped by a signal after writing a checkpoint.
int runProgram(int argc, char** argv);

}  // namespace nanoweft
