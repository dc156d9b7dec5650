#pragma once

#include <memory>

#include "ocp/step/step.hpp"

namespace conddp {

/// Controls that the states of a test hold.
enum class Memory { none, previous, linear };

/// Step whose states hold `held` numbers, then controls.
inline Step step_with(std::shared_ptr<const System> system, Integrator integrator, Memory memory,
                      int held = 0) {
  Step step(std::move(system), integrator);
  step.hold(held);
  if (memory == Memory::previous) step.remember_controls(0, step.system().actuators());
  if (memory == Memory::linear) step.make_controls_linear();
  return step;
}

/// Step whose states may hold the previous control.
inline Step step_with(std::shared_ptr<const System> system, Integrator integrator, bool previous) {
  return step_with(std::move(system), integrator, previous ? Memory::previous : Memory::none);
}

}  // namespace conddp
