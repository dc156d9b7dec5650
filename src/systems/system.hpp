#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "spatial/aligned.hpp"
#include "spatial/dual.hpp"
#include "systems/contact_rank.hpp"
#include "systems/second_derivatives.hpp"
#include "systems/state_manifold.hpp"
#include "systems/table_reading.hpp"

namespace conddp {

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

}  // namespace conddp
