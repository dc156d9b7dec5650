#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "arguments/command.hpp"

namespace conddp {

// Arguments that several subcommands have.

/// --solver NAME, or another option whose value is the name of a solver.
Argument solver_argument(std::string& solver, std::string description);
/// --problem FILE.yaml, of the problem that solutions belong to.
Argument problem_of_solution(std::string& file, std::string description);
/// --drop NAME, repeatable.
Argument drop_argument(std::vector<std::string>& names, std::string description);
/// --set KEY=VALUE, repeatable.
Argument setting_argument(std::vector<std::string>& settings, std::string description);
/// --max-time SECONDS; 0 means that the option is not given.
Argument max_time_argument(double& seconds, std::string description);
/// --threads N; 0 means that the option is not given.
Argument threads_argument(int& threads, std::string description);
/// What --max-time and --threads stand for, where they are given, as settings of the problem.
std::vector<std::string> solve_settings(double max_time, int threads);
/// --perturb NAME=NUMBER, repeatable: how far an instance is from its problem.
Argument perturbation_argument(std::vector<std::string>& values, std::string description);
/// --seed N, which needs --perturb: which instance.
Argument seed_argument(std::uint64_t& seed, std::string description);

/// The arguments of one list, then those of the other.
std::vector<Argument> joined(std::vector<Argument> first, std::vector<Argument> second);

/// Accepts NAME=NUMBER with one of these names and a number in a range: "a number above 0" in
/// words.
ArgumentCheck named_number(std::vector<std::string> names, double lower, double upper,
                           std::string words);

/// The values of arguments that named_number accepts, the last one of each name.
std::map<std::string, double> named_numbers(const std::vector<std::string>& arguments);

}  // namespace conddp
