#include "nanoweft/fibre/kinds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

template <class Value>
double largest(const Kinds& kinds, const Value& value) {
  double most = 0;
  for (const Fibre& f : kinds) most = std::max(most, value(f));
  return most;
}

}  // namespace

std::vector<std::string> Kinds::names() const {
  std::vector<std::string> names;
  for (const Fibre& f : fibres_) names.push_back(f.kind);
  return names;
}

Kinds::Kinds(std::vector<Fibre> fibres) : fibres_(std::move(fibres)) {
  for (const Fibre& f : fibres_) restHalves_.push_back(rotation(0.5 * f.restRotation()));
}

bool Kinds::curved() const {
  return std::ranges::any_of(fibres_, &Fibre::curved);
}

bool Kinds::kinks() const {
  return std::ranges::any_of(fibres_, &Fibre::kinks);
}

bool Kinds::viscous() const {
  return std::ranges::any_of(fibres_, [](const Fibre& f) { return bool(f.viscosity); });
}

bool Kinds::yields() const {
  return std::ranges::any_of(fibres_, [](const Fibre& f) { return bool(f.yield); });
}

double Kinds::shortest() const {
  return std::ranges::min_element(fibres_, {}, &Fibre::length)->length;
}
double Kinds::longest() const {
  return largest(*this, [](const Fibre& f) { return f.length; });
}
double Kinds::thickest() const {
  return largest(*this, [](const Fibre& f) { return f.radius; });
}
double Kinds::forceScale() const {
  return largest(*this, [](const Fibre& f) { return f.bond.stretch * f.length; });
}
double Kinds::energyScale() const {
  return largest(*this, [](const Fibre& f) { return f.bond.stretch * f.length * f.length; });
}
double Kinds::speedOfSound() const {
  return largest(*this,
                 [](const Fibre& f) { return f.length * std::sqrt(f.bond.stretch / f.mass); });
}

Kinds readKinds(Options& options, const UnitSystem& units) {
  OptionSection s(options, "Fibre");
  const auto names = s.words("kinds",
                             "names of the kinds of fibre, where there are several: -fibre_..., "
                             "-break_... and -pair_points of a kind are -KIND_fibre_... and so on, "
                             "-pair_... and the laws' options of two kinds -KIND_KIND_pair_...; "
                             "without prefix they are meant for all");
  if (names.empty()) return readFibre(options, units);
  checkPrefixes("-kinds", "a kind of fibre", names);
  std::vector<Fibre> fibres;
  for (const std::string& name : names) {
    const OptionPrefix prefix(options, name);
    try {
      fibres.push_back(readFibre(options, units));
    } catch (const InputError& problem) {
      throw InputError("kind " + name + ": " + problem.what());
    }
    fibres.back().kind = name;
  }
  return Kinds(std::move(fibres));
}

Breakage::operator bool() const {
  return std::ranges::any_of(ofKinds_, [](const auto& law) { return law.has_value(); });
}

double Breakage::criticalStrain(int kind, std::int64_t fibre, std::int32_t index,
                                std::int32_t segments) const {
  const auto& law = (*this)[kind];
  return law ? law->criticalStrain(fibre, index, segments)
             : std::numeric_limits<double>::infinity();
}

Breakage readBreakageOf(const Kinds& kinds, Options& options, const UnitSystem& units,
                        std::uint64_t seed) {
  std::vector<std::optional<BreakageLaw>> laws;
  for (const Fibre& fibre : kinds) {
    const OptionPrefix prefix(options, fibre.kind);
    laws.push_back(readBreakage(options, units, fibre, seed));
  }
  return Breakage(std::move(laws));
}

}  // namespace nanoweft
