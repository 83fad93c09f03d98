#include "support/program.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "nanoweft/base/hdf5.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}

namespace nanoweft::test {

namespace fs = std::filesystem;

Folder::Folder() {
  std::string pattern = (fs::temp_directory_path() / "nanoweft-test-XXXXXX").string();
  if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  path_ = pattern;
}

Folder::~Folder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  // Open MPI's daemons may still be clearing up there.
  const fs::path session = path_.string() + ".mpi";
  for (int k = 0; k < 100 && fs::exists(session, ignored); ++k) {
    fs::remove_all(session, ignored);
    std::this_thread::sleep_for(std::chrono::milliseconds(k));
  }
}

namespace {

std::string launch(const Folder& folder, const std::string& start, const std::string& options,
                   int threads) {
  return "cd '" + folder.path().string() + "' && " + environment(folder, threads) + " && " + start +
         " '" NANOWEFT_BINARY "' " + options + " > out.txt 2>&1";
}

/// How a program begins on `ranks` ranks: alone, without a launcher, where there is one.
std::string onRanks(int ranks) {
  if (ranks == 1) return "exec";
  return "exec '" NANOWEFT_MPIEXEC "' --quiet --oversubscribe --bind-to none -n " +
         std::to_string(ranks);
}

std::string command(const Folder& folder, const std::string& options, int ranks, int threads) {
  return launch(folder, onRanks(ranks), options, threads);
}

/// What the program printed. mpirun's event library warns of a descriptor that it has closed
/// itself, once in some hundred runs that end early.
std::string printed(const Folder& folder) {
  std::istringstream all(readFile(folder / "out.txt"));
  std::string text, line;
  while (std::getline(all, line))
    if (!line.starts_with("[warn] Epoll ")) text += line + (all.eof() ? "" : "\n");
  return text;
}

Outcome finish(const Folder& folder, int status) {
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), printed(folder)};
}

}  // namespace

// Waiting threads and ranks must not spin: tests run with more of them than there are cores. mpirun
// sleeps for two seconds after each status that is not 0 unless sigkill_timeout is 0. Naming the
// transports, shared memory or else sockets as on one machine anyway, spares the search for
// networks: a fifth of a second each run.
std::string environment(const Folder& folder, int threads, const std::string& session) {
  const std::string place = folder.path().string() + ".mpi/" + session;
  return "mkdir -p '" + place + "' && export OMPI_MCA_orte_tmpdir_base='" + place +
         "' OMP_NUM_THREADS=" + std::to_string(threads) +
         " OMP_WAIT_POLICY=passive OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"
         " OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_mpi_yield_when_idle=1"
         " OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_odls_base_sigkill_timeout=0"
         " OMPI_MCA_pml=ob1 OMPI_MCA_btl=vader,tcp,self";
}

Outcome run(const Folder& folder, const std::string& options, int ranks, int threads) {
  return finish(folder,
                std::system(("(" + command(folder, options, ranks, threads) + ")").c_str()));
}

Outcome runAfter(const Folder& folder, const std::string& first, const std::string& options,
                 int ranks) {
  const std::string start = onRanks(ranks) + " bash -c '" + first + "; exec \"$0\" \"$@\"'";
  return finish(folder, std::system(("(" + launch(folder, start, options, 1) + ")").c_str()));
}

Outcome runBeside(const Folder& folder, const std::string& options, int ranks,
                  const std::string& beside) {
  // `beside` must not read what a run before has printed, and may kill this one before it prints.
  const std::string script =
      "cd '" + folder.path().string() + "'; : > out.txt; cd - > /dev/null; (" +
      command(folder, options, ranks, 1) + ") & PID=$!; cd '" + folder.path().string() + "'; { " +
      beside + "; } > beside.txt 2>&1; wait $PID";
  return finish(folder, std::system(script.c_str()));
}

std::string readFile(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("no file " + file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void writeText(const std::string& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::map<std::string, std::vector<double>> readCsv(const std::string& file) {
  std::istringstream in(readFile(file));
  std::string line, cell;
  while (std::getline(in, line) && line.starts_with("#")) {
  }
  std::vector<std::string> names;
  std::istringstream header(line);
  while (std::getline(header, cell, ',')) names.push_back(cell);
  std::map<std::string, std::vector<double>> columns;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      columns[name].push_back(std::stod(cell));
    }
  }
  return columns;
}

std::vector<double> readDataset(const std::string& file, const std::string& name) {
  h5::silence();
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle set(f.valid() ? H5Dopen2(f, name.c_str(), H5P_DEFAULT) : -1, H5Dclose);
  if (!set.valid()) throw std::runtime_error("no " + name + " in " + file);
  h5::Handle space(H5Dget_space(set), H5Sclose);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw std::runtime_error("cannot read " + name);
  return values;
}

void writeState(const std::string& file, const std::vector<FibreInput>& fibres,
                const BoxInput& box) {
  std::vector<double> position, orientation;
  std::vector<std::int64_t> fibre, index, closed;
  for (std::size_t f = 0; f < fibres.size(); ++f) {
    if (fibres[f].closed) closed.push_back(static_cast<std::int64_t>(f));
    for (std::size_t k = 0; k < fibres[f].position.size(); ++k) {
      const Vec3d& x = fibres[f].position[k];
      const Quatd& q = fibres[f].orientation[k];
      position.insert(position.end(), {x.x, x.y, x.z});
      orientation.insert(orientation.end(), {q.w, q.x, q.y, q.z});
      fibre.push_back(static_cast<std::int64_t>(f));
      index.push_back(static_cast<std::int64_t>(k));
    }
  }
  h5::Handle h(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gcreate2(h, "state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  h5::writeAttribute(group, "format", "nanoweft-state");
  h5::writeScalar(group, "version", std::int64_t{1});
  h5::writeScalar(group, "step", std::int64_t{0});
  h5::writeScalar(group, "time", 0.0);
  h5::writeAttribute(group, "units", "nano");
  h5::writeAttribute(group, "lower", std::vector<double>(box.lower.begin(), box.lower.end()));
  h5::writeAttribute(group, "upper", std::vector<double>(box.upper.begin(), box.upper.end()));
  h5::writeAttribute(group, "periodic",
                     std::vector<std::int64_t>(box.periodic.begin(), box.periodic.end()));
  auto write = [&](const char* name, hid_t type, const void* data, hsize_t rows, hsize_t columns) {
    const hsize_t shape[2] = {rows, columns};
    h5::Handle space(H5Screate_simple(columns == 1 ? 1 : 2, shape, nullptr), H5Sclose);
    h5::Handle set(H5Dcreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                   H5Dclose);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  };
  const hsize_t n = fibre.size();
  write("position", H5T_NATIVE_DOUBLE, position.data(), n, 3);
  write("orientation", H5T_NATIVE_DOUBLE, orientation.data(), n, 4);
  write("fibre", H5T_NATIVE_INT64, fibre.data(), n, 1);
  write("index", H5T_NATIVE_INT64, index.data(), n, 1);
  if (!closed.empty()) write("fibre_closed", H5T_NATIVE_INT64, closed.data(), closed.size(), 1);
}

FibreInput straightFibre(const Vec3d& start, const Vec3d& direction, int segments) {
  const Vec3d t = (1.0 / norm(direction)) * direction;
  const Vec3d hint = std::abs(t.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d across = cross(hint, t), side = (1.0 / norm(across)) * across;
  FibreInput fibre;
  for (int k = 0; k < segments; ++k) {
    fibre.position.push_back(start + (13.56 * k) * t);
    fibre.orientation.push_back(quaternionFromAxes(t, side, cross(t, side)));
  }
  return fibre;
}

}  // namespace nanoweft::test
