#include "systems/contact/candidate_geometry.hpp"

#include <algorithm>
#include <array>

namespace conddp {
namespace {

/// Returns the body of a frame and sets the frame's placement on it.
int locate(const RobotModel& model, int frame, const SE3<double>& local, SE3<double>& placement) {
  placement = frame < 0 ? local : model.frames[frame].placement * local;
  return frame < 0 ? -1 : model.frames[frame].joint;
}

SE3<double> translation(const Vector3<double>& p) { return {Matrix3<double>::identity(), p}; }

bool moves(const RobotModel& model, int joint, int body) {
  while (body > joint) body = model.joints[body].parent;
  return body == joint;
}

int count_tangents(const ContactCandidate& candidate, bool planar) {
  if (candidate.friction == 0) return 0;
  return planar ? 1 : 2;
}

/// Two unit vectors that complete n to a right-handed triad, smooth except where n.z changes sign
/// (Duff et al., Building an Orthonormal Basis, Revisited, 2017).
template <class S>
void complete_triad(const Vector3<S>& n, Vector3<S>& first, Vector3<S>& second) {
  const S sign = select(n.z < S(0.0), S(-1.0), S(1.0));
  const S a = S(-1.0) / (sign + n.z);
  const S b = n.x * n.y * a;
  first = {S(1.0) + sign * n.x * n.x * a, sign * b, -(sign * n.x)};
  second = {b, sign + n.y * n.y * a, -n.y};
}

/// The signed distance of a point from a box about the origin, and its gradient.
template <class S>
S box_distance(const Vector3<S>& p, const Vector3<double>& half, Vector3<S>& gradient) {
  Vector3<S> sign, q, outside;
  for (int i = 0; i < 3; ++i) {
    sign[i] = select(p[i] < S(0.0), S(-1.0), S(1.0));
    q[i] = sign[i] * p[i] - S(half[i]);
    outside[i] = max(q[i], S(0.0));
  }
  const S square = squared_norm(outside);
  const auto is_outside = square > S(0.0);
  const S distance = sqrt(select(is_outside, square, S(1.0)));
  const S deepest = max(q.x, max(q.y, q.z));
  S taken(0.0);  // a single face if two are equally near
  for (int i = 0; i < 3; ++i) {
    const S nearest = select(q[i] < deepest, S(0.0), S(1.0) - taken);
    taken = taken + nearest;
    gradient[i] = sign[i] * select(is_outside, outside[i] / distance, nearest);
  }
  return select(is_outside, distance, deepest);
}

template <class S>
Vector3<Dual<S>> along(const Vector3<S>& value, const Vector3<S>& slope) {
  return {{value.x, slope.x}, {value.y, slope.y}, {value.z, slope.z}};
}

}  // namespace

CandidateGeometry::CandidateGeometry(const RobotModel& model, const ContactCandidate& candidate,
                                     const std::optional<Vector3<double>>& plane)
    : radius_(candidate.sphere.radius),
      plane_(plane),
      tangents_(count_tangents(candidate, plane.has_value())) {
  first_joint_ =
      locate(model, candidate.sphere.frame, translation(candidate.sphere.center), first_);
  place_second(model, candidate);
  add_drives(model);
  if (first_joint_ >= 0) first_root_ = model.root[first_joint_];
  if (second_joint_ >= 0) second_root_ = model.root[second_joint_];
}

/// Sets the shape opposite to the sphere.
void CandidateGeometry::place_second(const RobotModel& model, const ContactCandidate& candidate) {
  if (const auto* solid = std::get_if<ContactHalfSpace>(&candidate.against)) {
    shape_ = Shape::half_space;
    second_joint_ = locate(model, solid->frame, SE3<double>::identity(), second_);
    normal_ = solid->normal;
    offset_ = solid->offset;
  } else if (const auto* sphere = std::get_if<ContactSphere>(&candidate.against)) {
    shape_ = Shape::sphere;
    second_joint_ = locate(model, sphere->frame, translation(sphere->center), second_);
    second_radius_ = sphere->radius;
  } else {
    const auto& box = std::get<ContactBox>(candidate.against);
    shape_ = Shape::box;
    second_joint_ = locate(model, box.frame, box.placement, second_);
    half_sizes_ = box.half_sizes;
  }
}

void CandidateGeometry::add_drives(const RobotModel& model) {
  for (int j = 0; j < model.joint_count(); ++j) {
    const bool first = moves(model, j, first_joint_), second = moves(model, j, second_joint_);
    if (!first && !second) continue;
    const Joint& joint = model.joints[j];
    for (int d = 0; d < joint.nv(); ++d) {
      columns_.push_back(joint.v + d);
      roots_.push_back(model.root[j]);
      drives_.push_back({j, joint.type == JointType::floating ? d : -1, first, second});
    }
  }
}

template <class S>
CandidateRows<S> CandidateGeometry::create_rows() const {
  CandidateRows<S> out{};
  const std::size_t k = columns_.size(), size = (1 + tangents_) * k;
  out.rows.assign(size, S(0.0));
  out.slopes.assign(size * k, S(0.0));
  out.axes.assign(k, Motion<S>::zero());
  return out;
}

template <class S>
CandidateGeometry::Pose<S> CandidateGeometry::pose(const RobotData<S>& data, int joint, int root,
                                                   const SE3<double>& placement) const {
  if (joint < 0) return {placement.p.cast<S>(), placement.R.cast<S>()};
  SE3<S> m = data.placement[joint] * placement;
  if (root >= 0) m = data.root[root] * m;
  return {m.p, m.R};
}

template <class S>
void CandidateGeometry::update_axes(const RobotData<S>& data, CandidateRows<S>& out) const {
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    Motion<S>& axis = out.axes[j];
    axis = data.axis[drives_[j].joint];
    if (const int d = drives_[j].direction; d >= 0) {
      axis = Motion<S>::zero();
      (d < 3 ? axis.linear : axis.angular)[d % 3] = S(1.0);
    }
    if (roots_[j] >= 0) axis = act(data.root[roots_[j]], axis);
  }
}

/// A floating joint moves its own directions as well.
bool CandidateGeometry::carries(const Drive& i, const Drive& j) const {
  const bool before = i.joint < j.joint || (i.joint == j.joint && i.direction >= 0);
  return before && ((i.first && j.first) || (i.second && j.second));
}

template <class S>
CandidateGeometry::Touch<S> CandidateGeometry::touch(const Vector3<S>& center,
                                                     const Pose<S>& against) const {
  Touch<S> t{};
  Vector3<S>& n = t.directions[0];
  const Vector3<S> apart = center - against.p;
  if (shape_ == Shape::half_space) {
    n = against.R * normal_.cast<S>();
    t.gap = dot(n, apart) - S(offset_ + radius_);
  } else if (shape_ == Shape::sphere) {
    const S distance = sqrt(squared_norm(apart));
    n = (S(1.0) / distance) * apart;
    t.gap = distance - S(radius_ + second_radius_);
  } else {
    Vector3<S> gradient;
    t.gap = box_distance(transpose_times(against.R, apart), half_sizes_, gradient) - S(radius_);
    n = against.R * gradient;
  }
  if (plane_)
    t.directions[1] = cross(plane_->cast<S>(), n);
  else
    complete_triad(n, t.directions[1], t.directions[2]);
  return t;
}

template <class S>
void CandidateGeometry::evaluate(const RobotData<S>& data, CandidateRows<S>& out) const {
  const Pose<S> first = pose(data, first_joint_, first_root_, first_),
                second = pose(data, second_joint_, second_root_, second_);
  update_axes(data, out);
  const Touch<S> t = touch(first.p, second);
  out.gap = t.gap;
  out.point = first.p - S(radius_) * t.directions[0];
  const Vector3<S> opposite = first.p - (S(radius_) + t.gap) * t.directions[0];
  const int k = static_cast<int>(drives_.size());
  for (int r = 0; r <= tangents_; ++r) out.directions[r] = t.directions[r];
  for (int j = 0; j < k; ++j) {
    const Motion<S>& axis = out.axes[j];
    Vector3<S> velocity = Vector3<S>::zero();
    if (drives_[j].first) velocity += axis.linear + cross(axis.angular, out.point);
    if (drives_[j].second) velocity -= axis.linear + cross(axis.angular, opposite);
    for (int r = 0; r <= tangents_; ++r) out.rows[r * k + j] = dot(t.directions[r], velocity);
  }
}

/// A first-order motion along a drive, applied only to geometry that moves with it.
template <class S>
struct CandidateGeometry::Shift {
  const Motion<S>& axis;

  Vector3<Dual<S>> point(const Vector3<S>& p, bool moved) const {
    return along(p, moved ? axis.linear + cross(axis.angular, p) : Vector3<S>::zero());
  }
  Vector3<Dual<S>> direction(const Vector3<S>& a, bool moved) const {
    return along(a, moved ? cross(axis.angular, a) : Vector3<S>::zero());
  }
  Pose<Dual<S>> pose(const Pose<S>& body, bool moved) const {
    Pose<Dual<S>> shifted{point(body.p, moved), {}};
    for (int c = 0; c < 3; ++c) {
      const Vector3<Dual<S>> column = direction(body.R.column(c), moved);
      for (int r = 0; r < 3; ++r) shifted.R(r, c) = column[r];
    }
    return shifted;
  }
  Motion<Dual<S>> twist(const Motion<S>& other, bool moved) const {
    const Motion<S> change = moved ? cross(axis, other) : Motion<S>::zero();
    return {along(other.linear, change.linear), along(other.angular, change.angular)};
  }
};

template <class S>
void CandidateGeometry::differentiate(const RobotData<S>& data, CandidateRows<S>& out) const {
  using D = Dual<S>;
  evaluate(data, out);
  const Pose<S> first = pose(data, first_joint_, first_root_, first_),
                second = pose(data, second_joint_, second_root_, second_);
  const int k = static_cast<int>(drives_.size());
  for (int i = 0; i < k; ++i) {
    // Drive i moves points, axes of the body, and axes of the joints after it.
    const Shift<S> shift{out.axes[i]};
    const Vector3<D> center = shift.point(first.p, drives_[i].first);
    const Touch<D> t = touch(center, shift.pose(second, drives_[i].second));
    const Vector3<D> point = center - D(radius_) * t.directions[0];
    const Vector3<D> opposite = center - (D(radius_) + t.gap) * t.directions[0];
    for (int j = 0; j < k; ++j) {
      const Motion<D> axis = shift.twist(out.axes[j], carries(drives_[i], drives_[j]));
      Vector3<D> velocity = Vector3<D>::zero();
      if (drives_[j].first) velocity += axis.linear + cross(axis.angular, point);
      if (drives_[j].second) velocity -= axis.linear + cross(axis.angular, opposite);
      for (int r = 0; r <= tangents_; ++r)
        out.slopes[(i * (1 + tangents_) + r) * k + j] = dot(t.directions[r], velocity).d;
    }
  }
}

#define CONDDP_INSTANTIATE(S)                                                              \
  template CandidateRows<S> CandidateGeometry::create_rows<S>() const;                     \
  template void CandidateGeometry::evaluate(const RobotData<S>&, CandidateRows<S>&) const; \
  template void CandidateGeometry::differentiate(const RobotData<S>&, CandidateRows<S>&) const;
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
