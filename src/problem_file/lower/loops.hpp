#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Replaces `loops` by contacts between frames that every phase and the last node hold, with the
/// frames' origins together, and for `surface` their axes, too. Reports names that contacts have.
void add_loops(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
