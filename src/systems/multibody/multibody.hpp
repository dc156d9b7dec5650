#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robot/dynamics.hpp"
#include "robot/model.hpp"
#include "systems/multibody/column_solver.hpp"
#include "systems/multibody/contact_set.hpp"
#include "systems/multibody/mimic_map.hpp"
#include "systems/system.hpp"

namespace conddp {

/// A rotor or jet on the floating base: thrust u along `direction` (unit vector in the frame) with
/// a reaction torque torque_ratio·u about it.
struct Thruster {
  std::string name;
  int frame = 0;
  Vector3<double> direction{0, 0, 1};
  double torque_ratio = 0;    ///< Nm per N, signed
  double lower = 0;           ///< N
  double upper = kUnlimited;  ///< N
};

/// The action of controls: generalized forces are B u with a constant nv x nu matrix.
struct Actuation {
  int nu = 0;
  std::vector<double> B;  ///< nv x nu by columns, rows of the model's velocity
  std::vector<Column> columns;
  std::vector<double> lower, upper;

  /// One generalized force per independent one-DoF joint, in the model's order, with URDF effort
  /// limits. Joints that mimic another one are not actuated.
  static Actuation full(const RobotModel& model);
  /// Only the named joints. Throws std::invalid_argument on an unknown, floating or mimic joint.
  static Actuation joints(const RobotModel& model, const std::vector<std::string>& names);
  /// Thrusters on the floating base, then the named joints. Throws std::invalid_argument if a
  /// thruster's frame is not fixed to a floating base.
  static Actuation thrusters(const RobotModel& model, const std::vector<Thruster>& thrusters,
                             const std::vector<std::string>& joint_names);
};

/// Joint damping and Coulomb friction from the URDF; off by default. Friction is smoothed:
/// −friction·tanh(v / friction_velocity).
struct PassiveForces {
  bool damping = false;
  bool friction = false;
  double friction_velocity = 0.01;  ///< rad/s or m/s
};

/// Rigid-body dynamics of a RobotModel: x = (q, v), a = M⁻¹ (B u + passive − bias). Columns are
/// named base/x .. base/qw, q/<joint>, then base/vx .. base/wz, v/<joint>; u/<joint> or
/// u/<thruster>. A parameter of the robot has a column with its own name and one with its rate,
/// <name>_rate; both are by_name_only.
///
/// With mimic joints, x contains only the independent joints. With v_full = G v the dynamics are Gᵀ
/// M G a = Gᵀ (B u + passive − bias), including the damping and friction of mimic joints.
///
/// With contacts, the dynamics are M a = B u + passive − bias + Jᵀλ, where the forces λ enforce the
/// contacts' accelerations (see Contact and ContactSet). An impulse stops the contacts instantly: M
/// (v⁺ − v) = Jᵀλ and J v⁺ = −restitution·J v, with λ in Ns and Nms and without controls.
class MultibodySystem : public SystemBase<MultibodySystem> {
 public:
  /// Throws std::invalid_argument under the conditions of MimicMap.
  MultibodySystem(std::shared_ptr<const RobotModel> robot, Actuation actuation,
                  PassiveForces passive = {}, std::vector<Contact> contacts = {});
  /// An impulse at contacts (SystemKind::impulse); restitution from 0 (no rebound) to 1.
  MultibodySystem(std::shared_ptr<const RobotModel> robot, std::vector<Contact> contacts,
                  double restitution);

  ContactRank contact_rank(const double* x) const override;
  const MultibodySystem* as_multibody() const override { return this; }

  /// Buffers of full coordinates and reduced matrices; empty without mimic joints. n and nv are the
  /// full and the reduced number of velocities.
  template <class S>
  struct MimicData {
    AlignedVector<S> q, v;                ///< full configuration and velocity
    AlignedVector<S> M;                   ///< nv x nv: factors of Gᵀ M G
    AlignedVector<S> gravity, gravity_q;  ///< n, n x n
    AlignedVector<S> columns;             ///< 6 x n: RobotData's columns in full coordinates
  };
  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const MultibodySystem& system);
    RobotData<S> robot;                   ///< of all joints, in full coordinates
    AlignedVector<S> force;               ///< nv: B u + passive forces
    AlignedVector<S> gravity, gravity_q;  ///< nv, nv x nv: see gravity_torques
    AlignedVector<S> velocity;            ///< of the robot, scratch of impulses
    AlignedVector<S> columns;             ///< 6 x robot().nv: scratch for Jacobians of residuals
    AlignedVector<S> frame_columns;       ///< the same, of pairs of frames
    MimicData<S> mimic;
    ContactSet::Data<S> contacts;
    ColumnSolver::Data<S> solver;
  };

  /// The same system with exactly these contacts.
  std::shared_ptr<MultibodySystem> with_contacts(std::vector<Contact> contacts) const;

  /// Adds a compliance, in every state, to contact forces that are redundant, or nearly so, in the
  /// state x (nx numbers). Away from such a state, rigid forces would change by orders of magnitude
  /// within milliradians.
  void soften_redundant_contacts(const double* x);

  const RobotModel& robot() const { return *robot_; }
  const std::shared_ptr<const RobotModel>& shared_robot() const { return robot_; }
  /// B has the rows of the system's velocity: GᵀB with mimic joints.
  const Actuation& actuation() const { return actuation_; }
  const ContactSet& contacts() const { return contacts_; }
  const PassiveForces& passive() const { return passive_; }
  /// Actuated velocity indices, ascending.
  std::vector<int> actuated_rows() const;

  /// Maps the system's coordinates to the robot's.
  const MimicMap& mimic_map() const { return mimics_; }
  /// Indices of a joint's first position and velocity in the state, and of its velocity in v. The
  /// last one is also the index of its acceleration and of its position in a tangent vector.
  /// nullopt for a mimic joint.
  std::optional<int> position_index(int joint) const { return mimics_.position(joint); }
  std::optional<int> velocity_index(int joint) const;
  std::optional<int> velocity_row(int joint) const { return mimics_.velocity(joint); }
  /// Convert between a robot's configuration and velocity (robot().nq and robot().nv numbers) and
  /// those of the state (nq(), nv()). Reduction ignores mimic joints; without them both are copies.
  std::vector<double> reduce_configuration(const std::vector<double>& full) const;
  std::vector<double> expand_configuration(const std::vector<double>& q) const;
  std::vector<double> reduce_velocity(const std::vector<double>& full) const;
  std::vector<double> expand_velocity(const std::vector<double>& v) const;
  /// Gᵀ f for the robot's generalized forces.
  std::vector<double> reduce_force(const std::vector<double>& full) const;

  struct JointLimits {
    double lower, upper, max_velocity;
  };
  /// A joint's own limits, tightened by those of the joints that mimic it.
  JointLimits limits(int joint) const;

  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const;
  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const;
  template <class S>
  void update_kinematics_as(const S* x, Data<S>& data) const;
  /// Writes gravity torques into data.gravity and, if requested, their derivative into
  /// data.gravity_q. Composite inertias must be current.
  template <class S>
  void gravity_torques(Data<S>& data, bool derivative) const;
  /// Writes B u + passive forces, at the velocity v of the state, into data.force.
  template <class S>
  void applied_forces(const S* v, const S* u, Data<S>& data) const;
  /// Adds the contribution of passive forces to ∂tau/∂v (nv x nv by columns).
  template <class S>
  void add_passive_slopes(const S* v, S* tau_v) const;
  /// Adds the same contribution to the gradient of wᵀtau by v (nv).
  template <class S>
  void add_passive_slopes(const S* v, const S* w, S* gradient) const;
  std::unique_ptr<SecondDerivatives> second_derivatives(
      SystemData<Lane>& at, SystemData<Dual<Lane>>& moving) const override;

 private:
  friend class MultibodySecondDerivatives;

  /// The robot's full configuration and velocity in a state.
  template <class S>
  struct Coordinates {
    const S *q, *v;
  };
  template <class S>
  Coordinates<S> full_coordinates(const S* x, Data<S>& data) const;
  template <class S>
  MassFactors<S> mass_factors(const Data<S>& data) const;
  /// Updates the kinematics and the factors of M.
  template <class S>
  void update_mass(const Coordinates<S>& full, Data<S>& data) const;
  /// Updates the contacts' Jacobians and the factors of G; M must be factored.
  template <class S>
  void prepare_contacts(Data<S>& data) const;
  /// Adds the contact forces to data.f, which contains the half-solved right-hand side.
  template <class S>
  void hold_contacts(Data<S>& data) const;
  /// Writes the negative derivatives of the contacts' accelerations or velocities into force_z.
  template <class S>
  void load_contact_derivatives(Data<S>& data) const;
  /// Clears the derivative of inverse dynamics by the configuration where it writes nothing and
  /// loops do: joints of one branch move forces on another.
  template <class S>
  void clear_other_branches(Data<S>& data) const;
  /// Expands the velocity of the system to that of the robot.
  template <class S>
  void expand_velocity(const S* v, S* full) const;
  void index_actuation();
  void add_passive_joints();
  template <class S>
  void evaluate_impulse(const S* x, Data<S>& data) const;
  template <class S>
  void differentiate_impulse(const S* x, Data<S>& data) const;
  template <class S>
  const S* differentiate_impulse_balance(const S* x, Data<S>& data) const;
  template <class S>
  void differentiate_impulse_contacts(const S* x, Data<S>& data) const;

  /// Passive force −damping·v − friction·tanh(v / friction_velocity) on a row.
  struct PassiveJoint {
    int row;
    double damping, friction, friction_velocity;
  };
  template <class S>
  static S slope(const PassiveJoint& joint, const S& v);

  std::shared_ptr<const RobotModel> robot_;
  MimicMap mimics_;
  Actuation actuation_;
  ContactSet contacts_;
  double restitution_ = 0;
  std::shared_ptr<const RobotModel> weightless_;  ///< for impulses: no gravity, no wrenches
  std::vector<ColumnSolver::Entry> entries_;      ///< nonzero entries of B
  ColumnSolver solver_;
  PassiveForces passive_;
  std::vector<PassiveJoint> passive_joints_;
};

}  // namespace conddp
