#pragma once

#include <optional>
#include <vector>

#include "analysis/contact/contact_motion.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// Of heights that are kept: a contact that rests may be so far off, m.
inline constexpr double kGrazing = 1e-4;
/// Whether two unit vectors count as one normal.
bool is_same_normal(const Vector3<double>& a, const Vector3<double>& b);

/// What the candidates of a motion may touch of the world, as obstacles of a problem file: a half
/// space or a sphere is one surface, a box has six, the planes of its faces.
class ContactSurfaces {
 public:
  explicit ContactSurfaces(const ContactMotion& motion);

  /// 0 where a body of the robot carries what is touched, or where it is soft.
  int count(std::size_t candidate) const;
  /// The surface that a candidate touches at all nodes from `first` to `last`, which has the same
  /// normal there; none where that turns or is not one of a face.
  std::optional<int> touched(std::size_t candidate, int first, int last) const;
  /// The normal where the candidate is at a node, in the world.
  const Vector3<double>& normal(std::size_t candidate, int node) const {
    return looks_[candidate][node].normal;
  }
  /// How far the candidate is from what it may touch at a node, m.
  double gap(std::size_t candidate, int node) const { return looks_[candidate][node].gap; }
  /// Whether the middle of the candidate's sphere moves along the surface between these nodes,
  /// faster than `speed` (m/s) in one of the steps.
  bool travels(std::size_t candidate, int first, int last, double speed) const;
  /// Whether the candidate lies outside of a surface at a node: for a box, in front of that face.
  bool is_outside(std::size_t candidate, int surface, int node) const;
  /// The surface outside of which the candidate is for the longest time from a node on; none where
  /// it is outside of no surface there.
  std::optional<int> longest_outside(std::size_t candidate, int node) const;

  /// The surface as an obstacle, smaller by `less` (m) all around.
  OrderedJson obstacle(std::size_t candidate, int surface, double less) const;

 private:
  /// A candidate at a node.
  struct Look {
    double gap;
    Vector3<double> normal, center;  ///< of the sphere, in the world
  };
  struct Plane {
    Vector3<double> normal, point;
  };
  Plane plane(std::size_t candidate, int surface) const;
  const ContactCandidate& at(std::size_t candidate) const {
    return motion_.plant.contacts.candidates[candidate];
  }

  const ContactMotion& motion_;
  std::vector<std::vector<Look>> looks_;  ///< by candidate and node
};

}  // namespace conddp
