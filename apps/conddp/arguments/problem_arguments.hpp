#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arguments/command.hpp"
#include "problem_file/spec/spec.hpp"

namespace conddp {

/// The word of the command line that stands for the standard input.
inline constexpr const char* kStandardInput = "-";

/// Which problem a subcommand is about: the file and what the command line says about it.
struct ProblemArguments {
  std::string file;  ///< or the name of an example problem, or kStandardInput
  std::string solver;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  std::vector<std::string> perturbations;
  std::uint64_t seed = 1;
  double max_time = 0;  ///< s, 0: the file's
  int threads = 0;      ///< 0: the file's
};

/// FILE, --solver, --drop, --set, --perturb and --seed.
std::vector<Argument> problem_arguments(ProblemArguments& arguments);

/// What the command line says about the problem and its solve, as settings: --set, and what the
/// other options stand for.
std::vector<std::string> settings_of(const ProblemArguments& arguments);

/// The problem with its settings, checked; nothing where there is an error.
std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out);

}  // namespace conddp
