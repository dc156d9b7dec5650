#pragma once

#include <limits>

#include "solvers/common/options.hpp"
#include "solvers/constraints/projected_newton.hpp"

namespace conddp {

/// Which of the iterates that a solve comes to is its answer: the one whose norms are the least in
/// multiples of their tolerances, as a certificate judges them.
class AnswerChoice {
 public:
  explicit AnswerChoice(const SolverOptions::Tolerances& tolerances) : tolerances_(tolerances) {}

  /// Whether an iterate is the answer from now on: the first one, one that is better than the
  /// answer so far, and one that is `preferred` if it is a solution.
  bool take(const KktNorms& norms, bool preferred = false);
  bool has_answer() const { return taken_; }
  /// Whether the answer so far is a solution: all its norms are under tolerance.
  bool is_solution() const { return taken_ && excess_ <= 1; }
  void forget() { *this = AnswerChoice(tolerances_); }

  /// The largest norm in multiples of its tolerance, at most 1 of a solution; infinite where a norm
  /// is not finite.
  static double excess(const KktNorms& norms, const SolverOptions::Tolerances& tolerances);

 private:
  SolverOptions::Tolerances tolerances_;
  bool taken_ = false;
  double excess_ = std::numeric_limits<double>::infinity();
};

}  // namespace conddp
