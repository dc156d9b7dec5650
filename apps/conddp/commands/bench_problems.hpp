#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problem_file/build/build.hpp"

namespace conddp {

/// The word for all solvers or all constraints.
inline constexpr const char* kAll = "all";

/// A problem of a benchmark, with all its constraints and without some of the droppable ones. It
/// must not move: built problems refer to it.
class BenchProblem {
 public:
  explicit BenchProblem(ProblemSpec checked)
      : spec(std::move(checked)), perturbation(std::exchange(spec.perturbation, {})) {}
  BenchProblem(const BenchProblem&) = delete;
  BenchProblem& operator=(const BenchProblem&) = delete;

  /// Builds the problem without some constraints, once; null on errors.
  const BuiltProblem* build(const std::vector<std::string>& drop, Diagnostics& out);

  /// The problem with as many constraints as the solver supports; only those named in `drop` (or
  /// "all") are dropped. All constraints are kept if dropping does not help. The whole problem must
  /// have been built before.
  const BuiltProblem& fitting(const SolverInfo& solver, const std::vector<std::string>& drop);

  /// The SHA-256 of the problem, which must have been built before.
  const std::string& sha256();

  ProblemSpec spec;  ///< without a perturbation
  /// The file's perturbation; requested instances override the requested parts.
  Perturbation perturbation;
  std::optional<double> best_known;  ///< lowest cost in the file next to the problem

 private:
  std::map<std::vector<std::string>, std::optional<BuiltProblem>> built_;
  std::string sha256_;  ///< set by the first call
};

/// Reads and builds problem files, those in folders, and examples by name, and looks up their best
/// known costs. Empty on errors. Errors of a problem are printed. `out` receives errors for
/// problems that these messages do not name, and for constraints to drop that no problem contains.
std::optional<std::deque<BenchProblem>> read_bench_problems(
    const std::vector<std::string>& inputs, const std::vector<std::string>& settings,
    const std::vector<std::string>& drop, Diagnostics& out);

}  // namespace conddp
