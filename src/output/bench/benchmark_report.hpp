#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/comparison/benchmark.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// A constraint omitted for a solver that does not support it, and its violation by the answer.
struct LeftOut {
  std::string name;
  double violation;
};

/// One line of a benchmark: a problem, possibly perturbed, and a solver.
struct BenchmarkEntry {
  std::string problem;
  std::string file;
  std::string sha256;          ///< of the file
  std::string problem_sha256;  ///< see problem_identity.hpp
  std::string command;         ///< shell command that solves this entry alone
  int knots = 0;
  int states = 0;                     ///< dimension of the tangent space
  int controls = 0;                   ///< maximum over all knots
  std::optional<std::uint64_t> seed;  ///< of the instance; absent: the unperturbed problem
  std::vector<double> initial_state;  ///< of the instance, nx
  OrderedJson options;                ///< of the solver, without defaults
  std::vector<LeftOut> left_out;
  BenchmarkRun run;
  /// Lowest cost previously known for exactly this problem. Absent if unknown, or if the instance
  /// has another initial state or omits a constraint.
  std::optional<double> best_known;
  /// (cost − best) / max(|best|, kSmallestCostSize), where best is `best_known`, else the lowest
  /// cost for the same initial state and constraints over all solvers and guesses. NaN if this run
  /// did not solve the problem or a reference is missing. Negative: better than the best known
  /// cost.
  double cost_excess = std::numeric_limits<double>::quiet_NaN();
};

/// Request of a benchmark.
struct BenchmarkRequest {
  std::vector<std::string> solvers;
  int repeat = 0;
  int instances = 0;  ///< 0: unperturbed problems
  std::uint64_t seed = 0;
  /// Perturbation sizes of the instances, if requested: see perturb_initial_state and
  /// perturb_guess.
  std::optional<double> initial_state_size, guess_spread;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  OrderedJson tolerances = OrderedJson::object();  ///< from the command line
};

struct BenchmarkReport {
  BenchmarkRequest request;
  std::vector<BenchmarkEntry> entries;
};

/// Fills the cost excess of all comparable entries.
void compare_costs(BenchmarkReport& report);

/// True if the check confirms every answer that a solver reported as converged.
bool all_kept_word(const BenchmarkReport& report);

/// A cost excess at which answers are counted, and its name in tables and documents.
struct CostLevel {
  double excess;
  const char* name;
};
inline constexpr std::array kCostLevels = {CostLevel{1e-6, "1e-6"}, CostLevel{1e-3, "1e-3"},
                                           CostLevel{1e-1, "1e-1"}};

/// True if an answer improves on the best known one by more than the smallest of these levels.
inline bool beats_best_known(const BenchmarkEntry& entry) {
  return entry.best_known && entry.cost_excess < -kCostLevels.front().excess;
}

/// Results of a solver over the whole benchmark.
struct SolverSummary {
  std::string solver;
  int runs = 0;    ///< supported runs
  int solved = 0;  ///< of these, with all constraints
  /// Number of solved runs within each of kCostLevels of the best cost. A single answer is the best
  /// of its instance.
  std::array<int, kCostLevels.size()> within{};
  int left_out = 0;        ///< runs that omit a constraint
  int solved_without = 0;  ///< of these, solved without it
  int refused = 0;
  std::vector<std::pair<std::string, int>> failures;  ///< other statuses and counts, descending
};
std::vector<SolverSummary> summarize(const BenchmarkReport& report);

/// The effort of each solver for each instance, for profiles: infinite if it did not solve the
/// problem with all its constraints.
enum class Effort { time, iterations, sweeps };
std::vector<std::vector<double>> efforts(const BenchmarkReport& report, Effort effort);

/// schemas/bench.schema.json
OrderedJson benchmark_json(const BenchmarkReport& report);
/// One line per entry, with units in the header.
std::string benchmark_csv(const BenchmarkReport& report);
/// Tables for a terminal, or for a document if `markdown`.
std::string benchmark_text(const BenchmarkReport& report, bool markdown);

/// A gnuplot script that prints the performance profiles of time and iterations as SVG.
std::string profile_script(const BenchmarkReport& report);

}  // namespace conddp
