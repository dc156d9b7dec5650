#pragma once

#include <string>

#include "commands/closed_loops.hpp"

namespace conddp {

/// The defect of a text as "KEY=[LOW, HIGH]" with two numbers; empty if valid.
std::string largest_defect(const std::string& text);

/// Searches for the largest value of the key of `--largest` whose loop survives, and writes the
/// trials with the files of that loop. Returns the exit code.
int search_largest(const MpcArguments& arguments);

}  // namespace conddp
