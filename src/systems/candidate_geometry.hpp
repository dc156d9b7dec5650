#pragma once

#include <optional>
#include <vector>

#include "robot/data.hpp"
#include "systems/contact_candidate.hpp"

namespace conddp {

/// What a candidate's geometry says in one configuration. k = columns().size(); rows 0, 1, … are
/// the normal and the tangents: row r of `rows` times the velocities of the columns is the relative
/// velocity of the two bodies at the contact along that direction, and its transpose times a force
/// on the sphere is the generalised force. The first row is ∂φ/∂q.
template <class S>
struct CandidateRows {
  S gap;                     ///< φ, m; negative where the two overlap
  Vector3<S> point;          ///< of the sphere's surface, in the world
  Vector3<S> directions[3];  ///< normal and tangents, in the world
  AlignedVector<S> rows;     ///< (1 + tangents) x k by rows
  /// ∂rows/∂q_i for each column i, one matrix after the other; only from `differentiate`.
  AlignedVector<S> slopes;
};

/// The geometry of one candidate on a robot of one-DoF joints. Throws std::invalid_argument where a
/// floating joint moves one of the two bodies.
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
  /// Placements must be current.
  template <class S>
  void evaluate(const RobotData<S>& data, CandidateRows<S>& out) const;
  template <class S>
  void differentiate(const RobotData<S>& data, CandidateRows<S>& out) const;

 private:
  enum class Shape { half_space, sphere, box };

  /// A joint that moves one of the bodies or both.
  struct Drive {
    int joint;
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
  template <class S>
  Touch<S> touch(const Vector3<S>& center, const Pose<S>& against) const;
  template <class S>
  Pose<S> pose(const RobotData<S>& data, int joint, const SE3<double>& placement) const;
  template <class S>
  void evaluate_at(const Vector3<S>& center, const Pose<S>& against, CandidateRows<S>& out) const;

  Shape shape_;
  int first_joint_ = -1, second_joint_ = -1;
  SE3<double> first_, second_;  ///< centre of the sphere, origin and axes of what it may touch
  double radius_ = 0, second_radius_ = 0, offset_ = 0;
  Vector3<double> normal_, half_sizes_;
  std::optional<Vector3<double>> plane_;
  int tangents_;
  std::vector<int> columns_;
  std::vector<Drive> drives_;
};

}  // namespace conddp
