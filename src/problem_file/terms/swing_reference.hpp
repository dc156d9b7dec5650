#pragma once

#include "problem_file/data/time_series.hpp"
#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// Reference of a swinging frame, one value per knot: positions, or poses for frame_placement. It
/// covers every run of consecutive phases that the cost names, and the touch-down node after it.
/// The first swing starts at the initial position, later ones at the previous landing. With s = 0
/// at the start and s = 1 at touch-down, uniform in time, the frame moves along the straight line
/// with s² (3 − 2 s) and turns likewise. It rises above the line by 16·height·s² (1 − s)². It lifts
/// off and lands with zero velocity. Landings given by displacements stay on the ground: the plane
/// through the initial position with the normal of the frame's contact. Invalid swings are
/// reported: the frame is held meanwhile or never lifts, or the number of displacements differs
/// from that of the swings.
std::optional<TimeSeries> swing_reference(const CostSpec& cost, const CostResidual& residual,
                                          const ProblemSpec& spec, const ContactPlan& plan,
                                          const Plant& plant, const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out);

}  // namespace conddp
