#pragma once

#include "problem_file/assemble/build.hpp"
#include "problem_file/read/read_problem.hpp"

namespace conddp {

/// Builds the problem that was read, with its homotopy if it has one (build_without_homotopy).
/// Nothing if none was read: `build_problem(read_problem(file, settings, out), {}, out)`.
std::optional<BuiltProblem> build_problem(std::optional<ProblemSpec> spec,
                                          const BuildOptions& options, Diagnostics& out);
/// Builds the same problem with other options.
std::optional<BuiltProblem> build_problem(const BuiltProblem& built, const BuildOptions& options,
                                          Diagnostics& out);

/// A grid in place of a problem's own.
struct OtherGrid {
  int factor = 1;    ///< subdivision of the steps of the phases
  int halvings = 0;  ///< how often the knots of the file are halved
  /// An answer replaces the guess, which is not sampled then.
  bool from_answer = false;
};

/// The setting, as for `--set`, that gives a problem this subdivision. A file without `mesh` gets
/// one, with an error that has no effect.
std::string grid_setting(const BuiltProblem& built, int factor);

/// The problem on another grid, with the same guess and dropped constraints. Nothing if it cannot
/// be built, with errors, or if a halved grid has too few knots.
std::optional<BuiltProblem> build_on_grid(const BuiltProblem& built, const OtherGrid& grid,
                                          Diagnostics& out);

/// SHA-256 of a problem, unperturbed and with all its constraints. It covers the content of the
/// file and its settings (ProblemSpec::definition), and the files with robots and data.
std::string problem_sha256(const BuiltProblem& built);

}  // namespace conddp
