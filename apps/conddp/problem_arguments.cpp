#include "problem_arguments.hpp"

#include <fmt/format.h>

#include "argument_checks.hpp"
#include "example_problems.hpp"
#include "problem_file/read/read_problem.hpp"

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
  auto* perturb =
      command
          .add_option("--perturb", arguments.perturbations,
                      "Take a random instance, as conddp bench does: initial_state=S or guess=S; "
                      "repeatable")
          ->type_name("NAME=NUMBER")
          ->allow_extra_args(false)
          ->check(perturbation());
  command.add_option("--seed", arguments.seed, "Which instance")
      ->type_name("N")
      ->check(perturbation_seed())
      ->capture_default_str()
      ->needs(perturb);
}

std::vector<std::string> settings_of(const ProblemArguments& arguments) {
  std::vector<std::string> settings = arguments.settings;
  if (arguments.perturbations.empty()) return settings;
  for (const auto& [name, value] : named_numbers(arguments.perturbations))
    settings.push_back(fmt::format("perturbation.{}={}", name, value));
  settings.push_back(fmt::format("perturbation.seed={}", arguments.seed));
  return settings;
}

std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out) {
  const auto file = find_problem_file(arguments.file, out);
  if (!file) return std::nullopt;
  return read_problem(*file, settings_of(arguments), out);
}

}  // namespace conddp
