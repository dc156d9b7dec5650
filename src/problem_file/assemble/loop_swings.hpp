#pragma once

#include <optional>

#include "mpc/swing_starts.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Swings of a file whose loop starts them at the measured feet; empty for other loops. Reports a
/// file without swings.
std::optional<FootSwings> build_loop_swings(const ProblemSpec& spec, const BuiltProblem& built,
                                            Diagnostics& out);

}  // namespace conddp
