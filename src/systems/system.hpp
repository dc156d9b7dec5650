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

/// The scalars in which every system, residual and knot model can be evaluated.
#define CONDDP_FOR_EACH_SCALAR(X) X(double) X(Lane) X(Dual<Lane>)

/// second_order: x = (q, v), the system gives the acceleration a(q, v, u).
/// first_order: the system gives the tangent velocity ẋ(x, u).
/// discrete: the system gives the next state x⁺(x, u) of a flat state space.
/// impulse: x = (q, v), no time passes, and the system gives the velocity v⁺(q, v) after it.
enum class SystemKind { second_order, first_order, discrete, impulse };

/// What a system writes when it is evaluated in scalar S. Matrices by columns, all with
/// `rows` rows: nv for a second-order system and an impulse, ndx for the others.
template <class S>
struct SystemData {
  virtual ~SystemData() = default;
  AlignedVector<S> f;   ///< acceleration, tangent velocity, next state or next velocity
  AlignedVector<S> fx;  ///< rows x ndx, with respect to a tangent vector at x
  AlignedVector<S> fu;  ///< rows x nu
  /// Memory of the later stages of an implicit step (CollocationSystem); null of other systems.
  std::unique_ptr<SystemData<S>> later;
};

class MultibodySystem;
class SteppingSystem;
class CollocationSystem;

/// A named column of a state or control, with its unit.
struct Column {
  std::string name;
  std::string unit;
  /// Of a clock or a parameter: what is said of all columns is not said of it.
  bool by_name_only = false;
};

/// A dynamical system with controls: immutable, shared by all knots; what changes lives in
/// SystemData. Derive through SystemBase.
class System {
 public:
  virtual ~System() = default;

  SystemKind kind() const { return kind_; }
  const StateManifold& manifold() const { return manifold_; }
  int nx() const { return manifold_.nx(); }
  int ndx() const { return manifold_.ndx(); }
  int nu() const { return nu_; }
  /// How many of the controls drive the system, the first ones; others are unknowns of a step.
  virtual int actuators() const { return nu_; }
  /// Numbers in q and in v of a second-order system's state (q, v).
  int nq() const { return nx() - nv(); }
  int nv() const { return ndx() / 2; }
  int rows() const {
    return kind_ == SystemKind::second_order || kind_ == SystemKind::impulse ? nv() : ndx();
  }
  const std::vector<Column>& state_columns() const { return state_columns_; }
  const std::vector<Column>& control_columns() const { return control_columns_; }
  /// Whether the system has this number of the state. Others are states of other phases, at rest
  /// here: they stay as they are, and nothing depends on them.
  bool has_state(int column) const { return at_rest_.empty() || !at_rest_[column]; }
  /// Limits that the system's own description states (URDF effort limits); infinite if none.
  const std::vector<double>& control_lower() const { return control_lower_; }
  const std::vector<double>& control_upper() const { return control_upper_; }

  /// `create_data(S{})` makes a workspace. `evaluate` writes f. `differentiate` writes f, fx, fu.
  /// `update_kinematics` computes what residuals at a node without controls need.
#define CONDDP_DECLARE(S)                                                            \
  virtual std::unique_ptr<SystemData<S>> create_data(S) const = 0;                   \
  virtual void evaluate(const S* x, const S* u, SystemData<S>& data) const = 0;      \
  virtual void differentiate(const S* x, const S* u, SystemData<S>& data) const = 0; \
  virtual void update_kinematics(const S* x, SystemData<S>& data) const = 0;
  CONDDP_FOR_EACH_SCALAR(CONDDP_DECLARE)
#undef CONDDP_DECLARE
  /// How many rows of the contacts that it holds are independent in a state of nx numbers; where
  /// that cannot be computed there, all rows count as independent.
  virtual ContactRank contact_rank(const double* /*x*/) const { return {}; }

  /// Where its equations read tables at a knot.
  virtual std::vector<TableReading> table_readings(const double* /*x*/, const double* /*u*/) const {
    return {};
  }

  /// The compiled functions behind it that have reported failure since they were loaded, by name.
  virtual std::vector<std::string> failed_functions() const { return {}; }
  /// Whether second derivatives rest on what such a function claims them to be.
  virtual bool has_claimed_hessian() const { return false; }

  /// The system itself as what it is; null where it is something else.
  virtual const MultibodySystem* as_multibody() const { return nullptr; }
  virtual const SteppingSystem* as_stepping() const { return nullptr; }
  virtual const CollocationSystem* as_collocation() const { return nullptr; }
  /// The robot that the system is, or whose steps it makes; null where there is none.
  virtual const MultibodySystem* robot_inside() const { return as_multibody(); }

  /// Second derivatives on two of the system's workspaces, which have to outlive them. Null of a
  /// system that has none but those of `differentiate` in dual numbers.
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
  std::vector<bool> at_rest_;  ///< by column of the state; empty: none is
  std::vector<double> control_lower_;
  std::vector<double> control_upper_;
};

/// Implements System's methods for every scalar by templates of `Derived`: a member template
/// `Data<S>` (derived from SystemData<S>, constructible from const Derived&) and
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
