#include "nanoweft/app/program.hpp"

int main(int argc, char** argv) {
  return nanoweft::runProgram(argc, argv);
}
