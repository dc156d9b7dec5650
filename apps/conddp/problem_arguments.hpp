#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "problem_file/spec.hpp"

namespace conddp {

/// Which problem a subcommand is about: the file and what the command line says about it.
struct ProblemArguments {
  std::string file;  ///< or the name of an example problem
  std::string solver;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
};

/// Adds FILE, --solver, --drop and --set.
void add_problem_arguments(CLI::App& command, ProblemArguments& arguments);

/// The problem with its settings, checked; nothing where there is an error.
std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out);

}  // namespace conddp
