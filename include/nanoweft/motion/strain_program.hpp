/// The course of the strain of a tension test with several legs (-tension_program), or of a
/// box (-deform_x_program).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nanoweft {

/// Legs one after the other, each to a strain at a rate. Within a leg the rate grows linearly
/// during the ramp, stays, and falls to zero in the same way, so that the leg ends at its strain at
/// rest. A leg too short to reach its rate has the same acceleration and a lower peak.
class StrainProgram {
 public:
  /// `pairs`: strain, rate, strain, rate, ... `ramp`: time of acceleration; empty: that of 0.01
  /// strain at full rate, for each leg. `name`: of the option. Strains must be above `least`.
  /// Throws InputError for what is no program.
  StrainProgram(const std::vector<double>& pairs, std::optional<double> ramp,
                const std::string& name = "-tension_program", double least = -1);

  /// Starts at a strain. Throws InputError when the first leg leads nowhere.
  void begin(double time, double strain);

  double strain(double time) const;
  /// Its derivative.
  double rate(double time) const;
  /// The largest and the smallest strain of a leg's end.
  double highest() const;
  double lowest() const;
  /// Time when the last leg is over.
  double end() const { return legs_.back().start + legs_.back().duration; }
  /// For people: "0.02 at 1e-06, then 0 at 1e-06".
  std::string text() const;

 private:
  struct Leg {
    double target, speed, ramp;     ///< as asked; speed and ramp are positive
    double start = 0, from = 0;     ///< set by `begin`, with what follows
    double peak = 0, duration = 0;  ///< peak: signed
  };
  const Leg& at(double time) const;

  std::string name_;
  std::vector<Leg> legs_;
};

}  // namespace nanoweft
