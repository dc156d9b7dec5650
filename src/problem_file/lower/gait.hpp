#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Adds to a problem the phases of its gait, behind a choice of the start, a cost on each foot's
/// swings (`swing_<contact>`), and the way-points of references that follow the gait. Inconsistent
/// input is reported.
///
/// In cycle n, from 0, a foot swings from (n + start)·period for (1 − duty)·period. Its swings add
/// up to cycles·length along an arc (and cycles·turn). With s the largest of all starts, the n-th
/// swing ends at the share min(1, (n + 1 − s + start) / (cycles − s)) of the entire path. Feet that
/// start later therefore move further with their first swing and less with their last one. Around
/// each stance the feet lie symmetrically before and behind the base. The base moves uniformly from
/// the middle of the first swing to the middle of the last one. If all feet swing together, the
/// base moves with them. On a terrain it rises with the feet (GaitRise).
void add_gait(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
