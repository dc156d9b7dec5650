#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/augmentation.hpp"
#include "solvers/linalg/low_rank_update.hpp"

namespace conddp {

/// An augmented Lagrangian in the linear model of the whole horizon, and costs that are terms of
/// the same kind: barriers and constraints that are soft by a square, with a ρ that stays and no
/// shift.
///
/// Terms ½ ρ dist²(g + shift, C) are quadratic as long as g + shift stays on one side of each
/// bound, and a linearisation knows the sides of the iterate alone: a full step that crosses others
/// meets penalties that the sweep has not seen, and line searches cut it off there. With g replaced
/// by g + ∂g z, the derivative of dist² is P(s) = s − Π_C(s) at s = g + ∂g z + shift. Around a step
/// z* it is taken as P(s*) + P'(s*)(s − s*), which enters the node's gradient and Hessian in place
/// of what the iterate had there. Sweeps and revisions alternate: Newton's method on the convex,
/// piecewise quadratic model, semismooth for its kinks.
class HorizonConstraints {
 public:
  explicit HorizonConstraints(const ShootingProblem& problem);

  /// Whether there are none.
  bool empty() const { return rows_.empty(); }
  /// Takes an iterate's linearisation, which was made with this augmentation; null where the
  /// problem has no constraints but those that are costs.
  void start(const Linearization& linearization, const Augmentation* augmentation);
  /// Begins again with the same iterate, after restore().
  void restart();
  /// Forgets what settle() kept, and reads the problem's bounds, which may have changed since the
  /// last solve.
  void reset();
  /// After start(): models the rows around where settle() found them last, the next time only.
  void expect(Linearization& linearization);
  /// Models the rows around the step z of each node instead where the present model is off there.
  /// Nothing changes where Σ ρ |error of P|² is allowed. Returns how many constraints changed.
  /// `last` ← the last node at which one did, if any.
  int revise(const std::vector<Eigen::VectorXd>& z, double allowed, Linearization& linearization,
             std::optional<int>& last);
  /// Σ ρ |error of P|² that the last revise() met.
  double model_error() const { return error_; }
  /// That the last revise() changed nothing: keeps where it found the rows for the next iterate. An
  /// iterate is off the linear model by what is small beside its step, but may be large beside
  /// |P| = |ν|/ρ, and then says less of the rows that will be active.
  void settle();
  /// Keeps the linearisation's own gradients and Hessians, which others are about to change too.
  void keep(const Linearization& linearization);
  /// Gets slope_beyond_model ready for d = to − z, where the model was made around z.
  void set_path(const std::vector<Eigen::VectorXd>& z, const std::vector<Eigen::VectorXd>& to,
                const Linearization& linearization);
  /// How much more the derivative of the penalties along d is at z + α d than the model has it.
  double slope_beyond_model(double alpha);
  /// Gives the linearisation back its own gradients and Hessians. Returns whether they had changed.
  bool restore(Linearization& linearization);
  /// Exchanges the memory of Hessians with another problem's, before both start again.
  void exchange_memory(HorizonConstraints& other);

 private:
  /// Rows of one term.
  struct Rows {
    int node, row, count;
    const double* lower;  ///< null of a cone
    const double* upper;
    double limit;                     ///< of multipliers
    bool cost;                        ///< whose penalty stays during a solve
    int weight = 0;                   ///< of a cost: its number among the node's parameters
    const double* factors = nullptr;  ///< of a cost: by row, null where they are 1
  };
  /// Rows one after the other, whatever their terms and nodes: thousands of terms have one row
  /// each.
  struct Run {
    int row, count;
    bool cost;
  };
  struct Node {
    std::vector<int> terms;  ///< into rows_
    bool cones = false;      ///< whether some are
    bool off = false;        ///< whether the model of one may be
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
  std::vector<Run> augmented_;     ///< rows that an augmentation has, with bounds or of cones
  std::vector<int> cones_, soft_;  ///< into rows_; of bounds, those whose multipliers are limited
  std::vector<int> term_;          ///< of rows_, per constraint row with bounds
  Eigen::VectorXd lower_, upper_, limit_;  ///< of those: bounds, and what |P| may be
  Eigen::VectorXd penalty_;                ///< ρ, one number per constraint row
  // A number per constraint row: s of the iterate, of the step that the model was made around, of
  // the step that is looked at; P at the second, its slope there where rows have bounds, and P at
  // the third.
  Eigen::VectorXd base_, around_, shifted_, outside_, slope_, found_;
  Eigen::VectorXd inside_, multiplier_;      ///< Π(s) and ρ P(s) of a step that settled
  bool settled_ = false;                     ///< these are known
  Eigen::VectorXd along_;                    ///< ∂g d of a path
  std::vector<Eigen::MatrixXd> cone_slope_;  ///< of each of rows_, empty unless a cone
  std::vector<char> off_;                    ///< of each of rows_ with bounds: the model of P is
  LowRankUpdate update_;                     ///< of the Hessian of one node
  Eigen::MatrixXd new_slope_;                ///< scratch
  Eigen::VectorXd new_outside_, weight_, difference_;
  double allowed_ = 0;  ///< what the model of P may be off
  double error_ = 0;
};

}  // namespace conddp
