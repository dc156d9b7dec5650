#pragma once

#include <optional>
#include <vector>

#include "robot/data.hpp"
#include "systems/contact/contact_candidate.hpp"

namespace conddp {

/// A candidate's geometry in one configuration. k = columns().size(); rows 0, 1, … are the normal
/// and the tangents. Row r of `rows` times the velocities of the columns is the relative velocity
/// of the two bodies at the contact along that direction. Its transpose times a force on the sphere
/// is the generalized force. The first row is ∂φ/∂q.
template <class S>
struct CandidateRows {
  S gap;                     ///< φ, m; negative if the bodies overlap
  Vector3<S> point;          ///< of the sphere's surface, in the world
  Vector3<S> directions[3];  ///< normal and tangents, in the world
  AlignedVector<S> rows;     ///< (1 + tangents) x k by rows
  /// ∂rows/∂q_i for each column i, one matrix after the other; written only by `differentiate`. For
  /// a floating joint q_i is the i-th direction of its tangent space, in its own frame.
  AlignedVector<S> slopes;
  AlignedVector<Motion<S>> axes;  ///< scratch: the twist of each column, in the world
};

/// The geometry of one candidate on a robot, whose base may float.
class CandidateGeometry {
 public:
  CandidateGeometry(const RobotModel& model, const ContactCandidate& candidate,
                    const std::optional<Vector3<double>>& plane);

  /// Velocity indices of the robot that move either body, ascending.
  const std::vector<int>& columns() const { return columns_; }
  /// 0 without friction, 1 in a plane, 2 in space.
  int tangents() const { return tangents_; }

  /// Memory for the results below.
  template <class S>
  CandidateRows<S> create_rows() const;
  /// Computes the rows; placements must be current.
  template <class S>
  void evaluate(const RobotData<S>& data, CandidateRows<S>& out) const;
  template <class S>
  void differentiate(const RobotData<S>& data, CandidateRows<S>& out) const;

 private:
  enum class Shape { half_space, sphere, box };

  /// A degree of freedom that moves at least one of the bodies.
  struct Drive {
    int joint;
    int direction;  ///< one of the six of a floating joint; −1 for a one-DoF joint
    bool first, second;
  };
  /// A body's reference point and axes in the world.
  template <class S>
  struct Pose {
    Vector3<S> p;
    Matrix3<S> R;
  };
  template <class S>
  struct Touch {
    S gap;
    Vector3<S> directions[3];
  };
  void place_second(const RobotModel& model, const ContactCandidate& candidate);
  void add_drives(const RobotModel& model);
  template <class S>
  Touch<S> touch(const Vector3<S>& center, const Pose<S>& against) const;
  template <class S>
  Pose<S> pose(const RobotData<S>& data, int joint, int root, const SE3<double>& placement) const;
  /// The twists of the drives, in the world.
  template <class S>
  void update_axes(const RobotData<S>& data, CandidateRows<S>& out) const;
  /// True if drive i moves the axis of drive j.
  bool carries(const Drive& i, const Drive& j) const;
  template <class S>
  struct Shift;

  Shape shape_;
  int first_joint_ = -1, second_joint_ = -1;
  int first_root_ = -1, second_root_ = -1;  ///< the floating joints of their trees
  SE3<double> first_, second_;  ///< center of the sphere; origin and axes of the opposite shape
  double radius_ = 0, second_radius_ = 0, offset_ = 0;
  Vector3<double> normal_, half_sizes_;
  std::optional<Vector3<double>> plane_;
  int tangents_;
  std::vector<int> columns_;
  std::vector<int> roots_;  ///< root of each drive's tree
  std::vector<Drive> drives_;
};

}  // namespace conddp
