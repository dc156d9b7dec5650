#pragma once

#include "problem_file/motion/terrain.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Placement of a standing frame: a point, m, its rotation about the vertical since the initial
/// state, rad, and the normal of the terrain under it (vertical without terrain).
struct Foothold {
  Vector3<double> p;
  double yaw = 0;
  Vector3<double> normal{0, 0, 1};
};

/// A frame of the robots and its initial position.
struct Foot {
  std::string name;  ///< as in the file
  int frame = 0;
  Vector3<double> start;  ///< m
};

/// The orientation of a frame with this initial orientation at a foothold: turned about the
/// vertical, and tilted by the shortest rotation that follows the change of the normal.
Quaternion<double> orientation_at(const Foothold& foothold, const Foothold& first,
                                  const Quaternion<double>& initial);

/// Consecutive phases of a frame's swing: [first_phase, end_phase), from the first knot to the
/// touch-down node.
struct SwingRun {
  std::size_t first_phase, end_phase;
  int first, last;
};

/// Points of a contact that can touch, in its frame, m: the corners of a sole, or the origin.
std::vector<Vector3<double>> contact_points(const ContactSpec& contact);
/// The same of the first contact of a frame; the origin if there is none.
std::vector<Vector3<double>> contact_points(const std::string& frame, const ProblemSpec& spec);

/// Distance from an edge within which tracking errors take a point foot over it, m.
inline constexpr double kNearEdge = 0.03;

/// True if a foot with these points and this initial orientation stands on an edge or on a slope's
/// end: the corners of its sole, or a circle of kNearEdge around its point, do not lie on the plane
/// of the foothold.
bool is_on_edge(const Foothold& foothold, const Foothold& first, const Quaternion<double>& initial,
                const std::vector<Vector3<double>>& points, const TerrainSpec& terrain);

/// The runs of consecutive phases among the chosen phases.
std::vector<SwingRun> swing_runs(const std::vector<bool>& chosen, const ProblemSpec& spec);

/// Footholds of a foot at the beginning of each phase and at the end, according to the file's
/// swings of its frame. The first is its start, later ones the landing of the last swing. Displaced
/// landings stay on the ground: the terrain or, without one, the plane through the start with the
/// normal of the frame's contact. A frame keeps its initial distance from the terrain. After an
/// invalid landing (see check_landings) the foot stays in place.
std::vector<Foothold> footholds(const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                const std::vector<double>& initial);

/// Foothold of a foot that moves with the base from the initial state; on a terrain, the nearest
/// one that is not on an edge, if the foot's own size takes it there. Empty without ground.
std::optional<Foothold> displaced_foothold(const Foot& foot, const PlanarMotion& motion,
                                           const ProblemSpec& spec, const Plant& plant,
                                           const std::vector<double>& initial);

/// Reports invalid displaced landings of a swing: not one for each run, on ground that is too
/// steep or missing, or of a robot with a fixed base.
bool check_landings(const CostSpec& cost, const Foot& foot, std::size_t runs,
                    const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                    Diagnostics& out);

/// True if the file has a swing of this frame.
bool swings(const std::string& frame, const ProblemSpec& spec);

}  // namespace conddp
