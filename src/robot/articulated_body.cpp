#include "robot/articulated_body.hpp"

#include "robot/kinematics.hpp"
#include "robot/wrenches.hpp"

namespace conddp {
namespace {

/// A symmetric 6x6 matrix, lower triangle by rows.
template <class S>
struct Articulated {
  S m[21];

  static constexpr int at(int row, int col) {
    return row >= col ? row * (row + 1) / 2 + col : col * (col + 1) / 2 + row;
  }
  static Articulated from(const Inertia<S>& y) {
    Articulated a;
    const Matrix3<S> c = skew(y.moment);
    const Symmetric3<S>& j = y.rotational;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        if (i >= k) a.m[at(i, k)] = i == k ? y.mass : S(0.0);
        a.m[at(i + 3, k)] = c(i, k);
      }
    a.m[at(3, 3)] = j.xx;
    a.m[at(4, 3)] = j.xy;
    a.m[at(5, 3)] = j.xz;
    a.m[at(4, 4)] = j.yy;
    a.m[at(5, 4)] = j.yz;
    a.m[at(5, 5)] = j.zz;
    return a;
  }
  Force<S> operator*(const Motion<S>& x) const {
    Force<S> y = Force<S>::zero();
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k) y[i] += m[at(i, k)] * x[k];
    return y;
  }
  void subtract_outer(const Force<S>& u, const S& factor) {
    for (int i = 0; i < 6; ++i) {
      const S fu = factor * u[i];
      for (int k = 0; k <= i; ++k) m[at(i, k)] -= fu * u[k];
    }
  }
  Articulated& operator+=(const Articulated& b) {
    for (int i = 0; i < 21; ++i) m[i] += b.m[i];
    return *this;
  }
  /// Solves this·x = f by L D Lᵀ.
  Motion<S> solve(const Force<S>& f) const {
    S l[21], inverse[6];
    for (int j = 0; j < 6; ++j) {
      S d = m[at(j, j)];
      for (int k = 0; k < j; ++k) d -= l[at(j, k)] * l[at(j, k)] * l[at(k, k)];
      l[at(j, j)] = d;
      inverse[j] = S(1.0) / d;
      for (int i = j + 1; i < 6; ++i) {
        S sum = m[at(i, j)];
        for (int k = 0; k < j; ++k) sum -= l[at(i, k)] * l[at(j, k)] * l[at(k, k)];
        l[at(i, j)] = sum * inverse[j];
      }
    }
    Motion<S> x{f.linear, f.angular};
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < i; ++k) x[i] -= l[at(i, k)] * x[k];
    for (int i = 5; i >= 0; --i) {
      x[i] = x[i] * inverse[i];
      for (int k = i + 1; k < 6; ++k) x[i] -= l[at(k, i)] * x[k];
    }
    return x;
  }
};

}  // namespace

template <class S>
void articulated_body_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                               RobotData<S>& data) {
  update_placements(model, q, data);
  update_velocities(model, v, data);
  update_composite_inertias(model, data);
  const int n = model.joint_count();
  std::vector<Articulated<S>> inertia(n);
  std::vector<Force<S>> column(n);
  std::vector<S> inverse(n), residual(n);
  for (int i = 0; i < n; ++i) {
    inertia[i] = Articulated<S>::from(data.body[i]);
    data.momentum[i] = data.body[i] * data.v[i];
    data.force[i] = cross(data.v[i], data.momentum[i]);
  }
  subtract_external_wrenches(model, data);
  for (int i = n - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) continue;
    column[i] = inertia[i] * data.axis[i];
    inverse[i] = S(1.0) / (dot(data.axis[i], column[i]) + S(joint.rotor_inertia));
    residual[i] = (tau == nullptr ? S(0.0) : tau[joint.v]) - dot(data.axis[i], data.force[i]);
    if (joint.parent < 0) continue;
    const Motion<S> drift = v[joint.v] * data.psi_dot[i];
    inertia[i].subtract_outer(column[i], inverse[i]);
    const S push = residual[i] * inverse[i];
    data.force[joint.parent] += data.force[i] + inertia[i] * drift +
                                Force<S>{push * column[i].linear, push * column[i].angular};
    inertia[joint.parent] += inertia[i];
  }
  for (int i = 0; i < n; ++i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) {
      Force<S> f = Force<S>::zero() - data.force[i];
      if (tau != nullptr)
        for (int k = 0; k < 6; ++k) f[k] += tau[joint.v + k];
      data.a[i] = inertia[i].solve(f);
      for (int k = 0; k < 3; ++k) {
        data.acceleration[joint.v + k] = data.a[i].linear[k] + data.gravity(model, i)[k];
        data.acceleration[joint.v + 3 + k] = data.a[i].angular[k];
      }
      continue;
    }
    data.a[i] = joint.parent < 0 ? Motion<S>{-model.gravity.cast<S>(), Vector3<S>::zero()}
                                 : data.a[joint.parent] + v[joint.v] * data.psi_dot[i];
    const S acceleration = (residual[i] - dot(data.a[i], column[i])) * inverse[i];
    data.acceleration[joint.v] = acceleration;
    data.a[i] += acceleration * data.axis[i];
  }
}

#define CONDDP_INSTANTIATE(S)                                                              \
  template void articulated_body_dynamics(const RobotModel&, const S*, const S*, const S*, \
                                          RobotData<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
