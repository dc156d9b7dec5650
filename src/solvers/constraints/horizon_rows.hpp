#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/linalg/low_rank_update.hpp"
#include "solvers/riccati/backward_sweep.hpp"

namespace conddp {

/// The rows of a horizon QP: constraints, costs of the same form (barriers, and constraints
/// softened by a squared distance), and, during a descent, control bounds.
///
/// A step z moves the values g of a row to g + C z. With s = C z + ν/ρ, the row adds
/// ½ ρ dist²(g + s, K) to the QP. The derivative ρ P(s) with P(s) = g + s − Π_K(g + s) is piecewise
/// linear for bounds, and smooth between kinks for cones; soft constraints limit ρ ‖P‖. Each row
/// has an affine model a + S s of P, which is in the gradient and Hessian of its node. Alternating
/// sweeps and revisions of these models are Newton's method on the convex QP, semismooth because of
/// its kinks.
///
/// Two kinds of solves use the rows:
/// - Minimizations of an augmented Lagrangian hold ρ and ν, which the linearization contains
///   (start(), revise()). The models of cones follow each step.
/// - Newton's method takes ρ far above all curvatures, and ν ← ρ P after sweeps (choose() to
///   correct()). Cones are active with their surface (one row, with the curvature of its
///   multiplier) or their tip (all rows), both linearized at the iterate.
class HorizonRows {
 public:
  HorizonRows(const ShootingProblem& problem, const ControlBounds& bounds);

  /// True without constraints and costs.
  bool empty() const { return empty_; }
  /// Forgets the result of settle(), and reads the problem's bounds, which may have changed since
  /// the last solve.
  void reset();
  /// Exchanges the memory of Hessians with another problem's rows, before both start again.
  void exchange_memory(HorizonRows& other);

  /// Takes an iterate's linearization, which was made with this augmentation. `augmentation` is
  /// null if all constraints of the problem are costs.
  void start(const Linearization& linearization, const Augmentation* augmentation);
  /// Starts again from the same iterate, after restore().
  void restart();
  /// Models the rows, once, around the position that settle() stored. To be called after start().
  void expect(Linearization& linearization);
  /// Models the rows around the step z of each node, if the present model is inaccurate there.
  /// Nothing changes up to the error `allowed`, in Σ ρ |error of P|². Returns the number of changed
  /// constraints. `last` ← the last node with a change, if any.
  int revise(const std::vector<Eigen::VectorXd>& z, double allowed, Linearization& linearization,
             std::optional<int>& last);
  /// Keeps the position of the rows for the next iterate, after a revise() without changes. The
  /// next iterate deviates little from the linear model, relative to its step. Relative to |P| =
  /// |ν|/ρ the deviation may be large, and the iterate then says less about the future active rows.
  void settle();
  /// Restores the linearization's own gradients and Hessians. True if they had changed.
  bool restore(Linearization& linearization);

  /// Begins a descent: saves the linearization's own gradients and Hessians, and adds control
  /// bounds as rows. Their ρ are multiples of the stages' curvature in a sweep, their ν the entries
  /// of the gradient at bounds.
  void begin_descent(const Trajectory& trajectory, const Eigen::VectorXd& gradient,
                     const BackwardSweep& sweep, const Linearization& linearization);
  /// Removes the control bounds, and holds controls where they pushed.
  void end_descent(ActiveSet& active_set, Linearization& linearization);
  /// Prepares slope_beyond_model for d = to − z, where the model was made around z.
  void set_path(const std::vector<Eigen::VectorXd>& z, const std::vector<Eigen::VectorXd>& to,
                const Linearization& linearization);
  /// Derivative of the rows' terms along d at z + α d, minus that of the model.
  double slope_beyond_model(double alpha);

  /// Chooses the active constraint rows of an iterate: those with value plus multiplier/penalty
  /// outside their set, equalities, and the smaller row of each complementary pair. Multipliers of
  /// inactive rows become zero, those of surfaces normal to them, and those of soft constraints
  /// beyond their limit the limit.
  void choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
              Eigen::VectorXd& multipliers);
  /// Adds the chosen rows with this ρ to a linearization without constraints. Returns the largest
  /// residual of an active row.
  double impose(const Eigen::VectorXd& multipliers, double penalty, Linearization& linearization);
  /// Releases rows whose multiplier after the step would push the wrong way, activates rows that
  /// the step would violate, and limits multipliers. Returns the number of changed constraints.
  int revise_active(const std::vector<Eigen::VectorXd>& z, Linearization& linearization);
  /// ν ← ρ P after the step, for active rows. Returns their largest residual.
  double correct(const std::vector<Eigen::VectorXd>& z, Linearization& linearization);
  /// Multipliers ν of all constraint rows.
  void write_multipliers(Eigen::VectorXd& multipliers) const;
  /// Number of active constraint rows; a surface counts once.
  int active_rows() const;

 private:
  enum class Kind { constraint, cost, control };
  enum class ConeSide { inside, surface, tip, outside };
  /// Rows of one term.
  struct Term {
    int node, row, count;
    const double* lower;  ///< null for a cone or pairs
    const double* upper;
    bool cone;
    Kind kind;
    int weight = 0;                   ///< of a cost: its index among the node's parameters
    const double* factors = nullptr;  ///< of a cost: one per row, null if all are 1
    ConeSide side = ConeSide::inside;
  };
  /// Consecutive rows, across terms and nodes: thousands of terms have one row each.
  struct Run {
    int row, count;
    bool cost;
  };
  struct Node {
    std::vector<int> terms;  ///< indices into terms_
    bool cones = false;      ///< some are cones
    bool off = false;        ///< the model of a term may be inaccurate
    bool changed = false;
    Eigen::VectorXd gradient;  ///< the node's own, once changed
    Eigen::MatrixXd hessian;
  };
  void add_costs();
  void add_cost(const Term& cost);
  void reserve();
  void find_runs();
  void read_bounds();
  void read_weights();
  void measure_bounds();
  void measure_limits() { limit_ = own_limit_.cwiseQuotient(penalty_); }
  template <class F>
  void for_each_run(F f) const;
  template <class S>
  S outside(int row, const S& s) const;
  template <class S>
  void model_row(int row, const S& s, bool cost, S& offset, S& slope) const;
  double model(int row, double s) const { return offset_[row] + slope_[row] * s; }
  auto jacobian(const Term& c, const KnotLinearization& knot) const {
    return knot.C.middleRows(c.row - problem_.constraint_offset(c.node), c.count);
  }
  void shift(const std::vector<Eigen::VectorXd>& z, const Linearization& linearization,
             Eigen::VectorXd& values) const;
  void find_error();
  double find_bounds_error(const Run& run);
  template <class S>
  double find_rows_error(int row, const S& found);
  double find_cone_error(int term);
  int revise(Linearization& linearization, std::optional<int>& last);
  bool revise_bounds(const Term& c, KnotLinearization& knot);
  bool revise_cone(int term, KnotLinearization& knot);
  void outside_cone_at(const Term& c, const double* s, double* p, double* derivative);
  void set_row(const Term& c, int row, double offset, double slope, double base,
               KnotLinearization& knot);
  void set_cone(int term, KnotLinearization& knot);
  void keep(const KnotLinearization& knot, Node& node);
  void choose_bounds(const Term& c, const double* penalty, double* multipliers);
  void choose_cone(Term& c, double penalty, double* multipliers);
  void impose_bounds(const Term& c, KnotLinearization& knot);
  bool revise_active_bounds(const Term& c, KnotLinearization& knot);
  bool revise_active_cone(int term, KnotLinearization& knot);
  ConeSide revised_side(int term);
  ConeSide touched_side(const Term& c) const;
  double distance(const Term& c, const double* values) const;
  void model_cone(int term);
  bool find_corrections(int term);
  void find_normal(const Term& c);

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  std::vector<Term> terms_;  ///< constraints in the problem's order, costs, controls by knots
  std::vector<Node> nodes_;
  std::vector<Run> runs_;       ///< rows with bounds, but controls
  std::vector<Run> augmented_;  ///< constraint rows
  std::vector<int> cones_;      ///< into terms_
  std::vector<int> term_;       ///< index into terms_, per row
  int controls_ = 0;            ///< first row of the controls
  bool empty_ = true;
  bool descends_ = false;  ///< control bounds are rows
  // One number per row: bounds, and the limit of the multiplier; the bounds relative to g, and the
  // limit of |P|; g and ρ.
  Eigen::VectorXd own_lower_, own_upper_, own_limit_, lower_, upper_, limit_, value_, penalty_;
  // s of the iterate (base_) and of the present step (shifted_), P there (found_), a and, for rows
  // with bounds, S.
  Eigen::VectorXd base_, shifted_, found_, offset_, slope_;
  Eigen::VectorXd inside_, multiplier_;      ///< Π(g + s) and ρ P(s) of a settled step
  bool settled_ = false;                     ///< the two are known
  Eigen::VectorXd along_;                    ///< C d of a path
  std::vector<Eigen::MatrixXd> cone_slope_;  ///< S, one per term, empty unless a cone
  std::vector<char> off_;                    ///< per term with bounds: inaccurate model of P
  LowRankUpdate update_;                     ///< for the Hessian of one node
  Eigen::MatrixXd new_slope_;                ///< of one cone, as the next three
  Eigen::VectorXd new_offset_, new_base_, scratch_, point_;
  double allowed_ = 0;  ///< allowed error of the model of P
  double error_ = 0;
};

}  // namespace conddp
