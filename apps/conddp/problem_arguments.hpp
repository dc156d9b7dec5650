#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace conddp {

/// Which problem a subcommand is about: the file and what the command line says about it.
struct ProblemArguments {
  std::string file;
  std::string solver;
  std::vector<std::string> drop;
  std::vector<std::string> settings;
};

/// Adds FILE, --solver, --drop and --set.
void add_problem_arguments(CLI::App& command, ProblemArguments& arguments);

}  // namespace conddp
