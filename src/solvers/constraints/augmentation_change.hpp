#pragma once

#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/linalg/low_rank_update.hpp"

namespace conddp {

/// Changes a linearization with Gauss-Newton Hessians from one augmentation of its constraints to
/// another at the same iterate. The values g and derivatives ∂g are known, so that only rows with
/// an old or new multiplier matter: nothing is differentiated again.
class AugmentationChange {
 public:
  explicit AugmentationChange(const ShootingProblem& problem);

  /// `linearization` was made with `from`. Afterwards it equals the result of differentiation with
  /// `to`, up to rounding. True if it changed.
  bool apply(const Augmentation& from, const Augmentation& to, Linearization& linearization);

 private:
  /// Contribution of an augmentation to the cost, as a function of a constraint's values g.
  struct Term {
    double value = 0;
    Eigen::VectorXd gradient, curvature;  ///< by rows; for a cone, the curvature is n x n
  };
  void evaluate(const NodeConstraint& c, const Augmentation& augmentation,
                const Eigen::VectorXd& values, Term& term);
  bool change_gradient(const NodeConstraint& c, KnotLinearization& knot);
  void collect_curvature(const NodeConstraint& c, const KnotLinearization& knot);
  auto rows_of(const NodeConstraint& c, const KnotLinearization& knot) const {
    return knot.C.middleRows(c.row - problem_.constraint_offset(c.node), c.term->rows);
  }

  const ShootingProblem& problem_;
  Term before_, after_;
  Eigen::VectorXd shifted_;  ///< scratch
  LowRankUpdate update_;
};

}  // namespace conddp
