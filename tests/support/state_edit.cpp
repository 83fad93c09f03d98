#include "support/state_edit.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <stdexcept>

#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/state_signature.hpp"
#include "support/program.hpp"

namespace nanoweft::test {

void setDataset(const std::string& file, const std::string& name, const std::vector<double>& values,
                int columns) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  h5::Handle group(f.valid() ? H5Gopen2(f, "state", H5P_DEFAULT) : -1, H5Gclose);
  if (!group.valid()) throw std::runtime_error("no /state in " + file);
  const auto width = static_cast<hsize_t>(columns);
  const hsize_t shape[2] = {values.size() / width, width};
  if (H5Lexists(group, name.c_str(), H5P_DEFAULT) > 0) {
    h5::Handle old(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose);
    h5::Handle space(H5Dget_space(old), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(values.size()))
      H5Ldelete(group, name.c_str(), H5P_DEFAULT);
  }
  if (H5Lexists(group, name.c_str(), H5P_DEFAULT) <= 0) {
    h5::Handle space(H5Screate_simple(columns == 1 ? 1 : 2, shape, nullptr), H5Sclose);
    h5::Handle made(H5Dcreate2(group, name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                               H5P_DEFAULT, H5P_DEFAULT),
                    H5Dclose);
  }
  h5::Handle set(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw std::runtime_error("cannot write " + name);
  set = {}, group = {}, f = {};
  signAgain(file);
}

void setLinks(const std::string& file, const std::vector<LinkEnds>& links) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  h5::Handle group(f.valid() ? H5Gcreate2(f, "link", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) : -1,
                   H5Gclose);
  const hsize_t shape[3] = {links.size(), 2, 2};
  h5::Handle space(H5Screate_simple(3, shape, nullptr), H5Sclose);
  h5::Handle set(group.valid() ? H5Dcreate2(group, "segments", H5T_NATIVE_INT64, space, H5P_DEFAULT,
                                            H5P_DEFAULT, H5P_DEFAULT)
                               : -1,
                 H5Dclose);
  if (!set.valid() ||
      H5Dwrite(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, links.data()) < 0)
    throw std::runtime_error("cannot write /link");
  set = {}, group = {}, f = {};
  signAgain(file);
}

void setLinkKinds(const std::string& file, const std::vector<std::int32_t>& kinds,
                  const std::string& names) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const hsize_t rows = kinds.size();
  h5::Handle space(H5Screate_simple(1, &rows, nullptr), H5Sclose);
  h5::Handle set(f.valid() ? H5Dcreate2(f, "/link/kind", H5T_NATIVE_INT32, space, H5P_DEFAULT,
                                        H5P_DEFAULT, H5P_DEFAULT)
                           : -1,
                 H5Dclose);
  if (!set.valid() ||
      H5Dwrite(set, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, kinds.data()) < 0 ||
      (!names.empty() && !h5::writeAttribute(set, "kinds", names)))
    throw std::runtime_error("cannot write /link/kind");
  set = {}, f = {};
  signAgain(file);
}

void signAgain(const std::string& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) throw std::runtime_error("no file " + file);
  const bool signedOnce = checkSignature(fd).result != SignatureCheck::unsigned_;
  const int failure = signedOnce ? signFile(fd) : 0;
  ::close(fd);
  if (failure != 0) throw std::runtime_error("cannot sign " + file);
}

void setMotion(const std::string& file, const VectorField& v, const VectorField& w) {
  const auto x = readVectors(file, "/state/position");
  std::vector<double> velocity, angular;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3d a = v(i, x[i]), b = w(i, x[i]);
    velocity.insert(velocity.end(), {a.x, a.y, a.z});
    angular.insert(angular.end(), {b.x, b.y, b.z});
  }
  setDataset(file, "velocity", velocity, 3);
  setDataset(file, "angular_velocity", angular, 3);
}

void stopMotion(const std::string& file) {
  const auto rest = [](std::size_t, const Vec3d&) { return Vec3d{}; };
  setMotion(file, rest, rest);
}

void reverseMotion(const std::string& file) {
  for (const char* name : {"velocity", "angular_velocity"}) {
    auto values = readDataset(file, std::string("/state/") + name);
    for (double& x : values) x = -x;
    setDataset(file, name, values, 3);
  }
}

std::vector<Vec3d> readVectors(const std::string& file, const std::string& name) {
  const auto a = readDataset(file, name);
  std::vector<Vec3d> vectors;
  for (std::size_t k = 0; k < a.size(); k += 3) vectors.push_back({a[k], a[k + 1], a[k + 2]});
  return vectors;
}

std::vector<Quatd> readOrientations(const std::string& file) {
  const auto a = readDataset(file, "/state/orientation");
  std::vector<Quatd> q;
  for (std::size_t k = 0; k < a.size(); k += 4) q.push_back({a[k], a[k + 1], a[k + 2], a[k + 3]});
  return q;
}

}  // namespace nanoweft::test
