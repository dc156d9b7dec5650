#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ocp/step/step.hpp"
#include "ocp/terms/activation.hpp"
#include "ocp/terms/constraint.hpp"

namespace conddp {

/// A cost w·a(r(x, u)): a rate, multiplied by the knot's cost scale (dt on running knots).
struct CostTerm {
  std::string name;
  std::shared_ptr<const Residual> residual;
  Activation activation;
  int parameters = 0;  ///< start of the residual's parameters among the knot's parameters
  int weight = 0;      ///< index of the weight among the knot's parameters
  std::optional<FreeDuration> grows_with = {};  ///< free duration that scales the cost
  /// True if the cost is the mean over the stages of the integrator (KnotModel::quadrature), each
  /// with its own parameters, one after the other. Otherwise the cost is evaluated at the knot's
  /// state.
  bool integrated = false;
  /// For a barrier: index of its first row among the constraint rows, and of its first derivative
  /// in constraint_pattern().
  int row = 0, jacobian = 0;

  /// True if the residual's rows are also constraint rows. Never for integrated costs, whose rows
  /// at the node are meaningless.
  bool is_barrier() const {
    return activation.kind == ActivationKind::quadratic_barrier && !integrated;
  }
};

/// A stage of a step, for integrated costs.
struct QuadratureStage {
  double time;    ///< fraction of the step
  double weight;  ///< weights of all stages sum to 1
};

/// A knot's data in scalar S: views into the caller's storage.
template <class S>
struct KnotInput {
  const S* x;
  const S* u;  ///< null at a node without control
  const S*
      parameters;  ///< references and weights of the costs, references and bounds of constraints
  S dt;
  S cost_scale;
  /// Penalty, shift and multiplier of each constraint row (Augmentation); null without
  /// augmentation.
  const S* penalty = nullptr;
  const S* shift = nullptr;
  const S* multiplier = nullptr;
};

/// Units of a model's inputs and outputs: x and u count multiples of these, one entry per number of
/// the state and of the control.
struct VariableUnits {
  std::vector<double> state, control;
};

/// Evaluation point of a cost: the knot itself, or one of its stages.
template <class S>
struct CostPoint {
  const KnotInput<S>& in;
  SystemData<S>& system;
  int stage = 0;  ///< selects the parameters
};

template <class S>
class KnotWorkspace;
template <class S>
struct CostSlopes;

/// The structure that knots share: a step, costs, constraints and control bounds. Immutable once a
/// problem holds it. Knots differ only in KnotInput. Their parameters begin with those of the step.
/// z = (tangent at x, u) has nz = ndx + nu entries.
class KnotModel {
 public:
  explicit KnotModel(Step step);
  KnotModel(std::shared_ptr<const System> system, Integrator integrator)
      : KnotModel(Step(std::move(system), integrator)) {}

  /// Adds a cost whose residual depends only on columns of z. Returns the start of its parameters
  /// (reference, then weight). An integrated cost needs a quadrature.
  int add_cost(std::string name, std::shared_ptr<const Residual> residual, Activation activation,
               const std::optional<FreeDuration>& grows_with = {}, bool integrated = false);
  /// Stages for integrated costs: those of an integrator of second order or higher, else empty.
  /// Stages of weight 0 are ignored.
  const std::vector<QuadratureStage>& quadrature() const { return quadrature_; }
  /// Adds a constraint; returns the start of its parameters (ConstraintTerm).
  int add_constraint(ConstraintTerm term);
  /// Elementwise bounds on the control; infinite if unbounded.
  void set_control_bounds(std::vector<double> lower, std::vector<double> upper);
  /// Makes evaluate and differentiate use states, controls and derivatives in other units. The
  /// caller converts control bounds and all other state data. Needs a flat state space and dynamics
  /// without semi-implicit structure.
  void set_units(VariableUnits units);
  bool has_units() const { return !units_.state.empty(); }
  const VariableUnits& units() const { return units_; }
  /// Sets the factors on the rows of a constraint (ConstraintTerm::row_factors).
  void set_row_factors(std::size_t constraint, std::vector<double> factors) {
    constraints_[constraint].row_factors = std::move(factors);
  }
  /// Factor on the cost of a soft constraint at a state, from the given cost scale.
  template <class S>
  S soft_scale(const ConstraintTerm& term, const S& cost_scale, const S* x) const {
    return term.by_duration ? cost_scale : grown(cost_scale, term.grows_with, x);
  }
  /// Factor on the rows of a constraint at a state.
  template <class S>
  S row_share(const ConstraintTerm& term, const S* x) const {
    return term.by_duration ? step_.share(*term.grows_with, x) : S(1.0);
  }
  const Step& step() const { return step_; }
  const System& system() const { return step_.system(); }
  const std::shared_ptr<const System>& shared_system() const { return step_.shared_system(); }
  const StateManifold& manifold() const { return step_.manifold(); }
  Integrator integrator() const { return step_.integrator(); }
  const std::vector<CostTerm>& costs() const { return costs_; }
  const std::vector<ConstraintTerm>& constraints() const { return constraints_; }
  /// Number of rows of all constraints and barriers of a knot. Barriers are included so that a cost
  /// that becomes active along a step has a value and a derivative on both sides.
  int constraint_rows() const { return constraint_rows_; }
  /// Entries (row, column) of ∂g/∂z that may be nonzero, in the order of a workspace.
  const std::vector<std::pair<int, int>>& constraint_pattern() const { return constraint_pattern_; }
  const std::vector<double>& control_lower() const { return lower_; }
  const std::vector<double>& control_upper() const { return upper_; }
  bool has_control_bounds() const;

  int nx() const { return step_.nx(); }
  int ndx() const { return step_.ndx(); }
  int nu() const { return step_.nu(); }
  int nz() const { return step_.nz(); }
  int parameter_count() const { return parameter_count_; }
  bool semi_implicit() const { return step_.semi_implicit(); }
  /// Rows of F: nv if semi_implicit(), else ndx, 0 at a terminal node.
  int jacobian_rows() const { return step_.jacobian_rows(); }
  /// Entries (row, column), row ≥ column, of the Gauss-Newton Hessians of costs and constraints
  /// that may be nonzero. Entries after the first lasting_entries() are filled only by barriers and
  /// constraints, whose curvature vanishes inside their bounds.
  const std::vector<std::pair<int, int>>& hessian_pattern() const { return pattern_; }
  int lasting_entries() const { return lasting_entries_; }

  /// Input of a residual whose parameters start at `parameters`, with the system's data at the
  /// beginning.
  template <class S>
  ResidualInput<S> residual_input(int parameters, const KnotInput<S>& in,
                                  SystemData<S>& data) const {
    return {in.x, step_.first_control(in.x, in.u), in.parameters + parameters, data,
            step_.last_control(in.u)};
  }

  /// Writes the next state, cost and constraint values to the workspace.
  template <class S>
  void evaluate(const KnotInput<S>& in, KnotWorkspace<S>& work) const;
  /// Writes the next state, cost and constraint values, the Jacobians of dynamics and constraints,
  /// and the gradient of cost and augmentation. With `hessian`, also writes the Gauss-Newton
  /// Hessian in the order of hessian_pattern().
  template <class S>
  void differentiate(const KnotInput<S>& in, KnotWorkspace<S>& work, bool hessian) const;

 private:
  template <class S>
  friend class KnotWorkspace;
  template <class S>
  friend class StageCosts;
  friend class KnotSecondDerivatives;

  /// Factor on a cost's activation.
  template <class S>
  S scale_of(const CostTerm& term, const KnotInput<S>& in) const {
    return grown(in.cost_scale, term.grows_with, in.x) * in.parameters[term.weight];
  }
  template <class S>
  S grown(const S& scale, const std::optional<FreeDuration>& duration, const S* x) const {
    return duration ? scale * step_.share(*duration, x) : scale;
  }
  /// Adds the derivative of a cost with respect to the duration that scales it.
  template <class S>
  void add_growth(const std::optional<FreeDuration>& duration, const S& cost, const S* x,
                  KnotWorkspace<S>& work) const {
    if (duration)
      work.gradient[system().ndx() + duration->choice] +=
          cost / x[system().nx() + duration->choice];
  }
  /// Evaluates the system's data that terms read.
  template <class S>
  void begin(const KnotInput<S>& in, KnotWorkspace<S>& work, bool derivatives) const;
  template <class S>
  void evaluate_costs(const KnotInput<S>& in, KnotWorkspace<S>& work) const;
  template <class S>
  void evaluate_cost(std::size_t cost, const CostPoint<S>& at, KnotWorkspace<S>& work) const;
  template <class S>
  void differentiate_costs(const KnotInput<S>& in, KnotWorkspace<S>& work, bool hessian) const;
  template <class S>
  void differentiate_cost(std::size_t cost, const CostPoint<S>& at, KnotWorkspace<S>& work,
                          bool hessian) const;
  template <class S>
  bool find_slopes(std::size_t cost, const CostPoint<S>& at, KnotWorkspace<S>& work, bool hessian,
                   CostSlopes<S>& slopes) const;
  /// Input of a cost's residual at a point.
  template <class S>
  ResidualInput<S> input_of(const CostTerm& term, const CostPoint<S>& at) const;
  template <class S>
  const int* add_cost(const std::vector<RowBlock>& blocks, const CostSlopes<S>& slopes, bool dense,
                      bool hessian, const int* pair, KnotWorkspace<S>& work) const;
  template <class S>
  void add_rank_one(const S& factor, const int* pair, KnotWorkspace<S>& work) const;

  // knot_integrated_costs.cpp
  struct Wanted {
    bool derivatives = false, hessian = false;
  };
  /// Takes the step and adds the costs that its stages integrate.
  template <class S>
  void take_step(const KnotInput<S>& in, KnotWorkspace<S>& work, const Wanted& wanted) const;

  // knot_units.cpp
  template <class S>
  KnotInput<S> in_own_units(const KnotInput<S>& given, KnotWorkspace<S>& work) const;
  template <class S>
  void give_values_in_units(KnotWorkspace<S>& work) const;
  template <class S>
  void give_derivatives_in_units(KnotWorkspace<S>& work, bool hessian) const;

  // knot_constraints.cpp
  template <class S>
  void evaluate_constraints(const KnotInput<S>& in, KnotWorkspace<S>& work) const;
  template <class S>
  void differentiate_constraints(const KnotInput<S>& in, KnotWorkspace<S>& work,
                                 bool hessian) const;
  template <class S>
  S limit_of(const ConstraintTerm& term, const KnotInput<S>& in) const;
  template <class S>
  void add_augmentation(std::size_t constraint, const S* jacobian, bool hessian,
                        KnotWorkspace<S>& work) const;

  /// Adds the penalty of an evaluated constraint to cost or augmentation, and writes its
  /// multipliers and, unless null, its curvature. Returns the added value, or nothing if the
  /// constraint adds none.
  template <class S>
  std::optional<S> add_penalty(const ConstraintTerm& term, const KnotInput<S>& in,
                               KnotWorkspace<S>& work, S* curvature) const;

  /// Appends rows whose derivative has these blocks; returns their start in the pattern.
  int add_rows(const std::vector<RowBlock>& blocks);

  /// Builds the Hessian pattern and its indices from costs and constraints.
  void index_hessian();
  void index_stage_columns();

  Step step_;
  VariableUnits units_;
  int parameter_count_ = 0;
  std::vector<CostTerm> costs_;
  std::vector<double> lower_, upper_;
  std::vector<std::pair<int, int>> pattern_;
  int lasting_entries_ = 0;
  /// For each cost, for each block, for each pair of its columns (a ≥ b): index in the pattern.
  std::vector<std::vector<int>> pattern_index_;
  /// Pattern of integrated costs at a stage; their pattern_index_ refers to it. Then the columns of
  /// z at the stage that they use, and the index of each column among these. Last, the indices of
  /// all pairs of columns of the knot's z, since stages may depend on all of them.
  std::vector<std::pair<int, int>> stage_pattern_;
  std::vector<int> stage_columns_, stage_places_, stage_index_;
  std::vector<QuadratureStage> quadrature_;
  std::vector<ConstraintTerm> constraints_;
  int constraint_rows_ = 0;
  std::vector<std::pair<int, int>> constraint_pattern_;
  std::vector<std::vector<int>> constraint_pattern_index_;  ///< for constraints
};

/// Output of a KnotModel in scalar S, and its scratch memory.
template <class S>
class KnotWorkspace {
 public:
  explicit KnotWorkspace(const KnotModel& model);

  /// nx: the next state.
  const AlignedVector<S>& next() const { return has_units_ ? given_next_ : step_.next(); }
  /// jacobian_rows x nz by columns: derivative of the next state (or velocity).
  const AlignedVector<S>& F() const { return has_units_ ? given_F_ : step_.F(); }
  /// If semi_implicit: ∂q⁺/∂q and ∂q⁺/∂(dt v⁺) for each curved segment, by rows.
  const AlignedVector<S>& state_blocks() const { return step_.integrator.state_blocks; }
  const AlignedVector<S>& step_blocks() const { return step_.integrator.step_blocks; }

  S cost;                                ///< sum of term_costs and l2-soft constraints
  AlignedVector<S> term_costs;           ///< scaled cost of each term
  AlignedVector<S> gradient;             ///< nz: of cost and augmentation
  AlignedVector<S> hessian;              ///< in the order of hessian_pattern()
  S augmentation;                        ///< penalties of the constraints
  AlignedVector<S> constraint;           ///< g and residuals of barriers, constraint_rows()
  AlignedVector<S> constraint_jacobian;  ///< in the order of constraint_pattern()
  /// True if `hessian` is zero after the lasting entries.
  bool rest_is_zero() const { return rest_is_zero_; }
  /// The last output of the system: at the knot's state and control, unless the integrator
  /// evaluates other points too.
  const SystemData<S>& system() const { return *step_.system; }

 private:
  friend class KnotModel;
  template <class T>
  friend class StageCosts;
  friend class KnotSecondDerivatives;

  bool rest_is_zero_ = true;
  bool has_units_;
  StepWorkspace<S> step_;
  AlignedVector<S> own_x_, own_u_, given_next_, given_F_;  ///< if the model has units
  AlignedVector<S> residual_, activation_gradient_, activation_diagonal_;
  AlignedVector<S> residual_jacobian_, weighted_jacobian_;
  AlignedVector<S> term_gradient_;
  /// For integrated costs: state, gradient and Hessian at a stage, derivative of the stage, and the
  /// product of Hessian and derivative.
  AlignedVector<S> stage_x_, stage_gradient_, stage_hessian_, stage_dense_, stage_Z_, stage_HZ_;
  AlignedVector<S> shifted_, weight_, curvature_;  ///< for one constraint: rows, rows, rows²
  AlignedVector<S> soft_;  ///< penalty and zeros for the rows of an l2-soft constraint
};

/// Lane part of a scalar: itself, or the value of a dual number.
inline Lane& lane_of(Lane& a) { return a; }
inline Lane& lane_of(Dual<Lane>& a) { return a.v; }

/// Inputs and workspace for one evaluation of a model, with one knot per lane.
template <class S>
struct KnotBatch {
  explicit KnotBatch(const KnotModel& model)
      : work(model),
        x(model.nx(), S(0.0)),
        u(model.nu(), S(0.0)),
        x_next(model.nx(), S(0.0)),
        parameters(model.parameter_count(), S(0.0)),
        tangent(model.ndx(), S(0.0)),
        lambda(model.ndx(), S(0.0)),
        pulled(model.nz(), S(0.0)),
        penalty(model.constraint_rows(), S(0.0)),
        shift(model.constraint_rows(), S(0.0)),
        multiplier(model.constraint_rows(), S(0.0)),
        dt(0.0),
        cost_scale(0.0) {}

  KnotInput<S> input() const { return at(x.data(), u.data()); }
  /// Input with a state and a control stored elsewhere.
  KnotInput<S> at(const S* state, const S* control) const {
    KnotInput<S> in{state, control, parameters.data(), dt, cost_scale};
    if (augmented) {
      in.penalty = penalty.data();
      in.shift = shift.data();
      in.multiplier = multiplier.data();
    }
    return in;
  }

  KnotWorkspace<S> work;
  AlignedVector<S> x, u, x_next, parameters;
  AlignedVector<S> tangent, lambda, pulled;     ///< scratch: ndx, ndx, nz
  AlignedVector<S> penalty, shift, multiplier;  ///< by constraint row, if augmented
  bool augmented = false;
  S dt, cost_scale;
};

}  // namespace conddp
