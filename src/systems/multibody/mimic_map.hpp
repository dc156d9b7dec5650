#pragma once

#include <optional>
#include <vector>

#include "robot/model.hpp"
#include "systems/system.hpp"

namespace conddp {

/// How a robot's full coordinates follow from those of its independent joints:
/// q_j = multiplier·q_leader + offset for a mimic joint, hence v_full = G v with a constant G that
/// has one entry per row. Joints keep their order.
class MimicMap {
 public:
  /// Throws std::invalid_argument where a joint mimics itself or twice, or where one of the two has
  /// not exactly one coordinate or the leader mimics another joint.
  explicit MimicMap(const RobotModel& model);

  /// Whether no joint mimics another one: reduced and full coordinates are the same.
  bool identity() const { return identity_; }
  /// Sizes of the independent configuration and velocity.
  int nq() const { return nq_; }
  int nv() const { return nv_; }

  /// Where a joint's independent coordinates begin, nullopt for a mimic joint.
  std::optional<int> position(int joint) const;
  std::optional<int> velocity(int joint) const;
  /// The entry of G in a row: its column and value.
  int column(int full_row) const { return velocities_[full_row].source; }
  double factor(int full_row) const { return velocities_[full_row].factor; }

  /// Full configuration of an independent one.
  template <class S>
  void expand_configuration(const S* q, S* full) const;
  /// G v, for velocities and accelerations.
  template <class S>
  void expand_velocity(const S* v, S* full) const;
  /// Gᵀ f, for generalised forces.
  template <class S>
  void reduce_force(const S* full, S* f) const;
  /// Gᵀ A G of square matrices by columns.
  template <class S>
  void reduce_matrix(const S* full, S* A) const;
  /// The same of symmetric matrices given and wanted by their lower triangles.
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

/// Jacobian columns of chosen full velocities, gathered on the independent velocities that drive
/// them.
class ReducedColumns {
 public:
  ReducedColumns(const MimicMap& map, const std::vector<int>& full_columns);

  /// Independent velocity indices, ascending, each once.
  const std::vector<int>& columns() const { return columns_; }
  int count() const { return static_cast<int>(columns_.size()); }
  /// Whether they are the chosen ones, so that nothing needs gathering.
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
