#pragma once

#include <optional>
#include <vector>

#include "robot/model.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Maps the coordinates of a robot's independent joints to its full coordinates. A mimic joint has
/// q_j = multiplier·q_leader + offset, hence v_full = G v with a constant G that has one entry per
/// row. The order of joints is preserved.
class MimicMap {
 public:
  /// Throws std::invalid_argument if a joint mimics itself or mimics twice, if one of the two
  /// joints does not have exactly one coordinate, or if the leader mimics another joint.
  explicit MimicMap(const RobotModel& model);

  /// True without mimic joints: reduced and full coordinates are the same.
  bool identity() const { return identity_; }
  /// Sizes of the independent configuration and velocity.
  int nq() const { return nq_; }
  int nv() const { return nv_; }

  /// Start of a joint's independent coordinates; nullopt for a mimic joint.
  std::optional<int> position(int joint) const;
  std::optional<int> velocity(int joint) const;
  /// The entry of G in a row: its column and value.
  int column(int full_row) const { return velocities_[full_row].source; }
  double factor(int full_row) const { return velocities_[full_row].factor; }

  /// Expands an independent configuration to the full one.
  template <class S>
  void expand_configuration(const S* q, S* full) const;
  /// G v, for velocities and accelerations.
  template <class S>
  void expand_velocity(const S* v, S* full) const;
  /// Gᵀ f, for generalized forces.
  template <class S>
  void reduce_force(const S* full, S* f) const;
  /// Gᵀ A G of square matrices by columns.
  template <class S>
  void reduce_matrix(const S* full, S* A) const;
  /// The same for symmetric matrices, using lower triangles for input and output.
  template <class S>
  void reduce_symmetric(const S* full, S* A) const;

 private:
  struct Entry {
    int source;
    double factor, offset;
  };
  bool identity_;
  int nq_ = 0;
  int nv_ = 0;
  std::vector<int> position_, velocity_;            ///< per joint, −1 for mimic joints
  std::vector<Entry> configurations_, velocities_;  ///< per full coordinate
};

/// Jacobian columns of chosen full velocities, accumulated on the independent velocities that drive
/// them.
class ReducedColumns {
 public:
  ReducedColumns(const MimicMap& map, const std::vector<int>& full_columns);

  /// Independent velocity indices, ascending and unique.
  const std::vector<int>& columns() const { return columns_; }
  int count() const { return static_cast<int>(columns_.size()); }
  /// True if they equal the chosen indices, so that gathering is a copy.
  bool identity() const { return identity_; }
  /// out (rows x count()) = full (rows x chosen) times the chosen rows of G; by columns.
  template <class S>
  void gather(const S* full, int rows, S* out) const;

 private:
  struct Entry {
    int target;
    double factor;
  };
  bool identity_;
  std::vector<int> columns_;
  std::vector<Entry> entries_;  ///< per chosen column
};

}  // namespace conddp
