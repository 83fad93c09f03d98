#include "nanoweft/motion/stepper.hpp"

#include "nanoweft/motion/fire.hpp"
#include "nanoweft/motion/verlet.hpp"

namespace nanoweft {

const std::vector<StepperKind>& stepperKinds() {
  static const std::vector<StepperKind> kinds{
      {"dynamics", "dynamics", false,
       [](const Kinds&, double dt, double localDamping) -> std::unique_ptr<Stepper> {
         return std::make_unique<Verlet>(dt, localDamping);
       }},
      {"fire", "FIRE", true,
       [](const Kinds& kinds, double dt, double) -> std::unique_ptr<Stepper> {
         return std::make_unique<Fire>(kinds, dt);
       }},
  };
  return kinds;
}

}  // namespace nanoweft
