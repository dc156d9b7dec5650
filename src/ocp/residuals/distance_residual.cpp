#include <algorithm>

#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/system_columns.hpp"
#include "spatial/closest_points.hpp"

namespace conddp {
namespace {

using SystemPointer = std::shared_ptr<const MultibodySystem>;

/// A capsule fixed to a joint's body (−1: the world).
struct Body {
  int joint = -1;
  int root = -1;  ///< floating joint of its tree, −1: the root frame is the world
  Vector3<double> from, along;
  double radius = 0;

  Body(const RobotModel& model, const Capsule& capsule) : radius(capsule.radius) {
    SE3<double> placement = SE3<double>::identity();
    if (capsule.frame >= 0) {
      joint = model.frames[capsule.frame].joint;
      placement = model.frames[capsule.frame].placement;
    }
    if (joint >= 0) root = model.root[joint];
    from = placement.R * capsule.from + placement.p;
    along = placement.R * (capsule.to - capsule.from);
  }
  double squared_length() const { return squared_norm(along); }
};

/// One column of a pair's Jacobian: the effect of a joint coordinate on one of the bodies.
struct Drive {
  int joint;
  int axis;  ///< of a floating joint
  bool second;
};

/// Columns that move one body relative to the other, ascending, with their effects.
std::pair<std::vector<int>, std::vector<Drive>> drives_between(const RobotModel& model, int first,
                                                               int second) {
  std::vector<std::pair<int, Drive>> all;
  const auto add = [&](int joint, bool is_second) {
    for (int k = 0; k < model.joints[joint].nv(); ++k)
      all.push_back({model.joints[joint].v + k, {joint, k, is_second}});
  };
  // Parents precede their children, so the later joint is never an ancestor of the other.
  while (first != second) {
    int& later = first > second ? first : second;
    add(later, &later == &second);
    later = model.joints[later].parent;
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::pair<std::vector<int>, std::vector<Drive>> result;
  for (const auto& [column, drive] : all) {
    result.first.push_back(column);
    result.second.push_back(drive);
  }
  return result;
}

/// Two bodies, or a body and a half-space.
class PairOf {
 public:
  PairOf(const MultibodySystem& system, const DistancePair& pair)
      : PairOf(system, Body(system.robot(), pair.first), pair) {}

  int rows() const { return rows_; }
  RowBlock block() const { return {rows_, columns_.columns()}; }

  template <class S>
  void evaluate(const MultibodySystem::Data<S>& data, S* r) const {
    if (half_space_) return heights(data.robot, r);
    r[0] = closest(data.robot).distance - S(first_.radius + second_.radius);
  }

  template <class S>
  void differentiate(MultibodySystem::Data<S>& data, S* r, S* jacobian) const {
    const RobotData<S>& robot = data.robot;
    if (half_space_) {
      heights(robot, r);
      const Vector3<S> n = half_space_->normal.cast<S>();
      Force<S> slopes[2];
      for (int i = 0; i < rows_; ++i) slopes[i] = slope(robot, first_, S(i), n);
      return write(data, jacobian, [&](const Drive&, int row) { return slopes[row]; });
    }
    const ClosestPoints<S> c = closest(robot);
    r[0] = c.distance - S(first_.radius + second_.radius);
    const Vector3<S> n = (S(1.0) / c.distance) * c.gap;
    const Force<S> first = slope(robot, first_, c.s, n), second = slope(robot, second_, c.t, -n);
    write(data, jacobian, [&](const Drive& drive, int) { return drive.second ? second : first; });
  }

 private:
  PairOf(const MultibodySystem& system, const Body& first, const DistancePair& pair)
      : first_(first),
        second_(system.robot(), std::holds_alternative<Capsule>(pair.second)
                                    ? std::get<Capsule>(pair.second)
                                    : Capsule{}),
        rows_(pair.rows()),
        in_world_(first_.root != second_.root),
        columns_(system.mimic_map(), {}) {
    if (const auto* solid = std::get_if<HalfSpace>(&pair.second)) half_space_ = *solid;
    auto [columns, drives] = drives_between(system.robot(), first_.joint, second_.joint);
    columns_ = ReducedColumns(system.mimic_map(), columns);
    drives_ = std::move(drives);
  }

  /// A body's segment, in the root frame if both bodies share it, else in the world.
  template <class S>
  Segment<S> segment(const RobotData<S>& data, const Body& body) const {
    Segment<S> s{body.from.cast<S>(), body.along.cast<S>(), body.squared_length()};
    if (body.joint >= 0) {
      const SE3<S>& placement = data.placement[body.joint];
      s.p = placement.R * s.p + placement.p;
      s.d = placement.R * s.d;
    }
    if (in_world_ && body.root >= 0) {
      const SE3<S>& root = data.root[body.root];
      s.p = root.R * s.p + root.p;
      s.d = root.R * s.d;
    }
    return s;
  }

  template <class S>
  ClosestPoints<S> closest(const RobotData<S>& data) const {
    return closest_points(segment(data, first_), segment(data, second_));
  }

  template <class S>
  void heights(const RobotData<S>& data, S* r) const {
    const Segment<S> s = segment(data, first_);
    const Vector3<S> n = half_space_->normal.cast<S>();
    r[0] = dot(n, s.p) - S(half_space_->offset + first_.radius);
    if (rows_ == 2) r[1] = r[0] + dot(n, s.d);
  }

  /// Derivative of the coordinate along n at the point s of the segment, by a motion of the body in
  /// its root frame.
  template <class S>
  Force<S> slope(const RobotData<S>& data, const Body& body, const S& s, Vector3<S> n) const {
    if (body.joint < 0) return Force<S>::zero();
    if (in_world_ && body.root >= 0) n = transpose_times(data.root[body.root].R, n);
    const SE3<S>& placement = data.placement[body.joint];
    const Vector3<S> p = placement.R * (body.from.cast<S>() + s * body.along) + placement.p;
    return {n, cross(p, n)};
  }

  /// Writes the Jacobian from slope_of(drive, row).
  template <class S, class F>
  void write(MultibodySystem::Data<S>& data, S* jacobian, F slope_of) const {
    write_columns(columns_, rows_, data, jacobian, [&](S* out) {
      for (const Drive& drive : drives_)
        for (int row = 0; row < rows_; ++row) {
          const Force<S> f = slope_of(drive, row);
          const bool floating = drive.joint == (drive.second ? second_ : first_).root;
          *out++ = floating ? f[drive.axis] : dot(data.robot.axis[drive.joint], f);
        }
    });
  }

  Body first_, second_;
  std::optional<HalfSpace> half_space_;
  int rows_;
  bool in_world_;
  ReducedColumns columns_;
  std::vector<Drive> drives_;
};

class Distance : public ResidualBase<Distance> {
 public:
  Distance(SystemPointer system, std::vector<PairOf> pairs)
      : ResidualBase(blocks_of(pairs), 0, false),
        system_(std::move(system)),
        pairs_(std::move(pairs)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (const PairOf& pair : pairs_) {
      pair.evaluate(multibody_data(in), r);
      r += pair.rows();
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      pairs_[i].differentiate(multibody_data(in), r, jacobian);
      r += pairs_[i].rows();
      jacobian += blocks()[i].rows * blocks()[i].columns.size();
    }
  }

 private:
  static std::vector<RowBlock> blocks_of(const std::vector<PairOf>& pairs) {
    std::vector<RowBlock> blocks;
    for (const PairOf& pair : pairs) blocks.push_back(pair.block());
    return blocks;
  }
  SystemPointer system_;
  std::vector<PairOf> pairs_;
};

}  // namespace

int DistancePair::rows() const {
  return std::holds_alternative<HalfSpace>(second) && squared_norm(first.to - first.from) > 0 ? 2
                                                                                              : 1;
}

std::shared_ptr<const Residual> distance_residual(const SystemPointer& system,
                                                  const std::vector<DistancePair>& pairs) {
  std::vector<PairOf> made;
  for (const DistancePair& pair : pairs) made.emplace_back(*system, pair);
  return std::make_shared<Distance>(system, std::move(made));
}

}  // namespace conddp
