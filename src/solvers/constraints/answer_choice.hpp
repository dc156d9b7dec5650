#pragma once

#include <limits>

#include "solvers/common/options.hpp"
#include "solvers/constraints/projected_newton.hpp"

namespace conddp {

/// Chooses the answer among the iterates of a solve: the one whose norms are the least in multiples
/// of their tolerances, as a certificate judges them.
class AnswerChoice {
 public:
  explicit AnswerChoice(const SolverOptions::Tolerances& tolerances) : tolerances_(tolerances) {}

  /// True if an iterate becomes the answer: the first one, any that beats the answer so far, or a
  /// `preferred` one if it is a solution.
  bool take(const KktNorms& norms, bool preferred = false);
  bool has_answer() const { return taken_; }
  /// True if the answer so far is a solution: all its norms are within tolerance.
  bool is_solution() const { return taken_ && excess_ <= 1; }
  void forget() { *this = AnswerChoice(tolerances_); }

  /// Largest norm in multiples of its tolerance: at most 1 for a solution, infinite if a norm is
  /// not finite.
  static double excess(const KktNorms& norms, const SolverOptions::Tolerances& tolerances);

 private:
  SolverOptions::Tolerances tolerances_;
  bool taken_ = false;
  double excess_ = std::numeric_limits<double>::infinity();
};

}  // namespace conddp
