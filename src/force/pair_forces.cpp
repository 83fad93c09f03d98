#include "nanoweft/force/pair_forces.hpp"

#include <algorithm>

namespace nanoweft {

PairForces::PairForces(std::unique_ptr<PairForce> only) {
  if (only) classes_.push_back({0, 0, std::move(only)});
}

PairForces::PairForces(std::vector<Class> classes) : classes_(std::move(classes)) {
  double largest = 0, length = 0;
  for (const Class& c : classes_) {
    largest = std::max(largest, c.force->largestForce());
    length = std::max({length, c.force->length().i, c.force->length().j});
  }
  for (const Class& c : classes_) c.force->setUnits(largest, length);
}

const PairForce* PairForces::between(int a, int b) const {
  for (const Class& c : classes_)
    if ((c.first == a && c.second == b) || (c.first == b && c.second == a)) return c.force.get();
  return nullptr;
}

bool PairForces::touches() const {
  return std::ranges::any_of(classes_, [](const Class& c) { return c.force->touches(); });
}

bool PairForces::rubs() const {
  return std::ranges::any_of(classes_, [](const Class& c) { return c.force->rubs(); });
}

double PairForces::reach() const {
  double farthest = 0;
  for (const Class& c : classes_) farthest = std::max(farthest, c.force->reach());
  return farthest;
}

int PairForces::exclude() const {
  int most = 0;
  for (const Class& c : classes_)
    if (!c.mixed()) most = std::max(most, c.force->exclude());
  return most;
}

}  // namespace nanoweft
