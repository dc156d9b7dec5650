#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace conddp {

/// Refuses an empty argument, which is mostly a variable of a script that was not set.
CLI::Validator not_empty();

/// The name of a solver.
CLI::Validator solver_name();

/// A finite decimal number in a range: "0.001 to 1e9 s" in words. (CLI11's own lets NaN through.)
CLI::Validator number_between(double lower, double upper, const std::string& words);

/// NAME=NUMBER with one of these names and a number in a range.
CLI::Validator named_number(const std::vector<std::string>& names, double lower, double upper,
                            const std::string& words);

/// How far an instance is from its problem, and which one it is.
CLI::Validator perturbation();
CLI::Validator perturbation_seed();

/// The values of arguments that named_number let through, the last one of each name.
std::map<std::string, double> named_numbers(const std::vector<std::string>& arguments);

}  // namespace conddp
