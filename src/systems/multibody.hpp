#pragma once

#include <memory>
#include <string>
#include <vector>

#include "robot/dynamics.hpp"
#include "robot/model.hpp"
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

/// How controls act: generalised forces are B u with a constant nv x nu matrix.
struct Actuation {
  int nu = 0;
  std::vector<double> B;  ///< nv x nu by columns
  std::vector<Column> columns;
  std::vector<double> lower, upper;

  /// One generalised force per one-DoF joint, in the model's order, with URDF effort limits.
  static Actuation full(const RobotModel& model);
  /// The named joints alone. Throws std::invalid_argument on an unknown or floating joint.
  static Actuation joints(const RobotModel& model, const std::vector<std::string>& names);
  /// Thrusters on the floating base, then the named joints. Throws std::invalid_argument where a
  /// thruster's frame is not fixed to a floating base.
  static Actuation thrusters(const RobotModel& model, const std::vector<Thruster>& thrusters,
                             const std::vector<std::string>& joint_names);
};

/// Joint damping and Coulomb friction as the URDF states them; off unless asked for. Friction is
/// smoothed: −friction·tanh(v / friction_velocity).
struct PassiveForces {
  bool damping = false;
  bool friction = false;
  double friction_velocity = 0.01;  ///< rad/s or m/s
};

/// Rigid-body dynamics of a RobotModel: x = (q, v), a = M⁻¹ (B u + passive − bias).
/// Columns are named as DESIGN has it: base/x .. base/qw, q/<joint>, then base/vx .. base/wz,
/// v/<joint>; u/<joint> or u/<thruster>.
class MultibodySystem : public SystemBase<MultibodySystem> {
 public:
  MultibodySystem(std::shared_ptr<const RobotModel> robot, Actuation actuation,
                  PassiveForces passive = {});

  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const MultibodySystem& system);
    RobotData<S> robot;
    AlignedVector<S> force;               ///< nv: B u + passive forces
    AlignedVector<S> gravity, gravity_q;  ///< scratch for residuals: nv, nv x nv
  };

  const RobotModel& robot() const { return *robot_; }
  const Actuation& actuation() const { return actuation_; }
  /// Velocity indices on which controls act, ascending.
  std::vector<int> actuated_rows() const;

  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const;
  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const;
  template <class S>
  void update_kinematics_as(const S* x, Data<S>& data) const;

 private:
  template <class S>
  void applied_forces(const S* v, const S* u, Data<S>& data) const;

  struct Entry {
    int row, column;
    double value;
  };
  std::shared_ptr<const RobotModel> robot_;
  Actuation actuation_;
  PassiveForces passive_;
  std::vector<Entry> entries_;  ///< non-zeros of B
};

}  // namespace conddp
