#include "problem_arguments.hpp"

#include "argument_checks.hpp"
#include "example_problems.hpp"
#include "problem_file/read_problem.hpp"

namespace conddp {

void add_problem_arguments(CLI::App& command, ProblemArguments& arguments) {
  command
      .add_option("FILE", arguments.file,
                  "Problem file, or the name of an example (conddp list problems)")
      ->required()
      ->type_name("FILE.yaml");
  command.add_option("--solver", arguments.solver, "Solver instead of the file's")
      ->type_name("NAME")
      ->check(solver_name());
  command
      .add_option("--drop", arguments.drop, "Leave this constraint out; its violation is reported")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      .add_option("--set", arguments.settings,
                  "Replace a value of the file, as in --set solver.max_iterations=50")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out) {
  const auto file = find_problem_file(arguments.file, out);
  if (!file) return std::nullopt;
  return read_problem(*file, arguments.settings, out);
}

}  // namespace conddp
