#pragma once

#include <optional>

#include "systems/contact/candidate_geometry.hpp"
#include "systems/contact/half_step.hpp"
#include "systems/contact/stepping_layout.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A robot with implicit steps: the control is w = (u, a, forces, slacks) in the layout of
/// SteppingLayout, and the dynamics are just a. Constraints enforce the scheme's equations of
/// motion, and the contact conditions at the end of the step (stepping_residual, and one for the
/// pairs). The step ends at q⁺ = q ⊕ h v⁺ with v⁺ = v + h a. So the solution determines which
/// contacts are closed in each step.
class SteppingSystem : public SystemBase<SteppingSystem> {
 public:
  /// Throws std::invalid_argument if a joint mimics another one, or if a joint floats with the
  /// midpoint rule, which needs a flat space.
  SteppingSystem(std::shared_ptr<const MultibodySystem> robot, ImplicitContacts contacts);

  template <class S>
  struct Data : MultibodySystem::Data<S> {
    explicit Data(const SteppingSystem& system);
    MultibodySystem::Data<S> end;  ///< of the robot at the end of the step
    AlignedVector<S> q, v;         ///< at the end of the step
    /// nv: residual of the equations of motion without contacts, stops and dry friction of joints,
    /// N or Nm. Its derivatives (nv x nv by columns) are by q, v and a at the knot.
    AlignedVector<S> motion, motion_q, motion_v, motion_a;
    std::optional<HalfStep<S>> half;  ///< for the variational midpoint rule
    /// Derivatives of q⁺ = q ⊕ h v⁺ by q and by h v⁺ on curved parts (StateManifold's blocks).
    AlignedVector<S> reach, wrt_q, wrt_reach;
    std::vector<CandidateRows<S>> candidates;
    AlignedVector<S> jacobian;  ///< scratch memory of residuals
  };

  const SteppingSystem* as_stepping() const override { return this; }
  const MultibodySystem* robot_inside() const override { return robot_.get(); }
  const MultibodySystem& multibody() const { return *robot_; }
  const ImplicitContacts& contacts() const { return contacts_; }
  const SteppingLayout& layout() const { return layout_; }
  const std::vector<CandidateGeometry>& geometry() const { return geometry_; }
  /// The configuration space; its curved parts are floating bases.
  const StateManifold& configurations() const { return configurations_; }

  template <class S>
  void evaluate_as(const S* x, const S* w, Data<S>& data) const;
  template <class S>
  void differentiate_as(const S* x, const S* w, Data<S>& data) const;
  template <class S>
  void update_kinematics_as(const S* x, Data<S>& data) const;
  /// Computes the data of a step of length h: q, v and the robot's kinematics at its end, the
  /// equations of motion, and the candidates' rows. Includes derivatives if `slopes` is true.
  template <class S>
  void take_step(const S* x, const S* w, const S& h, bool slopes, Data<S>& data) const;
  /// Corrects derivatives by q, v and a (rows x columns each, by columns) that were formed as if q⁺
  /// were q + h v⁺. On a curved part whose columns start at `first`, the derivative by q is that by
  /// the tangents at q⁺. `part` is the index of the curved part. Requires take_step with slopes.
  template <class S>
  void bend(const Data<S>& data, int part, const S& h, int rows, int first, S* by_q, S* by_v,
            S* by_a) const;

 private:
  /// M(q⁺) a + c(q⁺, v⁺) − B u.
  template <class S>
  void backward_euler(const S* w, const S& h, bool slopes, Data<S>& data) const;
  /// (P⁺ − P⁻)/h + ½ (C⁺ + C⁻) − B u. Momentum and load are taken halfway (HalfStep) through this
  /// step and the preceding one, at q ± ½ h v with the respective velocity.
  template <class S>
  void variational_midpoint(const S* x, const S* w, const S& h, bool slopes, Data<S>& data) const;

  /// Adds the half step after the knot (sign 1) or before it (−1).
  template <class S>
  void add_half_step(double sign, const S* x, const S* w, const S& h, bool slopes,
                     Data<S>& data) const;
  template <class S>
  void add_half_step_slopes(double sign, const S* v, const S& h, Data<S>& data) const;
  /// Computes q⁺ = q ⊕ h v⁺.
  template <class S>
  void move_configuration(const S* x, const S& h, bool slopes, Data<S>& data) const;
  void check_joints() const;

  std::shared_ptr<const MultibodySystem> robot_;
  StateManifold configurations_;
  RobotModel free_;  ///< without gravity and external wrenches; midpoint rule only
  ImplicitContacts contacts_;
  SteppingLayout layout_;
  std::vector<CandidateGeometry> geometry_;
};

/// True if x⁺ is linear in x and u, except on curved parts of the configuration, so that its second
/// derivatives vanish.
bool has_linear_step(const System& system);

}  // namespace conddp
