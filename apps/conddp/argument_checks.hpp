#pragma once

#include <CLI/CLI.hpp>

namespace conddp {

/// Refuses an empty argument, which is mostly a variable of a script that was not set.
CLI::Validator not_empty();

/// A finite decimal number in a range: "0.001 to 1e9 s" in words. (CLI11's own lets NaN through.)
CLI::Validator number_between(double lower, double upper, const std::string& words);

}  // namespace conddp
