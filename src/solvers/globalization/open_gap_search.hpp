#pragma once

#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/line_search.hpp"

namespace conddp {

/// Search of a step while gaps are open, on the merit φ = J + ν θ with θ = Σ‖gap‖₁. Rows that the
/// stages enforce have gaps, too: θ then includes Σ‖c‖₁. The weight ν is just large enough that the
/// closed gaps pay for the cost of the model's step (Byrd, Nocedal, Waltz 2008; Nocedal, Wright,
/// equation 18.36). It therefore grows no further than the model's cost, whatever the multipliers
/// of a policy with an unsettled active set.
///
/// For each step length 1, ½, ¼, ... the better of up to two trials counts:
/// - The rollout of the policy contracts all gaps by 1 − α (Mastalli et al. 2020). It is the better
///   trial near an optimum, and follows curved dynamics as they are. Far from an optimum, it closes
///   gaps at any price. Gains that satisfy rows by the last few controls amplify its errors.
/// - The step of the linear model, x ⊕ α δx and u + α δu, at all knots at once is multiple shooting
///   (Bock, Plitt 1984). The error of a knot does not propagate to later knots. The step counts if
///   θ grows to at most 1.5 times its previous size: gaps opened for a lower cost have to be closed
///   at a far higher one.
class OpenGapSearch {
 public:
  /// `rows`: the stages enforce the equality constraints of the problem.
  OpenGapSearch(const ShootingProblem& problem, const ControlBounds& bounds, bool clamp_controls,
                bool rows = false);

  /// θ of gaps (ndx x N) and constraint values (all rows of the problem).
  double gap_norm(const Eigen::MatrixXd& gap, const Eigen::VectorXd& values) const;
  /// Removes the augmentation from the slope and the curvature of a step that satisfies the linear
  /// rows: along it the rows go from c to 0, and νᵀc and ½ ρ c² go with them.
  void leave_out(const Augmentation& augmentation, const Eigen::VectorXd& multipliers,
                 const Eigen::VectorXd& values, double& slope, double& curvature) const;
  /// Weight ν for a step with curvature dᵀHd, which is stored.
  double weigh(const MeritModel& merit, double curvature);

  /// Searches after weigh(), with its weight in `merit`. `first_step` is the longest step tried. On
  /// acceptance, `trajectory` becomes the new iterate; otherwise it is unchanged. Changes that
  /// rounding hides are treated as in LineSearch.
  LineSearchResult run(Evaluator& evaluator, const MeritModel& merit,
                       const Linearization& linearization, const Direction& direction,
                       const Augmentation* augmentation, double first_step, Trajectory& trajectory);

 private:
  /// A search under way.
  struct Search {
    Evaluator& evaluator;
    const MeritModel& merit;
    const Linearization& linearization;
    const Direction& direction;
    const Augmentation* augmentation;
    const Trajectory& from;
  };
  void try_rollout(const Search& search, double step, LineSearchResult& result);
  void try_linear(const Search& search, double step);
  template <class Function>
  void for_each_row(const Eigen::VectorXd& values, Function&& function) const;
  /// Evaluates a trial and keeps it if it is the best of its step length.
  bool consider(const Search& search, Trajectory& trial, double most_gaps);
  bool consider(const MeritModel& merit, double cost, double gap_norm, Trajectory& trial);

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  bool clamp_controls_, rows_;
  double curvature_ = 0;      ///< of the last weighed step
  double best_decrease_ = 0;  ///< of the merit, by the trials of the current step length
  std::optional<double> best_rollout_cost_;  ///< empty if the best trial is not a rollout
  Trajectory best_, trial_;
  SingleRollout rollout_;
  Evaluation evaluation_;
};

}  // namespace conddp
