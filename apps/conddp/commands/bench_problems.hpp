#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problem_file/assemble/build_problem.hpp"

namespace conddp {

/// The word for all solvers or all constraints.
inline constexpr const char* kAll = "all";

/// A problem of a benchmark, with all its constraints and without some of the droppable ones.
class BenchProblem {
 public:
  explicit BenchProblem(BuiltProblem whole) : sha256(problem_sha256(whole)) {
    built_[{}] = std::move(whole);
  }

  /// The problem with all its constraints and without the perturbation of its file.
  const BuiltProblem& whole() const { return *built_.at({}); }

  /// The problem with as many constraints as the solver supports; only those named in `drop` (or
  /// "all") are dropped. All constraints are kept if dropping does not help.
  const BuiltProblem& fitting(const SolverInfo& solver, const std::vector<std::string>& drop);

  const std::string sha256;          ///< of the problem
  std::optional<double> best_known;  ///< lowest cost in the file next to the problem

 private:
  /// By the names of dropped constraints; empty if it cannot be built without them.
  std::map<std::vector<std::string>, std::optional<BuiltProblem>> built_;
};

/// Reads and builds problem files, those in folders, and examples by name, and looks up their best
/// known costs. Empty on errors. Errors of a problem are printed. `out` receives errors for
/// problems that these messages do not name, and for constraints to drop that no problem contains.
std::optional<std::deque<BenchProblem>> read_bench_problems(
    const std::vector<std::string>& inputs, const std::vector<std::string>& settings,
    const std::vector<std::string>& drop, Diagnostics& out);

}  // namespace conddp
