#pragma once

#include <string>

#include "commands/closed_loops.hpp"

namespace conddp {

/// Why a text is not "KEY=[LOW, HIGH]" with two numbers; empty where it is.
std::string largest_defect(const std::string& text);

/// Looks for the largest value of the key of `--largest` whose loop lasts, and writes the trials
/// with the files of that loop. Returns the exit code.
int search_largest(const MpcArguments& arguments);

}  // namespace conddp
