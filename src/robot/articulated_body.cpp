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
  /// Computes the factor L, with D on its diagonal, and D⁻¹.
  void factorize(S* l, S* inverse) const {
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
  }
  /// Solves this·x = f by L D Lᵀ.
  Motion<S> solve(const Force<S>& f) const {
    S l[21], inverse[6];
    factorize(l, inverse);
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

/// Intermediate results of the passes, per joint.
template <class S>
struct Passes {
  explicit Passes(int joints)
      : inertia(joints), column(joints), inverse(joints), residual(joints) {}

  std::vector<Articulated<S>> inertia;
  std::vector<Force<S>> column;      ///< inertia times axis
  std::vector<S> inverse, residual;  ///< of the pivot; torque available for acceleration
};

/// Backward pass, from the leaves to the roots: articulated inertias and bias forces.
template <class S>
void gather_inertias(const RobotModel& model, const S* v, const S* tau, Passes<S>& of,
                     RobotData<S>& data) {
  for (int i = model.joint_count() - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) continue;
    of.column[i] = of.inertia[i] * data.axis[i];
    of.inverse[i] = S(1.0) / (dot(data.axis[i], of.column[i]) + S(joint.rotor_inertia));
    of.residual[i] = (tau == nullptr ? S(0.0) : tau[joint.v]) - dot(data.axis[i], data.force[i]);
    if (joint.parent < 0) continue;
    const Motion<S> drift = v[joint.v] * data.psi_dot[i];
    of.inertia[i].subtract_outer(of.column[i], of.inverse[i]);
    const S push = of.residual[i] * of.inverse[i];
    data.force[joint.parent] += data.force[i] + of.inertia[i] * drift +
                                Force<S>{push * of.column[i].linear, push * of.column[i].angular};
    of.inertia[joint.parent] += of.inertia[i];
  }
}

template <class S>
void accelerate_floating(const RobotModel& model, int i, const S* tau,
                         const Articulated<S>& inertia, RobotData<S>& data) {
  const int v = model.joints[i].v;
  Force<S> f = Force<S>::zero() - data.force[i];
  if (tau != nullptr)
    for (int k = 0; k < 6; ++k) f[k] += tau[v + k];
  data.a[i] = inertia.solve(f);
  for (int k = 0; k < 3; ++k) {
    data.acceleration[v + k] = data.a[i].linear[k] + data.gravity(model, i)[k];
    data.acceleration[v + 3 + k] = data.a[i].angular[k];
  }
}

/// Forward pass, from the roots to the leaves: accelerations.
template <class S>
void spread_accelerations(const RobotModel& model, const S* v, const S* tau, const Passes<S>& of,
                          RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) {
      accelerate_floating(model, i, tau, of.inertia[i], data);
      continue;
    }
    data.a[i] = joint.parent < 0 ? Motion<S>{-model.gravity.cast<S>(), Vector3<S>::zero()}
                                 : data.a[joint.parent] + v[joint.v] * data.psi_dot[i];
    const S acceleration = (of.residual[i] - dot(data.a[i], of.column[i])) * of.inverse[i];
    data.acceleration[joint.v] = acceleration;
    data.a[i] += acceleration * data.axis[i];
  }
}

}  // namespace

template <class S>
void articulated_body_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                               RobotData<S>& data) {
  update_placements(model, q, data);
  update_velocities(model, v, data);
  update_composite_inertias(model, data);
  Passes<S> passes(model.joint_count());
  for (int i = 0; i < model.joint_count(); ++i) {
    passes.inertia[i] = Articulated<S>::from(data.body[i]);
    data.momentum[i] = data.body[i] * data.v[i];
    data.force[i] = cross(data.v[i], data.momentum[i]);
  }
  subtract_external_wrenches(model, data);
  gather_inertias(model, v, tau, passes, data);
  spread_accelerations(model, v, tau, passes, data);
}

#define CONDDP_INSTANTIATE(S)                                                              \
  template void articulated_body_dynamics(const RobotModel&, const S*, const S*, const S*, \
                                          RobotData<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
