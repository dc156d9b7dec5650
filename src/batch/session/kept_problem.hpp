#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "batch/plan/problem_family.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/grid_solve.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Errors in a problem, with their places.
struct ProblemFailure : std::runtime_error {
  explicit ProblemFailure(const Diagnostics& found);

  std::string text;  ///< all errors in compiler style
  std::vector<Diagnostic> errors;
};

/// An answer with its problem, in memory. It does not change any more, and threads may share it.
struct KeptAnswer {
  SolveTask task;  ///< on the grid of the answer
  const SolverInfo* solver;
  SolveResult result;
  std::vector<std::string> settings;
  std::vector<MeshRound> mesh;
  std::optional<SolutionCertificate> certificate;

  Solution solution() const;
  /// solution.json, with the certificate if there is one.
  OrderedJson document() const;
};

/// Solves a task; `settings` are those of its problem. Throws ProblemFailure if a finer grid cannot
/// be built.
KeptAnswer solve_task(SolveTask task, const GridSolve::Options& options,
                      std::vector<std::string> settings);

/// Starts a task from an answer, on the grid of the task: with multipliers if shapes agree, else
/// states and controls, interpolated. Throws std::invalid_argument for other states or phases.
void start_from(const KeptAnswer& former, SolveTask& task);

/// A problem file, or a text in its place, with settings that replace its values. Methods that fail
/// at the problem throw ProblemFailure.
class KeptProblem {
 public:
  using Settings = std::map<std::string, std::string>;  ///< key path and YAML text of its value

  static KeptProblem load(const std::filesystem::path& file);
  /// Relative paths of the text are resolved in the folder.
  static KeptProblem parse(const std::string& text, const std::filesystem::path& folder);

  void set(const std::string& key, const std::string& value);
  /// A key's value as set or in the file; nothing if neither has it.
  std::optional<OrderedJson> get(const std::string& key) const;
  /// The settings, and further ones that replace them, as for --set.
  std::vector<std::string> settings(const Settings& more = {}) const;

  /// Messages of a build refer to these texts.
  const Diagnostics& texts() const { return family_->texts(); }
  /// Builds the problem with settings; `out` gets warnings and notes.
  SolveTask build(const std::vector<std::string>& settings, Diagnostics& out) const;
  std::unique_ptr<LoopTask> build_loop() const;

 private:
  explicit KeptProblem(std::shared_ptr<const ProblemFamily> family) : family_(std::move(family)) {}

  std::shared_ptr<const ProblemFamily> family_;
  Settings settings_;
};

/// Columns, units and phases of a problem's motions, its name and its number of knots.
OrderedJson problem_outline(const BuiltProblem& built);

}  // namespace conddp
