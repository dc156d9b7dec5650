#pragma once

#include "mpc/closed_loop.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The commands of a closed loop (mpc.commands). From the time of each one on the footholds and
/// references are those of a gait that is led by the commands up to it, and so is the path of a
/// regulator whose state is `led` where the way begins (empty: there is none). What cannot follow
/// them is reported.
std::vector<LoopCommand> build_commands(const ProblemSpec& spec, const BuiltProblem& built,
                                        const std::vector<double>& led, Diagnostics& out);

/// Whether the phases of a file are those of a gait.
bool has_gait(const ProblemSpec& spec);

/// How many phases of a file hold a contact that the one before them does not.
int count_touch_downs(const ProblemSpec& spec);

/// The limits of mpc.retime, and which contacts each knot holds. Nothing where there are none or
/// they have no meaning, which is reported.
std::optional<Retiming> build_retiming(const ProblemSpec& spec, const BuiltProblem& built,
                                       Diagnostics& out);

}  // namespace conddp
