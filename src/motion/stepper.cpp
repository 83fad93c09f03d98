#include "nanoweft/motion/stepper.hpp"

#include "nanoweft/motion/fire.hpp"
#include "nanoweft/motion/verlet.hpp"

namespace nanoweft {

const std::vector<StepperKind>& stepperKinds() {
  static const std::vector<StepperKind> kinds{
      {"dynamics", "dynamics", false,
       [](const Kinds&, const StepperSettings& s) -> std::unique_ptr<Stepper> {
         return std::make_unique<Verlet>(s.dt, s.localDamping, s.thermostat);
       }},
      {"fire", "FIRE", true,
       [](const Kinds& kinds, const StepperSettings& s) -> std::unique_ptr<Stepper> {
         return std::make_unique<Fire>(kinds, s.dt, s.farthest);
       }},
  };
  return kinds;
}

}  // namespace nanoweft
