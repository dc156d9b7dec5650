#pragma once

#include "problem_file/contact_plan.hpp"
#include "problem_file/time_series.hpp"

namespace conddp {

/// The positions through which a frame swings, one a knot, over every run of consecutive phases
/// that the cost names, and at the first node after it, where the frame touches down. It lifts off
/// where it stood before: at first in the initial state, then where its
/// last swing landed. With s, the share of
/// the time from the first knot to touch-down, it goes along the straight line with s² (3 − 2 s)
/// and above it by 16·height·s² (1 − s)²: it rises and lands at rest. A swing in a phase that holds
/// the frame as a contact is reported.
std::optional<TimeSeries> swing_reference(const CostSpec& cost, int frame, const ProblemSpec& spec,
                                          const ContactPlan& plan, const Plant& plant,
                                          const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out);

}  // namespace conddp
