#pragma once

#include "mpc/closed_loop.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// The commands of a closed loop (mpc.commands). From the time of each command on, footholds and
/// references are those of a gait that follows the commands up to it. The same holds for the path
/// of a regulator whose state at the start of the gait's path is `led` (empty: no such regulator).
/// Reports commands that cannot be followed.
std::vector<LoopCommand> build_commands(const ProblemSpec& spec, const BuiltProblem& built,
                                        const std::vector<double>& led, Diagnostics& out);

/// True if the phases of a file are those of a gait.
bool has_gait(const ProblemSpec& spec);

/// Number of phases that close a contact: they hold one that the previous phase does not hold.
int count_touch_downs(const ProblemSpec& spec);

/// The limits of mpc.retime, and the contacts that each knot holds. Empty without mpc.retime. Also
/// empty, with a report, if the plant does not simulate contacts.
std::optional<Retiming> build_retiming(const ProblemSpec& spec, const BuiltProblem& built,
                                       Diagnostics& out);

}  // namespace conddp
