#include "analysis/contact/rigid_step.hpp"

#include <cmath>

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

}  // namespace

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
