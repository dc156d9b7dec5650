#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arguments/command.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "terminal/messages.hpp"

namespace conddp {

/// Command-line word for the standard input.
inline constexpr const char* kStandardInput = "-";

/// The problem of a subcommand: its file and command-line settings.
struct ProblemArguments {
  std::string file;  ///< or an example name, or kStandardInput
  std::string solver;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  std::vector<std::string> perturbations;
  std::uint64_t seed = 1;
  double max_time = 0;  ///< s, 0: as in the file
  int threads = 0;      ///< 0: as in the file
  std::string folder;   ///< for outputs
  bool json = false, quiet = false, verbose = false;
};

/// FILE, --solver, --drop, --set, --perturb and --seed.
std::vector<Argument> problem_arguments(ProblemArguments& arguments);

/// Command-line settings of the problem and its solve: --set, and the equivalents of other options.
std::vector<std::string> settings_of(const ProblemArguments& arguments);

Verbosity verbosity_of(const ProblemArguments& arguments);

/// The folder for the outputs of a problem.
std::filesystem::path output_folder(const ProblemArguments& arguments, const BuiltProblem& built);

/// --drop, and the source of --solver.
BuildOptions build_options_of(const ProblemArguments& arguments);

/// The file, or the standard input, as a tree.
std::optional<ProblemDocument> load_problem_of(const ProblemArguments& arguments, Diagnostics& out);

/// The problem with its settings, built; empty on errors.
std::optional<BuiltProblem> build_problem_of(const ProblemArguments& arguments,
                                             const BuildOptions& options, Diagnostics& out);

}  // namespace conddp
