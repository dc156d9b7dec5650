#pragma once

#include "problem_file/data/time_series.hpp"
#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// The positions (of frame_placement: poses) through which a frame swings, one a knot, over every
/// run of consecutive phases that the cost names, and at the first node after it, where the frame
/// touches down. It lifts off where it stood before: at first in the initial state, then where it
/// landed. With s from 0 at the start to 1 at touch-down, even in time, it goes along the straight
/// line with s² (3 − 2 s), turning likewise, and above it by 16·height·s² (1 − s)²: it rises and
/// lands at rest. Landings given by displacements stay on the ground: the plane through the place
/// where the frame stood at first, with the normal of its contact. Swings that cannot be (the frame
/// is held meanwhile, or never lifts; not one displacement a swing) are reported.
std::optional<TimeSeries> swing_reference(const CostSpec& cost, const CostResidual& residual,
                                          const ProblemSpec& spec, const ContactPlan& plan,
                                          const Plant& plant, const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out);

}  // namespace conddp
