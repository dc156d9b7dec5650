#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/comparison/solution_comparison.hpp"
#include "arguments/command.hpp"

namespace conddp {

// Arguments shared by several subcommands.

/// --solver NAME, or another option whose value is a solver name.
Argument solver_argument(std::string& solver, std::string description);
/// --problem FILE.yaml: the problem of the solutions.
Argument problem_of_solution(std::string& file, std::string description);
/// --drop NAME, repeatable.
Argument drop_argument(std::vector<std::string>& names, std::string description);
/// --set KEY=VALUE, repeatable.
Argument setting_argument(std::vector<std::string>& settings, std::string description);
/// --max-time SECONDS; 0 means that the option is not given.
Argument max_time_argument(double& seconds, std::string description);
/// --threads N; 0 means that the option is not given.
Argument threads_argument(int& threads, std::string description);
/// The settings equivalent to --max-time and --threads, if given.
std::vector<std::string> solve_settings(double max_time, int threads);
/// --perturb NAME=NUMBER, repeatable: the distance of an instance from its problem.
Argument perturbation_argument(std::vector<std::string>& values, std::string description);
/// --seed N, which needs --perturb: the seed of the instance.
Argument seed_argument(std::uint64_t& seed, std::string description);

/// The arguments of both lists in order.
std::vector<Argument> joined(std::vector<Argument> first, std::vector<Argument> second);

/// Accepts NAME=NUMBER with one of these names and a number in a range, described by `words`: "a
/// number above 0".
ArgumentCheck named_number(std::vector<std::string> names, double lower, double upper,
                           std::string words);

/// The values of arguments accepted by named_number; the last one of each name wins.
std::map<std::string, double> named_numbers(const std::vector<std::string>& arguments);

/// --tolerance NAME=NUMBER; comparison_tolerances() replaces tolerances by these values.
Argument comparison_tolerance_argument(std::vector<std::string>& values);
ComparisonTolerances comparison_tolerances(const std::vector<std::string>& values,
                                           ComparisonTolerances tolerances = {});

/// One difference as a line of text.
std::string difference_text(const Difference& difference);

}  // namespace conddp
