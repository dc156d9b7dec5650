#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "mpc/plant_motion.hpp"
#include "mpc/time_line.hpp"
#include "ocp/step/step.hpp"

namespace conddp {

/// Step rule of a simulation.
struct StepRule {
  std::optional<Integrator> integrator;  ///< if unset, the integrator of the knot
  std::optional<double> dt;              ///< longest step, s; if unset, to the end of the knot
};

/// Simulates the dynamics of a time line, without its costs, step by step and through its instants.
/// Each step adds its length times the residual at its beginning to an integral. Allocates nothing
/// after construction.
class Simulation final : public PlantMotion {
 public:
  /// Throws std::invalid_argument if the integrator does not support a system.
  Simulation(const TimeLine& line, const StepRule& rule);

  /// Latest possible value: the end of the knot.
  double next_stop(double time) const override;
  void pass_instants(double time, double* x) override;
  void step(double time, double length, const double* u, double* x) override;

 private:
  struct Stepper {
    explicit Stepper(Step rule);
    Step step;
    StepWorkspace<double> work;
    AlignedVector<double> x, u;
  };
  void move(int knot, double length, const double* u, double* x);

  const TimeLine& line_;
  StepRule rule_;
  std::vector<std::unique_ptr<Stepper>> steppers_;
  std::vector<int> stepper_of_;  ///< by knot
};

/// A control that is held until it changes; null at first.
struct HeldControl {
  const double* u = nullptr;
  double until = -1;  ///< s
};

/// Moves x from one time to another under a control law. `law.control(time, x)` is the control from
/// a time on; `law.next_change(time)` is the time of its next evaluation. `begin(time, length, u)`
/// is called before each step and ends the simulation by returning false. In that case, this
/// function returns false, too.
template <class Law, class Begin>
bool simulate(PlantMotion& motion, double from, double to, Law& law, HeldControl& held, double* x,
              Begin begin) {
  for (double time = from; is_before(time, to);) {
    motion.pass_instants(time, x);
    if (!is_before(time, held.until)) held = {law.control(time, x), law.next_change(time)};
    double next = std::min({to, held.until, motion.next_stop(time)});
    if (!is_before(next, to)) next = to;
    if (!begin(time, next - time, held.u)) return false;
    motion.step(time, next - time, held.u, x);
    time = next;
  }
  return true;
}

}  // namespace conddp
