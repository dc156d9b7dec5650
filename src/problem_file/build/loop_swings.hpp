#pragma once

#include <optional>

#include "mpc/swing_starts.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The swings of a file whose loop lets them begin where the feet are measured; nothing of a loop
/// that does not. A file without swings is reported.
std::optional<FootSwings> build_loop_swings(const ProblemSpec& spec, const BuiltProblem& built,
                                            Diagnostics& out);

}  // namespace conddp
