/// Starts the variant of nanoweft that this processor is best served by, or that -simd asks for.
/// The variants are whole programs, compiled from the same source for one instruction set each, so
/// no code for another one can get into them.
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <system_error>

namespace {

struct Variant {
  const char* name;     ///< as a value of -simd
  const char* program;  ///< beside the others
  bool (*runsHere)();
};

// The best first.
constexpr std::array variants{
    Variant{"avx512", "nanoweft-x86-64-v4",
            [] {
              return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                     __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                     __builtin_cpu_supports("avx512vl");
            }},
    Variant{"avx2", "nanoweft-x86-64-v3",
            [] {
              return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                     __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
            }},
    Variant{"sse2", "nanoweft-x86-64", [] { return true; }},
};

/// The last value of -simd on the command line, or auto.
std::string wanted(int argc, char** argv) {
  std::string value = "auto";
  for (int k = 1; k + 1 < argc; ++k)
    if (std::strcmp(argv[k], "-simd") == 0) value = argv[k + 1];
  return value;
}

int refuse(const std::string& reason) {
  std::fprintf(stderr, "nanoweft: error: %s\n", reason.c_str());
  return 1;
}

/// The file of this program; empty when it cannot be found.
std::filesystem::path ownFile(const std::string& name) {
  std::error_code failed;
  if (const auto file = std::filesystem::canonical("/proc/self/exe", failed); !failed) return file;
  // Without /proc (a bare chroot) the name by which it was started has to serve.
  if (name.find('/') != std::string::npos) return std::filesystem::canonical(name, failed);
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (access(file.c_str(), X_OK) == 0) return std::filesystem::canonical(file, failed);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  __builtin_cpu_init();
  const std::string simd = wanted(argc, argv);
  const std::filesystem::path own = ownFile(argv[0]);
  if (own.empty()) return refuse("cannot find its own file; start it by its whole path");
  const std::filesystem::path here = own.parent_path() / NANOWEFT_VARIANTS_DIR;
  for (const Variant& v : variants) {
    if (simd != "auto" && simd != v.name) continue;
    if (!v.runsHere()) {
      if (simd == "auto") continue;
      return refuse("-simd " + simd + ": this processor does not have these instructions");
    }
    const std::string program = (here / v.program).lexically_normal();
    execv(program.c_str(), argv);
    return refuse(program + ": " + std::strerror(errno));
  }
  return refuse("-simd " + simd + ": the choices are auto, avx512, avx2, sse2");
}
