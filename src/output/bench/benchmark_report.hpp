#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/comparison/benchmark.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// A constraint that was left out for a solver that refuses it, and how far the answer violates it.
struct LeftOut {
  std::string name;
  double violation;
};

/// One line of a benchmark: a problem, perhaps perturbed, and a solver.
struct BenchmarkEntry {
  std::string problem;
  std::string file;
  std::string sha256;          ///< of the file
  std::string problem_sha256;  ///< see problem_identity.hpp
  std::string command;         ///< that solves this alone, for a shell
  int knots = 0;
  int states = 0;                     ///< dimension of the tangent space
  int controls = 0;                   ///< largest of all knots
  std::optional<std::uint64_t> seed;  ///< of the instance; absent: the problem as it is
  std::vector<double> initial_state;  ///< of the instance, nx
  OrderedJson options;                ///< of the solver, those that differ from the defaults
  std::vector<LeftOut> left_out;
  BenchmarkRun run;
  /// The least cost known of just this problem, from before; absent: none is known, or the instance
  /// has another initial state or lacks a constraint.
  std::optional<double> best_known;
  /// (cost − best) / max(|best|, kSmallestCostSize), where best is `best_known`, else the least
  /// cost that was found for the same initial state with the same constraints, by all solvers and
  /// from all guesses; not-a-number where this one did not solve it, or there is nothing to compare
  /// with. Negative: better than what was known.
  double cost_excess = std::numeric_limits<double>::quiet_NaN();
};

/// How a benchmark was asked for.
struct BenchmarkRequest {
  std::vector<std::string> solvers;
  int repeat = 0;
  int instances = 0;  ///< 0: the problems as they are
  std::uint64_t seed = 0;
  /// How far instances lie from their problem, where that was asked for: see perturb_initial_state
  /// and perturb_guess.
  std::optional<double> initial_state_size, guess_spread;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  OrderedJson tolerances = OrderedJson::object();  ///< those of the command line
};

struct BenchmarkReport {
  BenchmarkRequest request;
  std::vector<BenchmarkEntry> entries;
};

/// Fills the cost excess of all entries that can be compared.
void compare_costs(BenchmarkReport& report);

/// Whether the check confirms every answer that a solver called converged.
bool all_kept_word(const BenchmarkReport& report);

/// A cost excess within which answers are counted, and what tables and documents call it.
struct CostLevel {
  double excess;
  const char* name;
};
inline constexpr std::array kCostLevels = {CostLevel{1e-6, "1e-6"}, CostLevel{1e-3, "1e-3"},
                                           CostLevel{1e-1, "1e-1"}};

/// Whether an answer is better than the best known one by more than the least of these levels.
inline bool beats_best_known(const BenchmarkEntry& entry) {
  return entry.best_known && entry.cost_excess < -kCostLevels.front().excess;
}

/// What a solver did over the whole set.
struct SolverSummary {
  std::string solver;
  int runs = 0;    ///< without refusals
  int solved = 0;  ///< of these, with all constraints
  /// Of those solved, how many end within each of kCostLevels of the best; what stands alone is the
  /// best of its instance.
  std::array<int, kCostLevels.size()> within{};
  int left_out = 0;        ///< runs without a constraint
  int solved_without = 0;  ///< of these, what is left of the problem
  int refused = 0;
  std::vector<std::pair<std::string, int>> failures;  ///< other ends and how often, most first
};
std::vector<SolverSummary> summarize(const BenchmarkReport& report);

/// The effort of each solver for each instance, for profiles: infinite where it did not
/// solve the problem with all its constraints.
enum class Effort { time, iterations, sweeps };
std::vector<std::vector<double>> efforts(const BenchmarkReport& report, Effort effort);

/// schemas/bench.schema.json
OrderedJson benchmark_json(const BenchmarkReport& report);
/// One line an entry, with units in the head.
std::string benchmark_csv(const BenchmarkReport& report);
/// Tables for a terminal; `markdown`: for a document.
std::string benchmark_text(const BenchmarkReport& report, bool markdown);

/// A script that makes gnuplot print the performance profiles of time and iterations as SVG.
std::string profile_script(const BenchmarkReport& report);

}  // namespace conddp
