#pragma once

#include <optional>
#include <vector>

#include "problem_file/spec/spec.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// A grid, and the answer on it.
struct MeshRound {
  int factor = 1;  ///< into how many the steps of the phases are cut
  int knots = 0;
  double error = 0;  ///< replay_error
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
  double cost = 0;
};

/// Grids one after the other, each finer than the one before, until the answer on one has the error
/// that the file asks for.
class MeshRefinement {
 public:
  /// Of a file with `mesh`.
  explicit MeshRefinement(const ProblemSpec& spec);

  /// Judges an answer on the present grid. The factor of the next one; nothing where this is the
  /// last: it is fine enough, the solve has failed, a finer one is beyond the limits, or the error
  /// has grown on two grids in a row.
  std::optional<int> next(const ShootingProblem& problem, const SolveResult& result);
  const std::vector<MeshRound>& rounds() const { return rounds_; }
  /// Whether the last grid is fine enough.
  bool reached() const;

 private:
  double growth() const;
  /// Whether the error of a round is no less than that of the one before.
  bool grew(std::size_t round) const;
  bool keeps_growing() const;

  MeshSpec mesh_;
  int factor_;
  std::vector<MeshRound> rounds_;
};

/// Halves the knots of the phases that take time, which last as long as before. False, with nothing
/// changed, where one would have fewer than `least`.
bool coarsen(ProblemSpec& spec, int least);

/// A trajectory of one grid on another one of the same phases: states between nodes along the
/// shortest way, controls held.
Trajectory on_grid(const ShootingProblem& from, const Trajectory& trajectory,
                   const ShootingProblem& to);

/// Reports what a grid that changes cannot go together with.
void check_mesh(const ProblemSpec& spec, const System& system, Diagnostics& out);

}  // namespace conddp
