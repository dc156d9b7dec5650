#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problem_file/build/build.hpp"

namespace conddp {

/// The word that stands for all solvers, and for all constraints.
inline constexpr const char* kAll = "all";

/// A problem of a benchmark, with all its constraints and without some of those that may be
/// dropped. It stays where it is: what is built refers to it.
class BenchProblem {
 public:
  explicit BenchProblem(ProblemSpec checked)
      : spec(std::move(checked)), perturbation(std::exchange(spec.perturbation, {})) {}
  BenchProblem(const BenchProblem&) = delete;
  BenchProblem& operator=(const BenchProblem&) = delete;

  /// Builds it without some constraints, once; null where there is an error.
  const BuiltProblem* build(const std::vector<std::string>& drop, Diagnostics& out);

  /// With as many constraints as the solver takes, of those whose names (or "all") may be dropped;
  /// with all where leaving out does not help. The whole problem has been built before.
  const BuiltProblem& fitting(const SolverInfo& solver, const std::vector<std::string>& drop);

  /// The SHA-256 of the problem, which has been built before.
  const std::string& sha256();

  ProblemSpec spec;  ///< without a perturbation
  /// That of the file, from which instances that are asked for differ in what is asked for.
  Perturbation perturbation;
  std::optional<double> best_known;  ///< the least cost that the file beside the problem knows

 private:
  std::map<std::vector<std::string>, std::optional<BuiltProblem>> built_;
  std::string sha256_;  ///< once it was asked for
};

/// Reads and builds problem files, those in folders, and examples by name, and looks up what is
/// known of their optima; nothing where something is wrong. What is wrong with a problem is
/// printed. A problem that these messages do not name, and a constraint to drop that none has, are
/// errors in `out`.
std::optional<std::deque<BenchProblem>> read_bench_problems(
    const std::vector<std::string>& inputs, const std::vector<std::string>& settings,
    const std::vector<std::string>& drop, Diagnostics& out);

}  // namespace conddp
