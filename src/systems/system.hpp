#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "spatial/aligned.hpp"
#include "spatial/dual.hpp"
#include "spatial/lane.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {

/// Reserved name of the clock, a state (s) of systems that depend on time. In second-order systems
/// its rate (s/s) is a state too.
inline constexpr const char* kClock = "t";
inline constexpr const char* kClockRate = "t_rate";

/// Second derivatives of a system's output f(z), z = (tangent at x, u), weighted row by row, at one
/// point in each lane. If f depends on contact forces λ(z), which residuals use too, these have
/// weights as well. System::second_derivatives creates the object for two workspaces: `at` holds
/// the linearization point, and `moving` is moved along directions of z for residuals that need
/// their own second derivatives.
///
/// The forces and accelerations y solve the equations of motion r(z, y) = 0. With the adjoint w of
/// these equations, the second derivative of the weighted sum is that of −wᵀr along the graph of
/// y(z). Since wᵀr is linear in y, we differentiate inverse dynamics twice, at O(nv) per direction.
class SecondDerivatives {
 public:
  virtual ~SecondDerivatives() = default;

  /// The number of forces.
  virtual int forces() const = 0;
  /// Brings `moving` to (x, u), after `at` has been differentiated there.
  virtual void start(const Dual<Lane>* x, const Dual<Lane>* u) = 0;
  /// True if `finish` adds everything, so that `move` is not needed for the system itself.
  virtual bool at_once() const { return false; }
  /// Sets the derivative of one force of `moving` to 1 and all others to 0.
  virtual void move_force(int row) = 0;
  /// Sets the weights of f (System::rows) and of the forces for subsequent calls.
  virtual void weigh(const Lane* of_f, const Lane* of_forces) = 0;
  /// Moves the kinematics and forces of `moving` along direction d of z; x is the state with that
  /// derivative. Adds the derivative along d of the weighted output's gradient to column d of
  /// `gradients` (nz x nz by columns).
  virtual void move(const Dual<Lane>* x, int d, Lane* gradients) = 0;
  /// Adds the terms due to the change of y to `gradients`; they are symmetric.
  virtual void finish(Lane* gradients) = 0;
};

/// The point at which a table is read along one of its arguments. NaN if unknown.
struct TableReading {
  std::string table;
  double at = 0;
  double first = 0, last = 0;  ///< first and last grid point

  /// Distance outside the range of the grid points; 0 within it.
  double beyond() const {
    if (std::isnan(at)) return 0;
    return at < first ? first - at : at > last ? at - last : 0;
  }
};

/// The number of independent rows of a system's contacts in a state, from the eigenvalues of G = J
/// M⁻¹ Jᵀ scaled to a unit diagonal. Rows along which the contact cannot move, such as those out of
/// the plane of a planar robot, do not count.
struct ContactRank {
  int rows = 0;  ///< 0 without contacts
  int rank = 0;
  /// Contacts that can push against each other without moving any joint, so that their forces are
  /// not determined; empty if rank = rows.
  std::vector<std::string> redundant;
  /// A matrix that makes nearly or fully redundant contact forces determined and moderate: added to
  /// G, it raises the eigenvalues to 0.01. Square in all rows, or empty.
  Eigen::MatrixXd softness;
};

/// The supported scalars of every system, residual and knot model.
#define CONDDP_FOR_EACH_SCALAR(X) X(double) X(Lane) X(Dual<Lane>)

/// The kind of a system determines its output:
/// - second_order: acceleration a(q, v, u), with x = (q, v);
/// - first_order: tangent velocity ẋ(x, u);
/// - discrete: next state x⁺(x, u) of a flat state space;
/// - impulse: velocity v⁺(q, v) after an instantaneous impulse, with x = (q, v).
enum class SystemKind { second_order, first_order, discrete, impulse };

/// Output of a system evaluated in scalar S. Matrices are by columns, all with `rows` rows: nv for
/// a second-order system and an impulse, ndx for the others.
template <class S>
struct SystemData {
  virtual ~SystemData() = default;
  AlignedVector<S> f;   ///< acceleration, tangent velocity, next state or next velocity
  AlignedVector<S> fx;  ///< rows x ndx, with respect to a tangent vector at x
  AlignedVector<S> fu;  ///< rows x nu
  /// Workspace for the later stages of an implicit step (CollocationSystem); otherwise null.
  std::unique_ptr<SystemData<S>> later;
};

class MultibodySystem;
class SteppingSystem;
class CollocationSystem;

/// A named column of a state or control, with its unit.
struct Column {
  std::string name;
  std::string unit;
  /// True for the clock and parameters: settings for all columns do not apply to them.
  bool by_name_only = false;
};

/// A dynamical system with controls: immutable and shared by all knots. Mutable data lives in
/// SystemData. Derive through SystemBase.
class System {
 public:
  virtual ~System() = default;

  SystemKind kind() const { return kind_; }
  const StateManifold& manifold() const { return manifold_; }
  int nx() const { return manifold_.nx(); }
  int ndx() const { return manifold_.ndx(); }
  int nu() const { return nu_; }
  /// Number of controls that drive the system; they come first. The others are unknowns of a step.
  virtual int actuators() const { return nu_; }
  /// Sizes of q and v of a second-order system's state (q, v).
  int nq() const { return nx() - nv(); }
  int nv() const { return ndx() / 2; }
  int rows() const {
    return kind_ == SystemKind::second_order || kind_ == SystemKind::impulse ? nv() : ndx();
  }
  const std::vector<Column>& state_columns() const { return state_columns_; }
  const std::vector<Column>& control_columns() const { return control_columns_; }
  /// True if the column belongs to this system. The others are states of other phases and are at
  /// rest here: they stay constant, and nothing depends on them.
  bool has_state(int column) const { return at_rest_.empty() || !at_rest_[column]; }
  /// Limits from the system's description (URDF effort limits); infinite without limits.
  const std::vector<double>& control_lower() const { return control_lower_; }
  const std::vector<double>& control_upper() const { return control_upper_; }

  /// `create_data(S{})` makes a workspace. `evaluate` writes f. `differentiate` writes f, fx, fu.
  /// `update_kinematics` computes the quantities that residuals at a node without controls need.
#define CONDDP_DECLARE(S)                                                            \
  virtual std::unique_ptr<SystemData<S>> create_data(S) const = 0;                   \
  virtual void evaluate(const S* x, const S* u, SystemData<S>& data) const = 0;      \
  virtual void differentiate(const S* x, const S* u, SystemData<S>& data) const = 0; \
  virtual void update_kinematics(const S* x, SystemData<S>& data) const = 0;
  CONDDP_FOR_EACH_SCALAR(CONDDP_DECLARE)
#undef CONDDP_DECLARE
  /// The number of independent rows of the active contacts in a state of nx numbers. All rows count
  /// as independent if the rank cannot be computed.
  virtual ContactRank contact_rank(const double* /*x*/) const { return {}; }

  /// The table readings of the equations at a knot.
  virtual std::vector<TableReading> table_readings(const double* /*x*/, const double* /*u*/) const {
    return {};
  }

  /// Names of the system's compiled functions that have reported failure since they were loaded.
  virtual std::vector<std::string> failed_functions() const { return {}; }
  /// True if second derivatives depend on a Hessian claimed by a compiled function.
  virtual bool has_claimed_hessian() const { return false; }

  /// The system cast to its type; null if it has another type.
  virtual const MultibodySystem* as_multibody() const { return nullptr; }
  virtual const SteppingSystem* as_stepping() const { return nullptr; }
  virtual const CollocationSystem* as_collocation() const { return nullptr; }
  /// The robot that this system is or steps; null without one.
  virtual const MultibodySystem* robot_inside() const { return as_multibody(); }

  /// True if f is linear in x and u, so that its second derivatives vanish.
  virtual bool is_linear() const { return false; }
  /// Second derivatives on two workspaces of the system, which must outlive the result. Null if
  /// dual numbers in `differentiate` are the only source of second derivatives.
  virtual std::unique_ptr<SecondDerivatives> second_derivatives(
      SystemData<Lane>& /*at*/, SystemData<Dual<Lane>>& /*moving*/) const {
    return nullptr;
  }

 protected:
  System(SystemKind kind, StateManifold manifold, int nu)
      : kind_(kind),
        manifold_(std::move(manifold)),
        nu_(nu),
        control_lower_(nu, -std::numeric_limits<double>::infinity()),
        control_upper_(nu, std::numeric_limits<double>::infinity()) {}

  SystemKind kind_;
  StateManifold manifold_;
  int nu_;
  std::vector<Column> state_columns_;
  std::vector<Column> control_columns_;
  std::vector<bool> at_rest_;  ///< by column of the state; empty if no column is at rest
  std::vector<double> control_lower_;
  std::vector<double> control_upper_;
};

/// Implements System's methods for every scalar by templates of `Derived`. These are a member
/// template `Data<S>` (derived from SystemData<S>, constructible from const Derived&) and
/// `evaluate_as<S>`, `differentiate_as<S>`, `update_kinematics_as<S>` taking Data<S>&.
template <class Derived>
class SystemBase : public System {
 public:
  using System::System;
#define CONDDP_OVERRIDE(S)                                                         \
  std::unique_ptr<SystemData<S>> create_data(S) const override {                   \
    auto data = std::make_unique<typename Derived::template Data<S>>(self());      \
    data->f.resize(rows());                                                        \
    data->fx.resize(rows() * ndx());                                               \
    data->fu.resize(rows() * nu());                                                \
    return data;                                                                   \
  }                                                                                \
  void evaluate(const S* x, const S* u, SystemData<S>& data) const override {      \
    self().template evaluate_as<S>(x, u, cast<S>(data));                           \
  }                                                                                \
  void differentiate(const S* x, const S* u, SystemData<S>& data) const override { \
    self().template differentiate_as<S>(x, u, cast<S>(data));                      \
  }                                                                                \
  void update_kinematics(const S* x, SystemData<S>& data) const override {         \
    self().template update_kinematics_as<S>(x, cast<S>(data));                     \
  }
  CONDDP_FOR_EACH_SCALAR(CONDDP_OVERRIDE)
#undef CONDDP_OVERRIDE

 private:
  const Derived& self() const { return static_cast<const Derived&>(*this); }
  template <class S>
  static auto& cast(SystemData<S>& data) {
    return static_cast<typename Derived::template Data<S>&>(data);
  }
};

/// Names and units of the ndx components of a tangent vector. Rotations take the names of their
/// quaternion's first three components, with r in place of q, and the unit rad.
std::vector<Column> tangent_columns(const System& system);

/// Indices of the state's numbers that the equations of a system are about. Excludes the clock,
/// parameters and states at rest, which this system lacks.
std::vector<int> own_states(const System& system);
/// Tangent coordinates of all other numbers: the clock, parameters, their velocities and states at
/// rest.
std::vector<int> other_coordinates(const System& system);

}  // namespace conddp
