#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arguments/command.hpp"
#include "problem_file/spec/spec.hpp"

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
};

/// FILE, --solver, --drop, --set, --perturb and --seed.
std::vector<Argument> problem_arguments(ProblemArguments& arguments);

/// Command-line settings of the problem and its solve: --set, and the equivalents of other options.
std::vector<std::string> settings_of(const ProblemArguments& arguments);

/// The problem with its settings, validated; empty on errors.
std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out);

}  // namespace conddp
