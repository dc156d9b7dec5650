#pragma once

#include <Eigen/Core>

#include "analysis/contact/contact_mechanics.hpp"

namespace conddp {

/// The forces of one step of time.
struct StepForces {
  /// 3 x candidates: along the normal and the tangents of each, N.
  Eigen::Matrix3Xd contact;
  /// N or Nm, of the stops below and above: not negative.
  Eigen::VectorXd stop_lower, stop_upper;
  /// Of dry friction, as they act on their joints: N or Nm.
  Eigen::VectorXd friction;

  explicit StepForces(const ImplicitContacts& contacts);
  bool finite() const;
};

/// Where a step begins, what drives it, and how long it takes.
struct StepStart {
  Eigen::VectorXd q, v;     ///< nq, nv
  Eigen::VectorXd applied;  ///< nv: generalised forces of the controls
  double h = 0;             ///< s
};

/// The equations of one step (ImplicitContacts::scheme) in scalar S, double or Dual<double>, as
/// impulses: nv numbers that are zero where the step is one of the plant.
template <class S>
class SteppingEquations {
 public:
  explicit SteppingEquations(const ContactPlant& plant)
      : plant_(plant),
        mechanics_(plant),
        q_(plant.nq()),
        reach_(plant.nv()),
        impulse_(plant.nv()) {}

  /// What inertia, gravity and controls leave for the contacts, with the velocity v after the step.
  const std::vector<S>& free_impulse(const StepStart& start, const S* v);
  /// Gaps and directions at the end of that step.
  const std::vector<ContactInstant<S>>& end(const StepStart& start, const S* v);
  /// Adds h times the generalised forces of all contacts, stops and dry friction, as `end` says.
  void add_forces(double h, const StepForces& forces, std::vector<S>& impulse) const;

 private:
  /// q_ at the end of a step that arrives with the velocity v: q ⊕ h v.
  void reach_end(const StepStart& start, const S* v);
  void backward_euler(const StepStart& start, const S* v);
  void variational_midpoint(const StepStart& start, const S* v);

  const ContactPlant& plant_;
  ContactMechanics<S> mechanics_;
  const std::vector<ContactInstant<S>>* instants_ = nullptr;
  std::vector<S> q_, reach_, impulse_;
};

/// The residual of a step, impulses in N s or N m s: zero for a step that the plant takes.
Eigen::VectorXd stepping_residual(const ContactPlant& plant, const StepStart& start,
                                  const Eigen::VectorXd& v, const StepForces& forces);

/// h m g: impulses of this size are what a step's residual is compared with, N s.
double impulse_scale(const ContactPlant& plant, double h);

}  // namespace conddp
