#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "mpc/time_line.hpp"
#include "ocp/step/step.hpp"

namespace conddp {

/// Motion of a plant, step by step.
class PlantMotion {
 public:
  virtual ~PlantMotion() = default;

  /// Latest end of a step from `time`, s.
  virtual double next_stop(double time) const = 0;
  /// Applies the instantaneous events at a time to x.
  virtual void pass_instants(double time, double* x) = 0;
  /// Advances x by a step with a constant control.
  virtual void step(double time, double length, const double* u, double* x) = 0;
  /// Contacts that are closed after the last step, one bit each in the order of the file. 0 if the
  /// plant does not find contacts itself.
  virtual std::uint32_t closed_contacts() const { return 0; }
  /// Reason why the last step failed and left a non-finite state; empty if it succeeded.
  virtual std::string_view failure() const { return {}; }
  /// Forces of all contacts on the robot during the last step, N, in the order of the file. Three
  /// numbers each in world axes, NaN if the contact was open. Empty if the plant does not find
  /// contacts itself.
  virtual std::span<const double> contact_forces() const { return {}; }
};

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

/// From a time on, the plant moves as this problem's systems do, phase by phase, or by its own
/// motion. Its actuators are limited by the problem's control bounds.
struct PlantPeriod {
  double from = 0;  ///< s
  std::shared_ptr<const ShootingProblem> problem = nullptr;
  std::shared_ptr<PlantMotion> motion = nullptr;  ///< replaces the problem's systems
};

/// Period that contains a time, from periods in order; null for an empty list.
const PlantPeriod* period_at(std::span<const PlantPeriod> periods, double time);

/// Motions of a plant, period by period.
class PlantMotions {
 public:
  /// `periods` begin at time 0, in order. If empty, the plant moves as the model, which must
  /// outlive this. Throws std::invalid_argument if a period's states or times differ from the
  /// model's, or the first period begins after time 0.
  PlantMotions(std::span<const PlantPeriod> periods, const StepRule& step, const TimeLine& model);

  PlantMotion& at(double time) const;
  /// Start times of the periods, s.
  const std::vector<double>& begins() const { return begins_; }

 private:
  void add(double from, std::shared_ptr<PlantMotion> motion);

  std::vector<std::unique_ptr<TimeLine>> lines_;
  std::vector<double> begins_;
  std::vector<std::shared_ptr<PlantMotion>> motions_;
};

}  // namespace conddp
