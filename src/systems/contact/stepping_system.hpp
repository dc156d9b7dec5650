#pragma once

#include <optional>

#include "systems/contact/candidate_geometry.hpp"
#include "systems/contact/half_step.hpp"
#include "systems/contact/stepping_layout.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A robot whose steps are implicit: the control is w = (u, a, forces, slacks) as SteppingLayout
/// says, and the dynamics are a alone. That a and the forces obey the equations of motion of the
/// scheme and those of contact at the end of the step, q⁺ = q ⊕ h v⁺ and v⁺ = v + h a, are
/// constraints (stepping_residual, and one on the pairs). So every step of a trajectory may find
/// out itself which contacts are closed.
class SteppingSystem : public SystemBase<SteppingSystem> {
 public:
  /// Throws std::invalid_argument where a joint mimics another one, or floats with the midpoint
  /// rule, whose steps are on flat spaces.
  SteppingSystem(std::shared_ptr<const MultibodySystem> robot, ImplicitContacts contacts);

  template <class S>
  struct Data : MultibodySystem::Data<S> {
    explicit Data(const SteppingSystem& system);
    MultibodySystem::Data<S> end;  ///< of the robot at the end of the step
    AlignedVector<S> q, v;         ///< there
    /// nv: what the equations of motion leave for contacts, stops and dry friction of joints, N or
    /// Nm, and its derivatives (nv x nv by columns) by q, v and a at the knot.
    AlignedVector<S> motion, motion_q, motion_v, motion_a;
    std::optional<HalfStep<S>> half;  ///< of the variational midpoint rule
    /// Derivatives of q⁺ = q ⊕ h v⁺ by q and by h v⁺ on curved parts (StateManifold's blocks).
    AlignedVector<S> reach, wrt_q, wrt_reach;
    std::vector<CandidateRows<S>> candidates;
  };

  const SteppingSystem* as_stepping() const override { return this; }
  const MultibodySystem* robot_inside() const override { return robot_.get(); }
  const MultibodySystem& multibody() const { return *robot_; }
  const ImplicitContacts& contacts() const { return contacts_; }
  const SteppingLayout& layout() const { return layout_; }
  const std::vector<CandidateGeometry>& geometry() const { return geometry_; }
  /// The space of configurations: its curved parts are floating bases.
  const StateManifold& configurations() const { return configurations_; }

  template <class S>
  void evaluate_as(const S* x, const S* w, Data<S>& data) const;
  template <class S>
  void differentiate_as(const S* x, const S* w, Data<S>& data) const;
  template <class S>
  void update_kinematics_as(const S* x, Data<S>& data) const;
  /// Data of a step of h: q, v and the robot's kinematics at its end, the equations of motion, and
  /// the candidates' rows, with slopes if asked for.
  template <class S>
  void take_step(const S* x, const S* w, const S& h, bool slopes, Data<S>& data) const;
  /// Corrects derivatives by q, v and a (rows x columns each, by columns) that were formed as if
  /// q⁺ were q + h v⁺: on a curved part whose columns start at `first`, the derivative by q is that
  /// by the tangents at q⁺. `part`: which of the curved ones; after take_step with slopes.
  template <class S>
  void bend(const Data<S>& data, int part, const S& h, int rows, int first, S* by_q, S* by_v,
            S* by_a) const;

 private:
  /// M(q⁺) a + c(q⁺, v⁺) − B u.
  template <class S>
  void backward_euler(const S* w, const S& h, bool slopes, Data<S>& data) const;
  /// (P⁺ − P⁻)/h + ½ (C⁺ + C⁻) − B u, with momentum and load halfway (HalfStep) through this step
  /// and the one before, at q ± ½ h v of its own velocity.
  template <class S>
  void variational_midpoint(const S* x, const S* w, const S& h, bool slopes, Data<S>& data) const;

  /// One of the two halves, after (sign 1) and before the knot (−1).
  template <class S>
  void add_half_step(double sign, const S* x, const S* w, const S& h, bool slopes,
                     Data<S>& data) const;
  template <class S>
  void add_half_step_slopes(double sign, const S* v, const S& h, Data<S>& data) const;
  /// q⁺ = q ⊕ h v⁺.
  template <class S>
  void move_configuration(const S* x, const S& h, bool slopes, Data<S>& data) const;
  void check_joints() const;

  std::shared_ptr<const MultibodySystem> robot_;
  StateManifold configurations_;
  RobotModel free_;  ///< without gravity and external wrenches, of the midpoint rule alone
  ImplicitContacts contacts_;
  SteppingLayout layout_;
  std::vector<CandidateGeometry> geometry_;
};

/// Whether x⁺ is a linear function of x and u, so that its second derivatives vanish, but on curved
/// parts of the configuration.
bool has_linear_step(const System& system);

}  // namespace conddp
