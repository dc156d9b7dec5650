#include "problem_arguments.hpp"

#include "argument_checks.hpp"

namespace conddp {

void add_problem_arguments(CLI::App& command, ProblemArguments& arguments) {
  command.add_option("FILE", arguments.file, "Problem file")->required()->type_name("FILE.yaml");
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

}  // namespace conddp
