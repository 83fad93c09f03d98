#include "nanoweft/force/pair_forces.hpp"

#include <algorithm>

namespace nanoweft {

PairForces::PairForces(std::unique_ptr<PairForce> only) {
  if (only) classes_.push_back({0, 0, std::move(only)});
}

PairForces::PairForces(std::vector<Class> classes) : classes_(std::move(classes)) {
  double length = 0;
  for (const Class& c : classes_)
    length = std::max({length, c.force->length().i, c.force->length().j});
  for (const Class& c : classes_) c.force->setUnits(largestForce(), length);
  for (Class& c : classes_) {
    c.widest = between(c.first, c.second) == c.force.get();
    // The first of those that reach as far.
    auto cutoff = [&](const Class& other) {
      return other.between(c.first, c.second) ? other.force->cutoff() : 0.0;
    };
    c.damps = &*std::ranges::max_element(classes_, {}, cutoff) == &c;
  }
}

const PairForce* PairForces::between(int a, int b) const {
  const PairForce* widest = nullptr;
  for (const Class& c : classes_)
    if (c.between(a, b) && (!widest || c.force->reach() > widest->reach())) widest = c.force.get();
  return widest;
}

std::optional<double> PairForces::restDistance(int a, int b) const {
  std::optional<double> largest;
  for (const Class& c : classes_)
    if (c.between(a, b)) largest = std::max(largest.value_or(0.0), c.force->restDistance());
  return largest;
}

bool PairForces::touches() const {
  return std::ranges::any_of(classes_, [](const Class& c) { return c.force->touches(); });
}

bool PairForces::rubs() const {
  return std::ranges::any_of(classes_, [](const Class& c) { return c.force->rubs(); });
}

bool PairForces::damps() const {
  return std::ranges::any_of(classes_, [](const Class& c) { return c.force->damps(); });
}

bool PairForces::keepsApart(int a, int b) const {
  return std::ranges::any_of(
      classes_, [&](const Class& c) { return c.between(a, b) && c.force->keepsApart(); });
}

double PairForces::reach() const {
  double farthest = 0;
  for (const Class& c : classes_) farthest = std::max(farthest, c.force->reach());
  return farthest;
}

double PairForces::largestForce() const {
  double largest = 0;
  for (const Class& c : classes_) largest = std::max(largest, c.force->largestForce());
  return largest;
}

int PairForces::exclude() const {
  int most = 0;
  for (const Class& c : classes_)
    if (!c.mixed()) most = std::max(most, c.force->exclude());
  return most;
}

}  // namespace nanoweft
