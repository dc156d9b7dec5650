#pragma once

#include "problem_file/spec.hpp"

namespace conddp {

/// Where a swing that starts here lands, m.
Vector3<double> landing_place(const SwingSpec& swing, const Vector3<double>& from);

/// Where a frame stands when each phase begins, and at the end, as the file's swings of this frame
/// plan it: at `start` at first, then where the last swing landed.
std::vector<Vector3<double>> footholds(const std::string& frame, const Vector3<double>& start,
                                       const ProblemSpec& spec);

/// Whether the file has a swing of this frame.
bool swings(const std::string& frame, const ProblemSpec& spec);

}  // namespace conddp
