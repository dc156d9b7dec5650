#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/certificate/certificate_doubt.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// A problem of a file with the solvers that support it.
struct SolveTask {
  BuiltProblem built;
  std::vector<const SolverInfo*> candidates;
  double finishing =
      0;             ///< estimated time for files and certificate, s; the time limit includes it
  std::string grid;  ///< setting of a grid that differs from the file's
  /// Certificate of the solve, for its answer.
  std::shared_ptr<LastJudged> judged = std::make_shared<LastJudged>();

  const SolverSpec& asked() const { return built.facts().solver; }
};

/// Estimated time for the files of an answer, and for its certificate if requested, s; 0 without a
/// time limit. Both grow with the number of written values. The certificate also grows with the
/// time of derivatives, and counts as four times those of all knots.
double finishing_time(const BuiltProblem& built, bool certified);

/// Solves a task on successive grids, within the time limit of its file.
class GridSolve {
 public:
  struct Options {
    bool verify = true;  ///< false: without certificates, and without what `auto` does for them
    /// Start of the time limit.
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    /// Sets the callbacks of a solve's options. Its result is kept until that solve ends.
    std::function<std::shared_ptr<void>(SolverOptions&)> watch = nullptr;
  };

  GridSolve(SolveTask& task, Options options) : task_(task), with_(std::move(options)) {}

  /// The answer on the last grid, whose task replaces the member. Without `mesh`, and unless `auto`
  /// searches further, that is the file's own grid. Empty with errors if a finer grid cannot be
  /// built.
  std::optional<SolveResult> run(Diagnostics& out);

  const SolverInfo* solver() const { return solver_; }
  const std::vector<MeshRound>& rounds() const { return rounds_; }
  /// These settings and, if it differs from the file's, that of the answer's grid.
  std::vector<std::string> with_grid(std::vector<std::string> settings) const;

 private:
  SolveResult solve(const SolveTask& task, bool first_grid);
  SolveResult solve(const SolveTask& task, bool first_grid, SolverOptions options);
  Doubt doubt_of(const SolveTask& task, const SolverOptions& options) const;
  std::optional<SolveTask> on_other_grid(const SolveTask& task, const OtherGrid& grid,
                                         Diagnostics& out) const;
  std::optional<SolveResult> refine(SolveResult result, Diagnostics& out);
  SolveResult solve_around(SolveResult former);
  bool is_given_up(SolveStatus status) const;
  std::optional<SolveResult> solve_from_simulation(const SolveResult& failed);
  SolveResult climb(SolveTask& task, SolveResult failed, int halvings);

  SolveTask& task_;
  const Options with_;
  const SolverInfo* solver_ = nullptr;
  double seconds_ = 0;  ///< total of all solves
  std::vector<MeshRound> rounds_;
};

}  // namespace conddp
