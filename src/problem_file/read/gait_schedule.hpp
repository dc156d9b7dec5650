#pragma once

#include "problem_file/spec/spec.hpp"
#include "problem_file/spec/spec_gait.hpp"

namespace conddp {

/// Gives a problem the phases of a gait, a cost on each foot's swings (`swing_<contact>`), and to
/// references that go with the gait their way-points. What does not fit together is reported.
///
/// In cycle n, from 0, a foot swings from (n + start)·period for (1 − duty)·period. Its swings add
/// up to cycles·length along an arc (and cycles·turn); with s the largest of all starts, the n-th
/// one ends at the share min(1, (n + 1 − s + start) / (cycles − s)) of the whole way. So feet that
/// start later have gone further at their first touch-down and have less to go at their last:
/// around each stance the feet lie evenly before and behind the base, which moves evenly from the
/// middle of the first swing to the middle of the last one. Feet that all swing together take the
/// base along.
void add_gait(const GaitSpec& gait, ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
