#include "analysis/contact/contact_mechanics.hpp"

#include <cmath>
#include <utility>

#include "robot/dynamics.hpp"
#include "robot/frames.hpp"
#include "spatial/se3.hpp"

namespace conddp {
namespace {

/// sin θ/θ, (1 − cos θ)/θ² and (θ − sin θ)/θ³ as functions of t = θ².
template <class S>
struct Screw {
  S sine, versine, rest;

  explicit Screw(const S& t) : sine(0.0), versine(0.0), rest(0.0) {
    if (t < S(1.0)) {
      // Σ (−t)^k / (2k + n)!, backward: after 12 terms the rest is below rounding.
      for (int k = 11; k >= 0; --k) {
        sine = (S(1.0) - t * sine * (1.0 / ((2 * k + 2) * (2 * k + 3))));
        versine = (S(1.0) - t * versine * (1.0 / ((2 * k + 3) * (2 * k + 4))));
        rest = (S(1.0) - t * rest * (1.0 / ((2 * k + 4) * (2 * k + 5))));
      }
      versine = versine * 0.5;
      rest = rest * (1.0 / 6);
      return;
    }
    const S angle = sqrt(t);
    S s, c;
    sincos(angle, s, c);
    sine = s / angle;
    versine = (S(1.0) - c) / t;
    rest = (S(1.0) - sine) / t;
  }
};

/// Hamilton product of quaternions (x, y, z, w).
template <class S>
void multiply(const double* a, const S* b, S* out) {
  out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
  out[1] = a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2];
  out[2] = a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0];
  out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
}

template <class S>
void move_base(const double* q, const S* d, S* moved) {
  const Vector3<S> v{d[0], d[1], d[2]}, w{d[3], d[4], d[5]};
  const Screw<S> whole(squared_norm(w)), half(squared_norm(w) * 0.25);
  const Vector3<S> across = cross(w, v);
  const Vector3<S> way = v + whole.versine * across + whole.rest * cross(w, across);
  const Matrix3<double> R = rotation_matrix(Quaternion<double>{q[3], q[4], q[5], q[6]});
  const Vector3<S> gone = R.cast<S>() * way;
  for (int i = 0; i < 3; ++i) moved[i] = S(q[i]) + gone[i];
  const S turn[4] = {half.sine * w.x * 0.5, half.sine * w.y * 0.5, half.sine * w.z * 0.5,
                     S(1.0) - half.versine * squared_norm(w) * 0.25};
  multiply(q + 3, turn, moved + 3);
}

/// Reference point and axes of the body that a candidate may touch.
struct Other {
  int frame;
  SE3<double> local;
};
Other other_of(const ContactCandidate& candidate) {
  if (const auto* solid = std::get_if<ContactHalfSpace>(&candidate.against))
    return {solid->frame, SE3<double>::identity()};
  if (const auto* sphere = std::get_if<ContactSphere>(&candidate.against))
    return {sphere->frame, {Matrix3<double>::identity(), sphere->center}};
  const auto& box = std::get<ContactBox>(candidate.against);
  return {box.frame, box.placement};
}

template <class S>
S length(const Vector3<S>& a) {
  return sqrt(squared_norm(a));
}
template <>
double length(const Vector3<double>& a) {
  return std::sqrt(squared_norm(a));
}

/// Signed distance from a box about the origin: outside to its nearest point, inside to its nearest
/// face.
template <class S>
S box_gap(const Vector3<S>& p, const Vector3<double>& half, Vector3<S>& normal) {
  Vector3<S> off = p;
  bool outside = false;
  int face = 0;
  S depth = S(0.0);
  for (int i = 0; i < 3; ++i) {
    const S over = abs(p[i]) - S(half[i]);
    const bool positive = p[i] > S(0.0);
    if (i == 0 || over > depth) {
      face = i;
      depth = over;
    }
    if (over > S(0.0)) {
      outside = true;
      off[i] = positive ? over : -over;
    } else {
      off[i] = S(0.0);
    }
  }
  if (outside) {
    const S distance = length(off);
    normal = (S(1.0) / distance) * off;
    return distance;
  }
  normal = Vector3<S>::zero();
  normal[face] = p[face] > S(0.0) ? S(1.0) : S(-1.0);
  return depth;
}

}  // namespace

ContactPlant contact_plant(const MultibodySystem& robot, ImplicitContacts contacts) {
  ContactPlant plant;
  plant.robot = robot.shared_robot();
  plant.B = robot.actuation().B;
  plant.contacts = std::move(contacts);
  const PassiveForces& passive = robot.passive();
  for (const Joint& joint : plant.robot->joints) {
    if (passive.damping) plant.damping.insert(plant.damping.end(), joint.nv(), joint.damping);
    if (passive.friction)
      plant.smooth_friction.insert(plant.smooth_friction.end(), joint.nv(), joint.friction);
  }
  plant.friction_velocity = passive.friction_velocity;
  return plant;
}

std::vector<double> ContactPlant::applied(const double* u) const {
  std::vector<double> force(nv(), 0.0);
  for (int j = 0; j < nu(); ++j)
    for (int i = 0; i < nv(); ++i) force[i] += B[j * nv() + i] * u[j];
  return force;
}

int tangent_count(const ImplicitContacts& contacts, const ContactCandidate& candidate) {
  if (candidate.friction == 0) return 0;
  return contacts.plane ? 1 : 2;
}

template <class S>
ContactMechanics<S>::ContactMechanics(const ContactPlant& plant)
    : plant_(plant), data_(*plant.robot), instants_(plant.contacts.candidates.size()) {}

template <class S>
typename ContactMechanics<S>::Body ContactMechanics<S>::body(int frame, const SE3<double>& local) {
  const RobotModel& robot = *plant_.robot;
  const int nv = robot.nv;
  Body b;
  b.rows.assign(6 * nv, S(0.0));
  const SE3<S> offset{local.R.template cast<S>(), local.p.template cast<S>()};
  b.placement = offset;
  b.origin = Vector3<S>::zero();
  if (frame < 0) return b;
  const SE3<S> at = frame_placement(robot, data_, frame);
  b.placement = at * offset;
  b.origin = at.p;
  const std::vector<int> columns = support(robot, robot.frames[frame].joint);
  std::vector<S> jacobian(6 * columns.size(), S(0.0));
  frame_jacobian(robot, data_, frame, FrameAxes::world_aligned, jacobian.data());
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (int r = 0; r < 6; ++r) b.rows[r * nv + columns[c]] = jacobian[6 * c + r];
  return b;
}

template <class S>
void ContactMechanics<S>::touch(const ContactCandidate& candidate, const Vector3<S>& center,
                                const SE3<S>& other, ContactInstant<S>& out) const {
  Vector3<S>& n = out.directions[0];
  const S radius(candidate.sphere.radius);
  const Vector3<S> apart = center - other.p;
  if (const auto* solid = std::get_if<ContactHalfSpace>(&candidate.against)) {
    n = other.R * solid->normal.cast<S>();
    out.gap = dot(n, apart) - S(solid->offset) - radius;
  } else if (const auto* sphere = std::get_if<ContactSphere>(&candidate.against)) {
    const S distance = length(apart);
    n = (S(1.0) / distance) * apart;
    out.gap = distance - S(sphere->radius) - radius;
  } else {
    Vector3<S> local;
    out.gap = box_gap(transpose_times(other.R, apart),
                      std::get<ContactBox>(candidate.against).half_sizes, local) -
              radius;
    n = other.R * local;
  }
}

/// Adds the tangents to the normal.
template <class S>
void ContactMechanics<S>::complete(ContactInstant<S>& out) const {
  const Vector3<S>& n = out.directions[0];
  if (plant_.contacts.plane) {
    out.directions[1] = cross(plant_.contacts.plane->template cast<S>(), n);
    out.directions[2] = Vector3<S>::zero();
    return;
  }
  const double sign = n.z < S(0.0) ? -1 : 1;
  const S scale = S(-1.0) / (S(sign) + n.z), mixed = n.x * n.y * scale;
  out.directions[1] = {S(1.0) + S(sign) * n.x * n.x * scale, S(sign) * mixed, S(-sign) * n.x};
  out.directions[2] = {mixed, S(sign) + n.y * n.y * scale, -n.y};
}

template <class S>
const std::vector<ContactInstant<S>>& ContactMechanics<S>::look(const S* q) {
  update_placements(*plant_.robot, q, data_);
  const int nv = plant_.nv();
  for (std::size_t i = 0; i < instants_.size(); ++i) {
    const ContactCandidate& candidate = plant_.contacts.candidates[i];
    ContactInstant<S>& out = instants_[i];
    const Body first =
        body(candidate.sphere.frame, {Matrix3<double>::identity(), candidate.sphere.center});
    const Other place = other_of(candidate);
    const Body second = body(place.frame, place.local);
    touch(candidate, first.placement.p, second.placement, out);
    complete(out);
    out.point = first.placement.p - S(candidate.sphere.radius) * out.directions[0];
    const Vector3<S> opposite = out.point - out.gap * out.directions[0];
    const Vector3<S> arm = out.point - first.origin, arm2 = opposite - second.origin;
    out.rows.assign(3 * nv, S(0.0));
    const int rows = 1 + tangent_count(plant_.contacts, candidate);
    for (int c = 0; c < nv; ++c) {
      const auto velocity = [&](const Body& b, const Vector3<S>& r) {
        const Vector3<S> linear{b.rows[c], b.rows[nv + c], b.rows[2 * nv + c]};
        const Vector3<S> angular{b.rows[3 * nv + c], b.rows[4 * nv + c], b.rows[5 * nv + c]};
        return linear + cross(angular, r);
      };
      const Vector3<S> relative = velocity(first, arm) - velocity(second, arm2);
      for (int r = 0; r < rows; ++r) out.rows[r * nv + c] = dot(out.directions[r], relative);
    }
  }
  return instants_;
}

template <class S>
const std::vector<S>& ContactMechanics<S>::load(const S* q, const S* v, const S* a) {
  inverse_dynamics(*plant_.robot, q, v, a, data_);
  load_.assign(data_.tau.begin(), data_.tau.end());
  for (int i = 0; i < plant_.nv(); ++i) load_[i] = load_[i] + resistance(i, v[i]);
  return load_;
}

template <class S>
S ContactMechanics<S>::resistance(int i, const S& v) const {
  S force(0.0);
  if (!plant_.damping.empty()) force = S(plant_.damping[i]) * v;
  if (plant_.smooth_friction.empty() || plant_.smooth_friction[i] == 0) return force;
  // Beyond 20, tanh is ±1 to the last digit; clamping keeps exp finite.
  const S x = max(S(-20.0), min(S(20.0), v * (1 / plant_.friction_velocity)));
  return force + S(plant_.smooth_friction[i]) * (S(1.0) - S(2.0) / (exp(x + x) + S(1.0)));
}

template <class S>
const std::vector<S>& ContactMechanics<S>::kinetic_slope(const S* q, const S* v) {
  const RobotModel& robot = *plant_.robot;
  update_placements(robot, q, data_);
  update_velocities(robot, v, data_);
  update_composite_inertias(robot, data_);
  std::vector<Force<S>> momentum;
  for (int j = 0; j < robot.joint_count(); ++j) momentum.push_back(data_.body[j] * data_.v[j]);
  slope_.assign(robot.nv, S(0.0));
  for (int j = robot.joint_count() - 1; j >= 0; --j) {
    slope_[robot.joints[j].v] = dot(data_.psi_dot[j], momentum[j]);
    if (robot.joints[j].parent >= 0) momentum[robot.joints[j].parent] += momentum[j];
  }
  return slope_;
}

template class ContactMechanics<double>;
template class ContactMechanics<Dual<double>>;

template <class S>
void move_configuration(const RobotModel& robot, const double* q, const S* d, S* moved) {
  for (const Joint& joint : robot.joints) {
    if (joint.type == JointType::floating)
      move_base(q + joint.q, d + joint.v, moved + joint.q);
    else
      moved[joint.q] = S(q[joint.q]) + d[joint.v];
  }
}

void configuration_difference(const RobotModel& robot, const double* q, const double* to,
                              double* d) {
  for (const Joint& joint : robot.joints) {
    if (joint.type != JointType::floating) {
      d[joint.v] = to[joint.q] - q[joint.q];
      continue;
    }
    const auto pose = [&](const double* at) {
      return Pose<double>{{at[0], at[1], at[2]}, {at[3], at[4], at[5], at[6]}};
    };
    const Motion<double> screw = difference_se3(pose(q + joint.q), pose(to + joint.q));
    for (int i = 0; i < 6; ++i) d[joint.v + i] = screw[i];
  }
}

template void move_configuration(const RobotModel&, const double*, const double*, double*);
template void move_configuration(const RobotModel&, const double*, const Dual<double>*,
                                 Dual<double>*);

}  // namespace conddp
