/// Shared by the unit tests: tables of reference numbers and random poses.
#pragma once

#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "nanoweft/base/vec.hpp"

namespace nanoweft::test {

/// Rows of numbers of a CSV file with one header line.
inline std::vector<std::vector<double>> readTable(const std::string& name) {
  std::ifstream file(std::string(NANOWEFT_SOURCE_DIR) + "/tests/data/" + name);
  if (!file) throw std::runtime_error("no " + name);
  std::vector<std::vector<double>> rows;
  std::string line, cell;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

inline Vec3d vectorAt(const std::vector<double>& row, std::size_t k) {
  return {row[k], row[k + 1], row[k + 2]};
}
inline Quatd quaternionAt(const std::vector<double>& row, std::size_t k) {
  return {row[k], row[k + 1], row[k + 2], row[k + 3]};
}

struct Random {
  std::mt19937_64 engine{20240607};
  double normal(double scale) { return std::normal_distribution<double>(0.0, scale)(engine); }
  Vec3d vector(double scale) { return {normal(scale), normal(scale), normal(scale)}; }
  Quatd orientation() {
    Quatd q{normal(1), normal(1), normal(1), normal(1)};
    const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {q.w / n, q.x / n, q.y / n, q.z / n};
  }
};

inline Vec3d rotate(const Quatd& q, const Vec3d& v) {
  return v.x * axis1(q) + v.y * axis2(q) + v.z * axis3(q);
}

/// Derivative of f at 0 by Richardson-extrapolated central differences.
template <class F>
double derivative(const F& f, double h) {
  auto central = [&](double s) { return (f(s) - f(-s)) / (2.0 * s); };
  return (4.0 * central(0.5 * h) - central(h)) / 3.0;
}

}  // namespace nanoweft::test
