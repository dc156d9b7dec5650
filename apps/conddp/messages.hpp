#pragma once

#include "problem_file/diagnostic.hpp"

namespace conddp {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Prints diagnostics to stderr: errors always, warnings unless quiet, notes when verbose.
void print_messages(const Diagnostics& diagnostics, Verbosity verbosity);

}  // namespace conddp
