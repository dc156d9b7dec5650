#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Controls at the ends of a step; they are equal unless the controls are linear.
struct StepControl {
  const double *begin, *end;
};

class CollocationStep;

/// Moves the states of one knot model in steps of any length, by its integrator or another one, in
/// scalar arithmetic. The collocation slopes of a plan belong to its whole steps; those of other
/// steps are solved for.
class ReplayStep {
 public:
  /// The model must outlive this object.
  explicit ReplayStep(const KnotModel& model);
  /// Uses another rule. Throws std::invalid_argument if that is a collocation and the state space
  /// is curved.
  ReplayStep(const KnotModel& model, Integrator rule);
  ~ReplayStep();

  /// The system without collocation slopes.
  const System& system() const { return *system_; }
  /// Evaluates the system at (x, u), before a step from there.
  const SystemData<double>& look(const double* x, const double* u);
  /// Moves x by a step of dt from the evaluated point, in place. x is NaN if an implicit step has
  /// no solution.
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
