#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ocp/step/integrator.hpp"
#include "ocp/terms/constraint.hpp"
#include "ocp/terms/residual.hpp"

namespace conddp {

/// Number of the tail that grows by the time step times a residual of one row.
struct IntegralTerm {
  std::string name;
  std::shared_ptr<const Residual> residual;
  int parameters = 0;  ///< index of the residual's first parameter among those of the step
  int number = 0;      ///< index in the tail
  int jacobian = 0;    ///< index of its first derivative among those of all integrals
};

/// Arguments of a step in scalar S: views into the caller's storage.
template <class S>
struct StepInput {
  const S* x;
  const S* u;  ///< null at a node without control
  const S* parameters;
  S dt;  ///< as given; a free duration scales it
};

template <class S>
struct StepWorkspace;

/// A step x⁺ = f(x, u, dt): a system, its integrator, and a *tail* of numbers behind the system's
/// state. At the next node, a number of the tail is either what it was or a control of this knot.
/// The decorations below append to the tail or give its numbers a meaning. They compose in any
/// order, but for integrals, whose rates refer to columns: the tail has to be complete. Indices of
/// numbers count from the first of the tail. z = (tangent at x, u) has
/// nz = ndx + nu entries. Immutable once a model holds it.
class Step {
 public:
  Step(std::shared_ptr<const System> system, Integrator integrator);

  /// Appends numbers that stay as they are.
  Step& hold(int count);
  /// Appends numbers that become the controls first, first + 1, ... of the knot.
  Step& remember_controls(int first, int count);
  /// Makes controls linear in time: appends the actuators' values at the knot's beginning. The
  /// first controls of the knot are those at its end. Residuals see the former. Needs an integrator
  /// that follows controls. A node without dynamics has a control then, too.
  Step& make_controls_linear();
  /// Scales the time step with a held number. Needs a system that knows time.
  Step& scale_time(const FreeDuration& duration);
  /// Makes a held number an integral; returns the index of the residual's first parameter.
  int integrate(std::string name, std::shared_ptr<const Residual> residual, int number);

  /// Step of another system with the same course of controls, without further numbers.
  Step alike(std::shared_ptr<const System> system, Integrator integrator) const;
  /// The same with another integrator.
  Step with(Integrator integrator) const;
  /// A node with the same states, without dynamics.
  Step without_dynamics() const;

  const System& system() const { return *system_; }
  const std::shared_ptr<const System>& shared_system() const { return system_; }
  Integrator integrator() const { return integrator_; }
  const StateManifold& manifold() const { return manifold_; }
  int nx() const { return manifold_.nx(); }
  int ndx() const { return manifold_.ndx(); }
  int nu() const { return integrator_ == Integrator::none ? 0 : system_->nu(); }
  int nz() const { return ndx() + nu(); }
  /// Numbers behind the system's state.
  int tail() const { return static_cast<int>(sources_.size()); }
  /// Control that a number of the tail becomes; nothing if it stays.
  std::optional<int> source(int number) const {
    return sources_[number] < 0 ? std::nullopt : std::optional(sources_[number]);
  }
  /// Tangent columns of the numbers that stay.
  std::vector<int> held_columns() const;
  const std::vector<IntegralTerm>& integrals() const { return integrals_; }
  int parameter_count() const { return parameter_count_; }
  const std::optional<FreeDuration>& duration() const { return duration_; }
  /// Throws std::invalid_argument unless the tail holds the duration.
  void check_duration(const FreeDuration& duration) const;

  /// Rows of F: nv if semi_implicit(), else ndx, 0 without dynamics.
  int jacobian_rows() const;
  /// True if F has semi-implicit Euler's structure: the nv rows of the next velocity alone, from
  /// which the rows of the next configuration follow.
  bool semi_implicit() const { return is_structured(integrator_) && sources_.empty(); }
  /// True if the next state is linear in z, apart from curved parts of the configuration.
  bool is_linear() const;
  /// True if residuals see a control here.
  bool has_control() const { return integrator_ != Integrator::none || has_linear_controls(); }
  bool has_linear_controls() const { return linear_at_ >= 0; }
  /// Number of controls at the node that the state holds.
  int controls_in_state() const { return linear_at_ < 0 ? 0 : system_->actuators(); }

  /// Control at the beginning of the step, at which the system is evaluated.
  template <class S>
  const S* first_control(const S* x, const S* u) const {
    return linear_at_ < 0 ? u : x + system_->nx() + linear_at_;
  }
  Eigen::Map<const Eigen::VectorXd> first_control(const Eigen::VectorXd& x,
                                                  const Eigen::VectorXd& u) const {
    return {first_control(x.data(), u.data()), linear_at_ < 0 ? u.size() : system_->actuators()};
  }
  /// Control at the end of the step if it differs from the one at the beginning, else null.
  template <class S>
  const S* last_control(const S* u) const {
    return linear_at_ < 0 ? nullptr : u;
  }
  /// Column of z for an actuator's control at the beginning.
  int control_column(int actuator) const {
    return linear_at_ < 0 ? ndx() + actuator : system_->ndx() + linear_at_ + actuator;
  }
  /// Writes the controls that the tail takes into the next state.
  template <class S>
  void hand_on(const S* u, S* next) const {
    for (std::size_t i = 0; i < sources_.size(); ++i)
      if (sources_[i] >= 0) next[system_->nx() + i] = u[sources_[i]];
  }
  /// Time step at a state.
  template <class S>
  S time_step(const S& dt, const S* x) const {
    return duration_ ? dt * share(*duration_, x) : dt;
  }
  /// Duration at a state as a share of the written one.
  template <class S>
  S share(const FreeDuration& duration, const S* x) const {
    return x[system_->nx() + duration.choice] * S(1 / duration.written);
  }
  /// State of a stage with its tail, from the state at the beginning of the step.
  template <class S>
  void stage_state(const StageView<S>& stage, const S* begin, S* x) const;
  /// ∂(state, control at a stage)/∂z, row by column.
  template <class S>
  S stage_derivative(const StageView<S>& stage, int row, int column, const S& dt,
                     const StepWorkspace<S>& work) const;

  /// Evaluates the system at the beginning of the step, and the rates of integrals there.
  template <class S>
  void begin(const StepInput<S>& in, StepWorkspace<S>& work, bool derivatives) const;
  /// Writes the next state and, if asked for, F. Follows `begin`; the visitor sees the stages of
  /// explicit rules.
  template <class S>
  void take(const StepInput<S>& in, StepWorkspace<S>& work, bool derivatives,
            StageVisitor<S>* visitor = nullptr) const;

 private:
  void append(int first_source, int count, int stride);
  void index_columns();
  template <class S>
  void fill_jacobian(const S& dt, StepWorkspace<S>& work) const;
  template <class S>
  void fill_integrals(const S& dt, StepWorkspace<S>& work) const;
  template <class S>
  void fill_duration(const StepInput<S>& in, const S& dt, StepWorkspace<S>& work) const;

  std::shared_ptr<const System> system_;
  Integrator integrator_;
  StateManifold manifold_;
  std::vector<int> sources_;  ///< of the tail: a control, or −1 for the number itself
  int linear_at_ = -1;        ///< number at which linear controls begin; −1: constant controls
  std::vector<int> columns_;  ///< for each column of z the integrator's, −1 if there is none
  std::optional<FreeDuration> duration_;
  std::vector<IntegralTerm> integrals_;
  int parameter_count_ = 0;
};

/// Output of a step in scalar S, and its scratch memory.
template <class S>
struct StepWorkspace {
  explicit StepWorkspace(const Step& step);

  const AlignedVector<S>& next() const { return has_tail ? whole_next : integrator.next; }
  /// jacobian_rows x nz by columns: derivative of the next state (or velocity).
  const AlignedVector<S>& F() const { return has_tail ? whole_F : integrator.F; }

  bool has_tail;
  std::unique_ptr<SystemData<S>> system;
  IntegratorWorkspace<S> integrator;
  AlignedVector<S> whole_next, whole_F;  ///< with the tail, if there is one
  AlignedVector<S> rates, rate_jacobians;
};

}  // namespace conddp
