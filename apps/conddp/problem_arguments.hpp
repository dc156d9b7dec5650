#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Which problem a subcommand is about: the file and what the command line says about it.
struct ProblemArguments {
  std::string file;  ///< or the name of an example problem
  std::string solver;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  std::vector<std::string> perturbations;
  std::uint64_t seed = 1;
};

/// Adds FILE, --solver, --drop, --set, --perturb and --seed.
void add_problem_arguments(CLI::App& command, ProblemArguments& arguments);

/// All settings of the command line: --set, and what --perturb and --seed stand for.
std::vector<std::string> settings_of(const ProblemArguments& arguments);

/// The problem with its settings, checked; nothing where there is an error.
std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out);

}  // namespace conddp
