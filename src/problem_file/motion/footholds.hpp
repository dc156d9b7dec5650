#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Where a frame stands: a point, m, and how far it is turned about the vertical since the initial
/// state, rad.
struct Foothold {
  Vector3<double> p;
  double yaw = 0;
};

/// A frame of the robots and where it is in the initial state.
struct Foot {
  std::string name;  ///< as the file names it
  int frame = 0;
  Vector3<double> start;  ///< m
};

/// A run of phases in which a frame swings: [first_phase, end_phase), from the first knot on to the
/// node at which it touches down.
struct SwingRun {
  std::size_t first_phase, end_phase;
  int first, last;
};

/// The runs of consecutive phases in a choice of phases.
std::vector<SwingRun> swing_runs(const std::vector<bool>& chosen, const ProblemSpec& spec);

/// Where a foot stands when each phase begins, and at the end, as the file's swings of its frame
/// plan it: at its start at first, then where the last swing landed. Displaced landings stay on the
/// ground: the plane through the start with the normal of the frame's contact. A landing that
/// cannot be (see check_landings) leaves the foot where it was.
std::vector<Foothold> footholds(const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                const std::vector<double>& initial);

/// Reports displaced landings of a swing that cannot be: not one a run, on ground that is too
/// steep, of a robot whose base is fixed.
bool check_landings(const CostSpec& cost, const Foot& foot, std::size_t runs,
                    const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                    Diagnostics& out);

/// Whether the file has a swing of this frame.
bool swings(const std::string& frame, const ProblemSpec& spec);

}  // namespace conddp
