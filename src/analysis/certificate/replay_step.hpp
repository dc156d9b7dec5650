#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// The controls of a step, which are the same at its ends unless they are linear.
struct StepControl {
  const double *begin, *end;
};

class CollocationStep;

/// Moves the states of one knot model in steps of any length, by its integrator or another one, in
/// scalar arithmetic. The slopes of a plan's collocation belong to its whole steps: those of other
/// steps are solved for.
class ReplayStep {
 public:
  /// The model has to outlive it.
  explicit ReplayStep(const KnotModel& model);
  /// By another rule. Throws std::invalid_argument where that is a collocation and the state space
  /// is curved.
  ReplayStep(const KnotModel& model, Integrator rule);
  ~ReplayStep();

  /// The system without slopes.
  const System& system() const { return *system_; }
  /// Its data at (x, u), before a step from there.
  const SystemData<double>& look(const double* x, const double* u);
  /// A step of dt from where it was looked at, in place. NaN where an implicit step has no
  /// solution.
  void go(const StepControl& u, double dt, double* x);

 private:
  std::shared_ptr<const System> system_;
  Integrator integrator_;
  bool linear_;
  std::unique_ptr<SystemData<double>> data_;
  std::optional<IntegratorWorkspace<double>> work_;
  std::unique_ptr<CollocationStep> implicit_;
};

}  // namespace conddp
