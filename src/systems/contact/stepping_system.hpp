#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "robot/data.hpp"
#include "systems/contact/candidate_geometry.hpp"
#include "systems/contact/contact_candidate.hpp"
#include "systems/multibody/multibody.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Forces of maximally dissipative dry friction: each ≥ 0, along ± the tangents, with a sum of at
/// most `budget`. Pairs: f_i ⊥ s_i = γ ± v_t, and γ ⊥ s_γ = budget − Σ f_i.
struct FrictionIndices {
  int count = 0;  ///< directions: two per tangent, positive sign first; 0: no friction
  std::array<int, 4> force{}, slip{};  ///< f_i and s_i
  int gamma = 0, rest = 0;             ///< γ and s_γ
};

/// Maximally dissipative friction in the cone ‖f_t‖ ≤ μ f_n for a slip v_t along two tangents. The
/// vector e is the used fraction of friction: f_t = −μ f_n e and v_t = γ e with ‖e‖ ≤ 1 and the
/// single pair γ ⊥ s = 1 − ‖e‖². For f_n > 0 these are the conditions of the cone, (μ f_n, f_t) ⊥
/// (γ, v_t) in second-order cones. In contrast to the latter, all rows have full rank at the tip of
/// the cone too.
struct ConeIndices {
  /// Equations: v_t = γ e, f_t = −μ f_n e, s = 1 − ‖e‖².
  static constexpr int kRows = 5;
  bool present = false;
  std::array<int, 2> force{}, use{};  ///< f_t and e, along the tangents
  int speed = 0, rest = 0;            ///< γ and s
};

/// Layout of the controls w of a stepping system: the actuators u, the accelerations a, then forces
/// and the slacks of their complementarity conditions. All forces and slacks belong to the end of
/// the step. Forces are means over the step, N or Nm.
struct SteppingLayout {
  struct Candidate {
    int force = 0, gap = 0;    ///< f_n and s_n = φ, or φ + f_n/stiffness
    FrictionIndices friction;  ///< for the pyramid
    ConeIndices cone;          ///< for the cone
  };
  /// One side of a stop: its force, ≥ 0 and directed away from the limit, and the distance to it.
  struct Stop {
    int joint = 0;
    int position = 0, velocity = 0;  ///< index in configurations and velocities
    bool upper = false;
    double limit = 0;  ///< rad or m
    int force = 0, distance = 0;
  };

  int actuators = 0;     ///< size of u, which comes first
  int acceleration = 0;  ///< start of a
  int nv = 0;
  std::vector<Candidate> candidates;  ///< in the order of the description, like the next two
  std::vector<Stop> stops;            ///< finite sides, lower before upper
  std::vector<FrictionIndices> frictions;
  std::vector<int> friction_velocities;  ///< velocity indices of the joints with friction
  std::vector<std::pair<int, int>> pairs;  ///< all complementarity conditions: 0 ≤ w_i ⊥ w_j ≥ 0
  std::vector<Column> columns;             ///< names and units of all of w

  int size() const { return static_cast<int>(columns.size()); }

  /// The layout for a robot with these actuators.
  SteppingLayout(const RobotModel& robot, const std::vector<Column>& actuator_columns,
                 const ImplicitContacts& contacts);
};

/// A robot halfway through a step at constant velocity, for the midpoint rule of variational
/// mechanics (Marsden and West 2001). It has the momentum P = M(q) v and the load C = g(q) −
/// ∂T/∂q(q, v), less external wrenches, where T = ½ vᵀ M v. For robots with one-DoF joints.
template <class S>
struct HalfStep {
  explicit HalfStep(const RobotModel& robot);

  AlignedVector<S> position;                             ///< q, nq: point of evaluation
  AlignedVector<S> momentum, load;                       ///< nv
  AlignedVector<S> momentum_q, load_q;                   ///< nv x nv by columns
  const AlignedVector<S>& mass() const { return at.M; }  ///< its lower triangle: ∂P/∂v
  /// ∂C/∂v is −(∂P/∂q)ᵀ.
  S load_v(int row, int column) const { return -momentum_q[row * nv + column]; }

  int nv;
  RobotData<S> at;
  /// Along q + ε v: the derivatives by ε are those of P along the motion.
  RobotData<Dual<S>> along;
  AlignedVector<Dual<S>> q, v, rest;
};

/// Computes momentum and load at half.position and v, with their derivatives if `slopes` is true.
/// `free` is the robot without gravity and external wrenches.
template <class S>
void update_half_step(const RobotModel& robot, const RobotModel& free, const S* v, bool slopes,
                      HalfStep<S>& half);

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
  /// The accelerations are controls.
  bool is_linear() const override { return true; }
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

}  // namespace conddp
