#pragma once

#include <Eigen/Core>

#include "analysis/contact/contact_mechanics.hpp"

namespace conddp {

/// Forces of one time step.
struct StepForces {
  /// 3 x candidates: components along the normal and the tangents of each, N.
  Eigen::Matrix3Xd contact;
  /// Forces of the lower and upper stops, N or Nm: not negative.
  Eigen::VectorXd stop_lower, stop_upper;
  /// Dry friction as it acts on its joints, N or Nm.
  Eigen::VectorXd friction;

  explicit StepForces(const ImplicitContacts& contacts);
  bool finite() const;
};

/// Initial state, applied forces and duration of a step.
struct StepStart {
  Eigen::VectorXd q, v;     ///< nq, nv
  Eigen::VectorXd applied;  ///< nv: generalized forces of the controls
  double h = 0;             ///< s
};

/// Equations of one step (ImplicitContacts::scheme) in scalar S, double or Dual<double>, as
/// impulses: nv numbers that vanish for a step of the plant.
template <class S>
class SteppingEquations {
 public:
  explicit SteppingEquations(const ContactPlant& plant)
      : plant_(plant),
        mechanics_(plant),
        q_(plant.nq()),
        reach_(plant.nv()),
        impulse_(plant.nv()) {}

  /// Impulse that inertia, gravity and controls leave for the contacts; v is the velocity after the
  /// step.
  const std::vector<S>& free_impulse(const StepStart& start, const S* v);
  /// Evaluates gaps and directions at the end of that step.
  const std::vector<ContactInstant<S>>& end(const StepStart& start, const S* v);
  /// Adds h times the generalized forces of all contacts, stops and dry friction, as evaluated by
  /// `end`.
  void add_forces(double h, const StepForces& forces, std::vector<S>& impulse) const;

 private:
  /// Sets q_ to the end of a step with final velocity v: q ⊕ h v.
  void reach_end(const StepStart& start, const S* v);
  void backward_euler(const StepStart& start, const S* v);
  void variational_midpoint(const StepStart& start, const S* v);

  const ContactPlant& plant_;
  ContactMechanics<S> mechanics_;
  const std::vector<ContactInstant<S>>* instants_ = nullptr;
  std::vector<S> q_, reach_, impulse_;
};

/// Residual of a step, impulses in N s or N m s: zero for a step of the plant.
Eigen::VectorXd stepping_residual(const ContactPlant& plant, const StepStart& start,
                                  const Eigen::VectorXd& v, const StepForces& forces);

/// Scale h m g for the residual of a step, N s.
double impulse_scale(const ContactPlant& plant, double h);

}  // namespace conddp
