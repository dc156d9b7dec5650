#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Placement of a standing frame: a point, m, and its rotation about the vertical since the initial
/// state, rad.
struct Foothold {
  Vector3<double> p;
  double yaw = 0;
};

/// A frame of the robots and its initial position.
struct Foot {
  std::string name;  ///< as in the file
  int frame = 0;
  Vector3<double> start;  ///< m
};

/// Consecutive phases of a frame's swing: [first_phase, end_phase), from the first knot to the
/// touch-down node.
struct SwingRun {
  std::size_t first_phase, end_phase;
  int first, last;
};

/// The runs of consecutive phases among the chosen phases.
std::vector<SwingRun> swing_runs(const std::vector<bool>& chosen, const ProblemSpec& spec);

/// Footholds of a foot at the beginning of each phase and at the end, according to the file's
/// swings of its frame. The first is its start, later ones the landing of the last swing. Displaced
/// landings stay on the ground: the plane through the start with the normal of the frame's contact.
/// After an invalid landing (see check_landings) the foot stays in place.
std::vector<Foothold> footholds(const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                const std::vector<double>& initial);

/// Reports invalid displaced landings of a swing: not one for each run, on ground that is too
/// steep, or of a robot with a fixed base.
bool check_landings(const CostSpec& cost, const Foot& foot, std::size_t runs,
                    const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                    Diagnostics& out);

/// True if the file has a swing of this frame.
bool swings(const std::string& frame, const ProblemSpec& spec);

}  // namespace conddp
