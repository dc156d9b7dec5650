#pragma once

#include "problem_file/contact_plan.hpp"
#include "problem_file/time_series.hpp"

namespace conddp {

/// The positions through which a frame swings, one a knot, over every run of consecutive phases
/// that the cost names. It lifts off where it stood before: at first in the initial state, then
/// where it landed. With s from 1/n at the first knot to 1 at the last one, the ground path goes
/// along s² (3 − 2 s), which lands vertically, and the height is that of the straight line plus
/// 4·height·s·(1 − s). A swing in a phase that holds the frame as a contact is reported.
std::optional<TimeSeries> swing_reference(const CostSpec& cost, int frame, const ProblemSpec& spec,
                                          const ContactPlan& plan, const Plant& plant,
                                          const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out);

}  // namespace conddp
