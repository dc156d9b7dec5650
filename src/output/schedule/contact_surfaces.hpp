#pragma once

#include <optional>
#include <vector>

#include "analysis/contact/contact_motion.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// Tolerance on heights: the maximum distance of a resting contact, m.
inline constexpr double kGrazing = 1e-4;
/// True if two unit vectors count as one normal.
bool is_same_normal(const Vector3<double>& a, const Vector3<double>& b);

/// World surfaces that the candidates of a motion may touch, as obstacles of a problem file. A half
/// space or a sphere gives a single surface, a box six, the planes of its faces.
class ContactSurfaces {
 public:
  explicit ContactSurfaces(const ContactMotion& motion);

  /// Number of surfaces; 0 if the counterpart belongs to the robot or is soft.
  int count(std::size_t candidate) const;
  /// The surface that a candidate touches at all nodes from `first` to `last` with a constant
  /// normal. Empty if the normal turns or does not belong to a face.
  std::optional<int> touched(std::size_t candidate, int first, int last) const;
  /// The normal at the candidate's position at a node, in the world.
  const Vector3<double>& normal(std::size_t candidate, int node) const {
    return looks_[candidate][node].normal;
  }
  /// Distance of the candidate from its counterpart at a node, m.
  double gap(std::size_t candidate, int node) const { return looks_[candidate][node].gap; }
  /// True if the center of the candidate's sphere moves along the surface between these nodes
  /// faster than `speed` (m/s) in one of the steps.
  bool travels(std::size_t candidate, int first, int last, double speed) const;
  /// True if the candidate is outside a surface at a node: for a box, in front of that face.
  bool is_outside(std::size_t candidate, int surface, int node) const;
  /// The surface that the candidate stays outside of for the longest time, starting at a node;
  /// empty if it is not outside any surface there.
  std::optional<int> longest_outside(std::size_t candidate, int node) const;

  /// The surface as an obstacle, shrunk by `less` (m) on all sides.
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
