#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/linalg/low_rank_update.hpp"

namespace conddp {

/// An augmented Lagrangian in the linear model of the whole horizon. It includes costs of the same
/// form: barriers, and constraints softened by a squared distance, with constant ρ and zero shift.
///
/// Terms ½ ρ dist²(g + shift, C) are quadratic as long as g + shift stays on one side of each
/// bound. A linearization knows only the sides of the iterate: a full step that crosses others
/// meets penalties that the sweep has not seen, and line searches stop it there. With g replaced by
/// g + ∂g z, the derivative of dist² is P(s) = s − Π_C(s) at s = g + ∂g z + shift. Around a step
/// z*, it is approximated by P(s*) + P'(s*)(s − s*). This replaces the contribution of the iterate
/// in the node's gradient and Hessian. Alternating sweeps and revisions are Newton's method on the
/// convex, piecewise quadratic model, semismooth because of its kinks.
class HorizonConstraints {
 public:
  explicit HorizonConstraints(const ShootingProblem& problem);

  /// True if it contains no terms.
  bool empty() const { return rows_.empty(); }
  /// Takes an iterate's linearization, which was made with this augmentation. `augmentation` is
  /// null if all constraints of the problem are costs.
  void start(const Linearization& linearization, const Augmentation* augmentation);
  /// Starts again from the same iterate, after restore().
  void restart();
  /// Forgets the result of settle(), and reads the problem's bounds, which may have changed since
  /// the last solve.
  void reset();
  /// Models the rows, once, around the position that settle() stored. To be called after start().
  void expect(Linearization& linearization);
  /// Models the rows around the step z of each node, if the present model is inaccurate there.
  /// Nothing changes up to the error `allowed`, in Σ ρ |error of P|². Returns the number of changed
  /// constraints. `last` ← the last node with a change, if any.
  int revise(const std::vector<Eigen::VectorXd>& z, double allowed, Linearization& linearization,
             std::optional<int>& last);
  /// Σ ρ |error of P|² in the last revise().
  double model_error() const { return error_; }
  /// Keeps the position of the rows for the next iterate, after a revise() without changes. The
  /// next iterate deviates little from the linear model, relative to its step. Relative to |P| =
  /// |ν|/ρ the deviation may be large, and the iterate then says less about the future active rows.
  void settle();
  /// Saves the linearization's own gradients and Hessians before other code changes them, too.
  void keep(const Linearization& linearization);
  /// Prepares slope_beyond_model for d = to − z, where the model was made around z.
  void set_path(const std::vector<Eigen::VectorXd>& z, const std::vector<Eigen::VectorXd>& to,
                const Linearization& linearization);
  /// Derivative of the penalties along d at z + α d, minus that of the model.
  double slope_beyond_model(double alpha);
  /// Restores the linearization's own gradients and Hessians. True if they had changed.
  bool restore(Linearization& linearization);
  /// Exchanges the memory of Hessians with another problem's constraints, before both start again.
  void exchange_memory(HorizonConstraints& other);

 private:
  /// Rows of one term.
  struct Rows {
    int node, row, count;
    const double* lower;  ///< null for a cone
    const double* upper;
    double limit;                     ///< of the multipliers
    bool cost;                        ///< its penalty stays during a solve
    int weight = 0;                   ///< of a cost: its index among the node's parameters
    const double* factors = nullptr;  ///< of a cost: one per row, null if all are 1
  };
  /// Consecutive rows, across terms and nodes: thousands of terms have one row each.
  struct Run {
    int row, count;
    bool cost;
  };
  struct Node {
    std::vector<int> terms;  ///< indices into rows_
    bool cones = false;      ///< some are cones
    bool off = false;        ///< the model of a term may be inaccurate
    bool changed = false;
    Eigen::VectorXd gradient;  ///< the node's own, once changed
    Eigen::MatrixXd hessian;
  };
  void reserve();
  void add_soft_costs();
  void add_barriers(int node);
  void add_cost(const Rows& cost);
  void find_runs();
  void read_bounds();
  void read_limits();
  void read_weights();
  void read_augmentation(const Augmentation& augmentation);
  template <class S>
  S outside_rows(int row, const S& s) const;
  template <class S>
  S row_slopes(int row, const S& s, bool cost) const;
  static void outside_cone_at(const Rows& c, const double* s, double limit, double* p,
                              double* derivative);
  bool revise_bounds(const Rows& c, KnotLinearization& knot, Node& node);
  bool revise_cone(const Rows& c, int index, KnotLinearization& knot, Node& node);
  void keep(const KnotLinearization& knot, Node& node);
  void find_error();
  double find_bounds_error(const Run& run);
  template <class S>
  double find_rows_error(int row, const S& found);
  double find_cone_error(int term);
  int revise(Linearization& linearization, std::optional<int>& last);
  void shift(const std::vector<Eigen::VectorXd>& z, const Linearization& linearization,
             Eigen::VectorXd& values) const;

  const ShootingProblem& problem_;
  std::vector<Rows> rows_;
  std::vector<Node> nodes_;
  std::vector<Run> bounds_;        ///< rows with bounds
  std::vector<Run> augmented_;     ///< rows of an augmentation, with bounds or of cones
  std::vector<int> cones_, soft_;  ///< into rows_: cones, and bounds with limited multipliers
  std::vector<int> term_;          ///< index into rows_, per constraint row with bounds
  Eigen::VectorXd lower_, upper_, limit_;  ///< of those rows: bounds, and the limit of |P|
  Eigen::VectorXd penalty_;                ///< ρ, one number per constraint row
  // One number per constraint row: s of the iterate (base_), s of the step around which the model
  // was made (around_), and s of the present step (shifted_). P at around_ (outside_), its slope
  // there for rows with bounds (slope_), and P at shifted_ (found_).
  Eigen::VectorXd base_, around_, shifted_, outside_, slope_, found_;
  Eigen::VectorXd inside_, multiplier_;      ///< Π(s) and ρ P(s) of a settled step
  bool settled_ = false;                     ///< the two are known
  Eigen::VectorXd along_;                    ///< ∂g d of a path
  std::vector<Eigen::MatrixXd> cone_slope_;  ///< one per element of rows_, empty unless a cone
  std::vector<char> off_;                    ///< per bound term of rows_: inaccurate model of P
  LowRankUpdate update_;                     ///< for the Hessian of one node
  Eigen::MatrixXd new_slope_;                ///< scratch
  Eigen::VectorXd new_outside_, weight_, difference_;
  double allowed_ = 0;  ///< allowed error of the model of P
  double error_ = 0;
};

}  // namespace conddp
