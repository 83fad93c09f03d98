#include "nanoweft/force/contact_read.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/contact_force.hpp"

namespace nanoweft {

namespace {

/// Overlap over the thinner radius for which the step for fibres pressed together is estimated.
constexpr double usualOverlap = 0.05;

/// E* from the moduli across the axes; 0: a kind has none.
double usualModulus(const Fibre& a, const Fibre& b) {
  if (!(a.transverse > 0 && b.transverse > 0)) return 0.0;
  auto compliance = [](const Fibre& f) { return (1.0 - f.poisson * f.poisson) / f.transverse; };
  return 1.0 / (compliance(a) + compliance(b));
}

/// With the defaults of `usual`, where NaN stands for what has to be given.
FrictionLaw readFriction(const PairReader& read, OptionSection& s, const FrictionLaw& usual) {
  auto real = [&](OptionSection& of, bool used, const char* name, double value, double without,
                  const char* help, const Bounds& bounds) {
    const double found = of.real(name, std::isnan(value) ? without : value, "", help, bounds);
    if (std::isnan(value) && !of.given(name) && used)
      throw InputError("-pair contact: give " + read.option(name) +
                       ", since the two kinds' own differ");
    return found;
  };
  FrictionLaw law;
  const bool touches = read.is("contact");
  law.mu = real(s, touches, "contact_friction", usual.mu, 0.0, "coefficient of friction",
                coefficientBounds);
  const bool rubs = touches && law.mu > 0;
  OptionSection sticking(read.options, PairReader::topic, rubs,
                         touches ? "there is no -contact_friction" : "-pair is " + read.laws());
  law.tangential =
      real(sticking, rubs, "contact_tangential", usual.tangential, law.tangential,
           "stiffness of a contact along the surfaces over that across", tangentialBounds);
  law.restitution = real(s, touches, "contact_restitution", usual.restitution, law.restitution,
                         "nominal speed after a collision over that before it, on a linear "
                         "spring; as damping is at most the load, 0.8, 0.5, 0.2 give 0.82, 0.60, "
                         "0.42, and 0.28 is the least (crossed segments: manual, 19); 1: not "
                         "damped; 0 counts as 0.001",
                         {0.0, 1.0});
  law.mass = read.a.mass * read.b.mass / (read.a.mass + read.b.mass);
  return law;
}

}  // namespace

std::unique_ptr<PairForce> readContact(const PairReader& read, const PairChoice& choice,
                                       FrictionLaw& friction) {
  OptionSection s = read.of("contact");
  const Fibre &a = read.a, &b = read.b;
  const auto given =
      s.maybeReal("contact_modulus", "from the moduli across the axes", "GPa",
                  "E* of the contact: 1/E* is the sum of (1 - nu^2)/E of both", positive);
  const int points = static_cast<int>(
      s.integer("contact_points", 6, "points a segment where fibres lie along each other", 1, 99));
  friction = readFriction(read, s, friction);
  if (!read.is("contact")) return nullptr;
  const double modulus = given ? *given * read.units.gigapascal : usualModulus(a, b);
  if (!(modulus > 0))
    throw InputError("-pair contact: give " + read.option("contact_modulus") +
                     " (GPa), or -fibre_transverse_young of the fibres");
  const ContactLaw law(modulus, {a.radius, b.radius}, choice.length, points);
  const double thinner = std::min(a.radius, b.radius), usual = usualOverlap * thinner;
  PairTraits traits;
  traits.description =
      format("contact, E* %.5g GPa, %d points along, range %.6g %s",
             modulus / read.units.gigapascal, points, law.touch(), read.units.length);
  if (friction)
    traits.description += format(", friction %g, tangential stiffness %.4g, restitution %g",
                                 friction.mu, friction.tangential, friction.restitution);
  traits.cutoff = traits.restDistance = law.touch();
  // In a bundle six neighbours press a segment, and all six hold back its turning: 12 k_t r^2/I
  // where both sides turn, and 6 k/m across.
  for (const Fibre* f : {&a, &b})
    if (friction.mu > 0)
      traits.sticking = std::max(
          traits.sticking,
          2.0 * friction.tangential * std::max(1.0, f->mass * f->radius * f->radius / f->inertia));
  // Deeper than a radius, fibres have passed through each other.
  traits.closestSensible = law.touch() - thinner;
  traits.radius = {a.radius, b.radius};
  traits.contactStiffness = std::max(law.lineStiffness(), law.crossedStiffness(usual));
  traits.largestForce = 8.0 * (law.crossedForce(law.touch()) + law.lineStiffness() * law.touch());
  return makeContactForce(law, friction, traits, choice);
}

}  // namespace nanoweft
