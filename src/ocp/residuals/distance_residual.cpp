#include <algorithm>
#include <limits>

#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/system_columns.hpp"
#include "spatial/closest_points.hpp"
#include "spatial/convex_distance.hpp"
#include "spatial/dual.hpp"

namespace conddp {
namespace {

using SystemPointer = std::shared_ptr<const MultibodySystem>;

/// A joint's body (−1: the world), and a frame on it.
struct Carrier {
  int joint = -1;
  int root = -1;  ///< floating joint of its tree, −1: the root frame is the world
  SE3<double> placement = SE3<double>::identity();

  Carrier(const RobotModel& model, int frame) {
    if (frame < 0) return;
    joint = model.frames[frame].joint;
    placement = model.frames[frame].placement;
    if (joint >= 0) root = model.root[joint];
  }
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

/// Motion of two bodies relative to each other.
class BodyPair {
 public:
  BodyPair(const MultibodySystem& system, const Carrier& first, const Carrier& second)
      : first_(first),
        second_(second),
        in_world_(first.root != second.root),
        columns_(system.mimic_map(), {}) {
    auto [columns, drives] = drives_between(system.robot(), first.joint, second.joint);
    columns_ = ReducedColumns(system.mimic_map(), columns);
    drives_ = std::move(drives);
  }

  const Carrier& first() const { return first_; }
  const Carrier& second() const { return second_; }
  const std::vector<int>& columns() const { return columns_.columns(); }

  /// Calls f(placement) for a body's placement, and for that of its root unless the bodies share
  /// it.
  template <class S, class F>
  void for_placements(const RobotData<S>& data, const Carrier& body, F&& f) const {
    if (body.joint >= 0) f(data.placement[body.joint]);
    if (in_world_ && body.root >= 0) f(data.root[body.root]);
  }

  /// Derivative of the coordinate along n of a point of the body, given in the body's axes, by a
  /// motion of the body in its root frame.
  template <class S>
  Force<S> slope(const RobotData<S>& data, const Carrier& body, const Vector3<S>& point,
                 Vector3<S> n) const {
    if (body.joint < 0) return Force<S>::zero();
    if (in_world_ && body.root >= 0) n = transpose_times(data.root[body.root].R, n);
    const SE3<S>& placement = data.placement[body.joint];
    const Vector3<S> p = placement.R * point + placement.p;
    return {n, cross(p, n)};
  }

  /// Writes the Jacobian from slope_of(drive, row).
  template <class S, class F>
  void write(int rows, MultibodySystem::Data<S>& data, S* jacobian, F slope_of) const {
    write_columns(columns_, rows, data, jacobian, [&](S* out) {
      for (const Drive& drive : drives_)
        for (int row = 0; row < rows; ++row) {
          const Force<S> f = slope_of(drive, row);
          const bool floating = drive.joint == (drive.second ? second_ : first_).root;
          *out++ = floating ? f[drive.axis] : dot(data.robot.axis[drive.joint], f);
        }
    });
  }

 private:
  Carrier first_, second_;
  bool in_world_;
  ReducedColumns columns_;
  std::vector<Drive> drives_;
};

/// A capsule's segment in the axes of its body.
struct Axis {
  Vector3<double> from, along;
  double radius;

  Axis(const Carrier& body, const Capsule& capsule)
      : from(body.placement.R * capsule.from + body.placement.p),
        along(body.placement.R * (capsule.to - capsule.from)),
        radius(capsule.radius) {}
};

class TwoCapsules {
 public:
  TwoCapsules(const MultibodySystem& system, const Capsule& first, const Capsule& second)
      : bodies_(system, {system.robot(), first.frame}, {system.robot(), second.frame}),
        first_(bodies_.first(), first),
        second_(bodies_.second(), second) {}

  RowBlock block() const { return {1, bodies_.columns()}; }

  template <class S>
  void evaluate(const MultibodySystem::Data<S>& data, S* r) const {
    r[0] = closest(data.robot).distance - S(first_.radius + second_.radius);
  }

  template <class S>
  void differentiate(MultibodySystem::Data<S>& data, S* r, S* jacobian) const {
    const RobotData<S>& robot = data.robot;
    const ClosestPoints<S> c = closest(robot);
    r[0] = c.distance - S(first_.radius + second_.radius);
    const Vector3<S> n = (S(1.0) / c.distance) * c.gap;
    const Force<S> first = slope(robot, bodies_.first(), first_, c.s, n),
                   second = slope(robot, bodies_.second(), second_, c.t, -n);
    bodies_.write(1, data, jacobian,
                  [&](const Drive& drive, int) { return drive.second ? second : first; });
  }

 private:
  /// A segment in the root frame if both bodies share it, else in the world.
  template <class S>
  Segment<S> segment(const RobotData<S>& data, const Carrier& body, const Axis& axis) const {
    Segment<S> s{axis.from.cast<S>(), axis.along.cast<S>(), squared_norm(axis.along)};
    bodies_.for_placements(data, body, [&](const SE3<S>& placement) {
      s.p = placement.R * s.p + placement.p;
      s.d = placement.R * s.d;
    });
    return s;
  }
  template <class S>
  ClosestPoints<S> closest(const RobotData<S>& data) const {
    return closest_points(segment(data, bodies_.first(), first_),
                          segment(data, bodies_.second(), second_));
  }
  template <class S>
  Force<S> slope(const RobotData<S>& data, const Carrier& body, const Axis& axis, const S& share,
                 const Vector3<S>& n) const {
    return bodies_.slope(data, body, axis.from.cast<S>() + share * axis.along, n);
  }

  BodyPair bodies_;
  Axis first_, second_;
};

/// The core of a shape: points in the axes of its body, whose convex hull is expanded by a radius.
struct Core {
  std::vector<Vector3<double>> points;
  double radius;

  Core(const Carrier& body, const Capsule& capsule) : radius(capsule.radius) {
    const Axis axis(body, capsule);
    points = {axis.from};
    if (squared_norm(axis.along) > 0) points.push_back(axis.from + axis.along);
  }
  Core(const Carrier& body, const Polytope& polytope) : radius(polytope.radius) {
    for (const Vector3<double>& vertex : polytope.vertices)
      points.push_back(body.placement.R * vertex + body.placement.p);
  }
};

/// Heights of a core above a half-space: of each point, or of the lowest of many.
class Heights {
 public:
  template <class Shape>
  Heights(const MultibodySystem& system, const Shape& shape, const HalfSpace& half_space)
      : bodies_(system, {system.robot(), shape.frame}, {system.robot(), -1}),
        core_(bodies_.first(), shape),
        half_space_(half_space),
        rows_(DistancePair{shape, half_space}.rows()) {}

  RowBlock block() const { return {rows_, bodies_.columns()}; }

  template <class S>
  void evaluate(const MultibodySystem::Data<S>& data, S* r) const {
    Points<S> points;
    find_points(data.robot, points);
    write_heights(data.robot, points, r);
  }

  template <class S>
  void differentiate(MultibodySystem::Data<S>& data, S* r, S* jacobian) const {
    Points<S> points;
    find_points(data.robot, points);
    write_heights(data.robot, points, r);
    const Vector3<S> n = half_space_.normal.cast<S>();
    Force<S> slopes[DistancePair::kMostHeights];
    for (int row = 0; row < rows_; ++row)
      slopes[row] = bodies_.slope(data.robot, bodies_.first(), points[row], n);
    bodies_.write(rows_, data, jacobian, [&](const Drive&, int row) { return slopes[row]; });
  }

 private:
  /// Points of the rows in the axes of the body.
  template <class S>
  using Points = Vector3<S>[DistancePair::kMostHeights];

  template <class S>
  void find_points(const RobotData<S>& data, Points<S>& points) const {
    const bool one_of_many = rows_ < static_cast<int>(core_.points.size());
    for (int row = 0; row < rows_; ++row)
      points[row] = one_of_many ? lowest(data) : core_.points[row].cast<S>();
  }

  template <class S>
  void write_heights(const RobotData<S>& data, const Points<S>& points, S* r) const {
    const Vector3<S> n = half_space_.normal.cast<S>();
    Vector3<S> p = points[0];
    bodies_.for_placements(data, bodies_.first(),
                           [&](const SE3<S>& placement) { p = placement.R * p + placement.p; });
    r[0] = dot(n, p) - S(half_space_.offset + core_.radius);
    for (int row = 1; row < rows_; ++row) {
      Vector3<S> way = points[row] - points[0];
      bodies_.for_placements(data, bodies_.first(),
                             [&](const SE3<S>& placement) { way = placement.R * way; });
      r[row] = r[0] + dot(n, way);
    }
  }

  template <class S>
  Vector3<S> lowest(const RobotData<S>& data) const {
    Vector3<S> up = half_space_.normal.cast<S>();
    // Outermost placement first.
    if (const int root = bodies_.first().root; root >= 0)
      up = transpose_times(data.root[root].R, up);
    if (const int joint = bodies_.first().joint; joint >= 0)
      up = transpose_times(data.placement[joint].R, up);
    Vector3<S> best = core_.points[0].cast<S>();
    S least = dot(up, best);
    for (const Vector3<double>& candidate : core_.points) {
      const S height = dot(up, candidate.cast<S>());
      const auto lower = height < least;
      for (int axis = 0; axis < 3; ++axis)
        best[axis] = select(lower, S(candidate[axis]), best[axis]);
      least = select(lower, height, least);
    }
    return best;
  }

  BodyPair bodies_;
  Core core_;
  HalfSpace half_space_;
  int rows_;
};

template <class Value>
inline constexpr int kLanesOf = std::is_same_v<Value, Lane> ? kLaneWidth : 1;
double lane_of(double a, int) { return a; }
double lane_of(const Lane& a, int lane) { return a[lane]; }
void set_lane(double& a, int, double value) { a = value; }
void set_lane(Lane& a, int lane, double value) { a.set(lane, value); }

template <class V>
Vector3<double> lane_of(const Vector3<V>& a, int lane) {
  return {lane_of(a.x, lane), lane_of(a.y, lane), lane_of(a.z, lane)};
}
template <class S>
SE3<double> lane_of(const SE3<S>& a, int lane) {
  SE3<double> result;
  for (int i = 0; i < 9; ++i) result.R.m[i] = lane_of(value_of(a.R.m[i]), lane);
  for (int i = 0; i < 3; ++i) result.p[i] = lane_of(value_of(a.p[i]), lane);
  return result;
}

/// A number without derivatives.
inline double constant(double a, double) { return a; }
inline Lane constant(const Lane& a, const Lane&) { return a; }
template <class V>
Dual<V> constant(const V& a, const Dual<V>&) {
  return {a, V(0.0)};
}

/// The smallest box along the axes of its body around a core, and a ball around it.
struct Surroundings {
  Vector3<double> middle, half;
  double ball = 0;  ///< radius of the ball about the middle

  explicit Surroundings(const Core& core) {
    Vector3<double> low = core.points[0], high = core.points[0];
    for (const Vector3<double>& point : core.points)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], point[axis]);
        high[axis] = std::max(high[axis], point[axis]);
      }
    middle = 0.5 * (low + high);
    half = 0.5 * (high - low);
    for (const Vector3<double>& point : core.points)
      ball = std::max(ball, std::sqrt(squared_norm(point - middle)));
  }
};

/// Two cores, one of them with more than two points.
///
/// A distance that is only to stay above a margin is rounded (DistanceRounding): solvers can follow
/// the derivatives of bodies with parallel faces then. Rounding costs at most a hundredth of the
/// smaller body's radius. A lower bound replaces the distance of bodies far apart: that of the
/// smaller one's ball from the larger one's box. It does so from the margin plus the radius of the
/// body on, gradually up to twice as far, so that the derivative is continuous.
class TwoCores {
  /// Part of the smaller ball's radius that rounding may add to a margin (ablations: rounded
  /// distances).
  static constexpr double kRounding = 0.01;

 public:
  template <class First, class Second>
  TwoCores(const MultibodySystem& system, const First& first, const Second& second,
           const std::optional<double>& margin)
      : bodies_(system, {system.robot(), first.frame}, {system.robot(), second.frame}),
        first_(bodies_.first(), first),
        second_(bodies_.second(), second),
        around_first_(first_),
        around_second_(second_),
        first_is_ball_(around_first_.ball <= around_second_.ball) {
    if (!margin) return;
    const double reach =
        std::max(0.0, *margin) + ball().ball + (first_is_ball_ ? first_ : second_).radius;
    if (reach > 0) near_to_ = reach;
    const auto radius = [](const Surroundings& body) { return body.ball > 0 ? body.ball : 1; };
    rounding_ = {.length = 0.5 * kRounding * ball().ball,
                 .center = {around_first_.middle, around_second_.middle},
                 .radius = {radius(around_first_), radius(around_second_)}};
  }

  RowBlock block() const { return {1, bodies_.columns()}; }

  template <class S>
  void evaluate(const MultibodySystem::Data<S>& data, S* r) const {
    r[0] = blend(data.robot).distance;
  }

  template <class S>
  void differentiate(MultibodySystem::Data<S>& data, S* r, S* jacobian) const {
    const Blend<S> blended = blend(data.robot);
    r[0] = blended.distance;
    Force<S> first = Force<S>::zero(), second = Force<S>::zero();
    for (const Nearest<S>* part : {&blended.near, &blended.bound}) {
      first += bodies_.slope(data.robot, bodies_.first(), part->first, part->along);
      second += bodies_.slope(data.robot, bodies_.second(), part->second, -part->along);
    }
    bodies_.write(1, data, jacobian,
                  [&](const Drive& drive, int) { return drive.second ? second : first; });
  }

 private:
  /// Nearest points, each in the axes of its body; moving the first body by d changes the distance
  /// by along·d.
  template <class S>
  struct Nearest {
    Vector3<S> first = Vector3<S>::zero(), second = Vector3<S>::zero(), along = Vector3<S>::zero();
    S distance = S(0.0);
  };
  /// The distance of the surfaces, whose derivative is the sum of two.
  template <class S>
  struct Blend {
    Nearest<S> near, bound;
    S distance;
  };
  template <class S>
  using ValueOf = std::remove_cvref_t<decltype(value_of(S(0.0)))>;

  const Surroundings& ball() const { return first_is_ball_ ? around_first_ : around_second_; }

  template <class S>
  SE3<S> placement(const RobotData<S>& data, const Carrier& body) const {
    SE3<S> result = SE3<S>::identity();
    bodies_.for_placements(data, body, [&](const SE3<S>& outer) { result = outer * result; });
    return result;
  }

  template <class S>
  Blend<S> blend(const RobotData<S>& data) const {
    const SE3<S> first = placement(data, bodies_.first()),
                 second = placement(data, bodies_.second());
    const S radii(first_.radius + second_.radius);
    Blend<S> result;
    if (std::isinf(near_to_)) {
      result.near = nearest(first, second, [](int) { return true; });
      result.distance = result.near.distance - radii;
      return result;
    }
    result.bound = lower_bound(first, second);
    const S bound = result.bound.distance - radii;
    const ValueOf<S> values = value_of(bound);
    const auto is_near = bound <= S(near_to_);
    if (any(bound < S(2 * near_to_)))
      result.near =
          nearest(first, second, [&](int lane) { return lane_of(values, lane) < 2 * near_to_; });
    const S distance = result.near.distance - radii;
    // A share that falls from 1 to 0.
    const S t = max(S(0.0), min(S(1.0), S(2.0) - S(1 / near_to_) * bound));
    const S share = select(is_near, S(1.0), t * t * (S(3.0) - S(2.0) * t));
    const S of_bound = select(
        is_near, S(0.0), S(1.0) - share - S(6 / near_to_) * t * (S(1.0) - t) * (distance - bound));
    result.distance = select(is_near, distance, bound + share * (distance - bound));
    for (int axis = 0; axis < 3; ++axis) {
      result.near.along[axis] = share * result.near.along[axis];
      result.bound.along[axis] = select(is_near, S(0.0), of_bound * result.bound.along[axis]);
    }
    return result;
  }

  /// Distance of the ball's middle from the box, less the ball's radius.
  template <class S>
  Nearest<S> lower_bound(const SE3<S>& first, const SE3<S>& second) const {
    const SE3<S>&of_ball = first_is_ball_ ? first : second,
          &of_box = first_is_ball_ ? second : first;
    const Surroundings& box = first_is_ball_ ? around_second_ : around_first_;
    const Vector3<S> middle = of_ball.R * ball().middle + of_ball.p;
    const Vector3<S> local = transpose_times(of_box.R, middle - of_box.p);
    Vector3<S> nearest;
    for (int axis = 0; axis < 3; ++axis)
      nearest[axis] = min(max(local[axis], S(box.middle[axis] - box.half[axis])),
                          S(box.middle[axis] + box.half[axis]));
    const Vector3<S> gap = of_box.R * (local - nearest);
    const S length = sqrt(squared_norm(gap));
    const Vector3<S> away = (S(1.0) / length) * gap;
    const Vector3<S> center = ball().middle.template cast<S>();
    const S distance = length - S(ball().ball);
    if (first_is_ball_) return {center, nearest, away, distance};
    return {nearest, center, -away, distance};
  }

  /// The distance of the cores in some lanes. Nearest pairs differ by lane. They depend on values
  /// alone: the derivatives of the distance are those with fixed pairs.
  template <class S, class Asks>
  Nearest<S> nearest(const SE3<S>& first, const SE3<S>& second, Asks asks) const {
    using Value = ValueOf<S>;
    constexpr int kLanes = kLanesOf<Value>;
    NearestPairs pairs[kLanes];
    PairCorners<S> corners;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (asks(lane))
        pairs[lane] =
            nearest_pairs(first_.points, second_.points,
                          inverse(lane_of(first, lane)) * lane_of(second, lane), rounding_);
      corners.count = std::max(corners.count, pairs[lane].count);
    }
    const auto gather = [&](auto number) {
      Value values;
      for (int lane = 0; lane < kLanes; ++lane) set_lane(values, lane, number(pairs[lane]));
      return constant(values, S(0.0));
    };
    corners.gap = gather([](const NearestPairs& p) { return p.gap; });
    corners.overlap = gather([](const NearestPairs& p) -> double { return p.overlap; });
    corners.reversed = gather([](const NearestPairs& p) -> double { return p.reversed; });
    for (int i = 0; i < std::max(3, corners.count); ++i) {
      corners.present[i] = gather([&](const NearestPairs& p) -> double { return i < p.count; });
      for (int axis = 0; axis < 3; ++axis) {
        corners.own[0][i][axis] =
            gather([&](const NearestPairs& p) { return first_.points[p.first[i]][axis]; });
        corners.own[1][i][axis] =
            gather([&](const NearestPairs& p) { return second_.points[p.second[i]][axis]; });
      }
      corners.m[i] =
          (first.R * corners.own[0][i] + first.p) - (second.R * corners.own[1][i] + second.p);
    }
    const PolytopeDistance<S> near = polytope_distance(corners, rounding_);
    return {near.point[0], near.point[1], near.along, near.distance};
  }

  BodyPair bodies_;
  Core first_, second_;
  Surroundings around_first_, around_second_;
  bool first_is_ball_;
  double near_to_ = std::numeric_limits<double>::infinity();  ///< m
  DistanceRounding rounding_;
};

using AnyPair = std::variant<TwoCapsules, Heights, TwoCores>;

/// Chooses the class of a pair by its shapes.
struct MakePair {
  const MultibodySystem& system;
  const std::optional<double>& margin;

  AnyPair operator()(const Capsule& first, const Capsule& second) const {
    return TwoCapsules(system, first, second);
  }
  template <class First>
  AnyPair operator()(const First& first, const HalfSpace& second) const {
    return Heights(system, first, second);
  }
  template <class First, class Second>
  AnyPair operator()(const First& first, const Second& second) const {
    return TwoCores(system, first, second, margin);
  }
};

RowBlock block_of(const AnyPair& pair) {
  return std::visit([](const auto& known) { return known.block(); }, pair);
}

class Distance : public ResidualBase<Distance> {
 public:
  Distance(SystemPointer system, std::vector<AnyPair> pairs)
      : ResidualBase(blocks_of(pairs), 0, false),
        system_(std::move(system)),
        pairs_(std::move(pairs)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      std::visit([&](const auto& pair) { pair.evaluate(multibody_data(in), r); }, pairs_[i]);
      r += blocks()[i].rows;
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      std::visit([&](const auto& pair) { pair.differentiate(multibody_data(in), r, jacobian); },
                 pairs_[i]);
      r += blocks()[i].rows;
      jacobian += blocks()[i].rows * blocks()[i].columns.size();
    }
  }

 private:
  static std::vector<RowBlock> blocks_of(const std::vector<AnyPair>& pairs) {
    std::vector<RowBlock> blocks;
    for (const AnyPair& pair : pairs) blocks.push_back(block_of(pair));
    return blocks;
  }
  SystemPointer system_;
  std::vector<AnyPair> pairs_;
};

}  // namespace

int DistancePair::rows() const {
  if (!std::holds_alternative<HalfSpace>(second)) return 1;
  if (const auto* polytope = std::get_if<Polytope>(&first)) {
    const int vertices = static_cast<int>(polytope->vertices.size());
    return vertices <= kMostHeights ? vertices : 1;
  }
  const Capsule& capsule = std::get<Capsule>(first);
  return squared_norm(capsule.to - capsule.from) > 0 ? 2 : 1;
}

std::shared_ptr<const Residual> distance_residual(const SystemPointer& system,
                                                  const std::vector<DistancePair>& pairs) {
  std::vector<AnyPair> made;
  for (const DistancePair& pair : pairs)
    made.push_back(std::visit(MakePair{*system, pair.margin}, pair.first, pair.second));
  return std::make_shared<Distance>(system, std::move(made));
}

}  // namespace conddp
