#pragma once

#include <optional>
#include <vector>

#include "problem_file/model/spec.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// A grid and its solution.
struct MeshRound {
  int factor = 1;  ///< subdivision of the steps of the phases
  int knots = 0;
  double error = 0;  ///< replay_error
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
  double cost = 0;
};

/// A sequence of grids, each finer than the one before, until a solution reaches the error
/// tolerance of the file.
class MeshRefinement {
 public:
  explicit MeshRefinement(const MeshSpec& mesh) : mesh_(mesh), factor_(mesh.factor) {}

  /// Judges the solution on the present grid. Returns the factor of the next grid, or nothing if
  /// this grid is the last. It is the last if it is fine enough, the solve has failed, or it has
  /// 10000 knots. It is also the last if the error has grown on two grids in a row.
  std::optional<int> next(const ShootingProblem& problem, const SolveResult& result);
  const std::vector<MeshRound>& rounds() const { return rounds_; }
  /// True if the last grid is fine enough.
  bool reached() const;

 private:
  double growth() const;
  /// True if the error of a round is at least that of the preceding round.
  bool grew(std::size_t round) const;
  bool keeps_growing() const;

  MeshSpec mesh_;
  int factor_;
  std::vector<MeshRound> rounds_;
};

/// Halves the number of knots of the phases that take time; durations stay. Returns false and
/// changes nothing if a phase would have fewer than `least` knots.
bool coarsen(ProblemSpec& spec, int least);

/// A trajectory of one grid on another grid of the same phases. States are interpolated along the
/// shortest path; controls are held.
Trajectory on_grid(const ShootingProblem& from, const Trajectory& trajectory,
                   const ShootingProblem& to);

/// Reports features that mesh refinement does not support.
void check_mesh(const ProblemSpec& spec, const System& system, Diagnostics& out);

}  // namespace conddp
