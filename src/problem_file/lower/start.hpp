#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Lets the first phase choose all that is free at the start: free durations, free parameters, and
/// the first linear controls if they are not given. A problem without a phase `choose` gets one in
/// front, and the numbers of its knots grow by one.
void choose_start(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
