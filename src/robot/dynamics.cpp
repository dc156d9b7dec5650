#include "robot/dynamics.hpp"

#include "robot/loads.hpp"
#include "robot/wrenches.hpp"

namespace conddp {
namespace {

template <class S>
Vector3<S> unit(int k) {
  Vector3<S> e = Vector3<S>::zero();
  e[k] = S(1.0);
  return e;
}

/// Sums forces towards the root and projects them on the joints.
template <class S>
void project_forces(const RobotModel& model, RobotData<S>& data, S* tau) {
  for (int i = model.joint_count() - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) {
      for (int k = 0; k < 6; ++k) tau[joint.v + k] = data.force[i][k];
      continue;
    }
    tau[joint.v] = dot(data.axis[i], data.force[i]);
    if (joint.parent >= 0) data.force[joint.parent] += data.force[i];
  }
}

/// x ← (Lᵀ D L)⁻¹ x for several right-hand sides together, whose sums stay in registers.
template <int kColumns, class S>
void solve_columns(const RobotModel& model, const RobotData<S>& data, S* x) {
  const int n = model.nv;
  const S* L = data.L.data();
  S sum[kColumns];
  for (int j = n - 1; j >= 0; --j) {
    for (int c = 0; c < kColumns; ++c) sum[c] = x[c * n + j];
    for (int i = j + 1; i < model.subtree_end[j]; ++i)
      for (int c = 0; c < kColumns; ++c) sum[c] -= L[j * n + i] * x[c * n + i];
    for (int c = 0; c < kColumns; ++c) x[c * n + j] = sum[c];
  }
  for (int i = 0; i < n; ++i) {
    for (int c = 0; c < kColumns; ++c) sum[c] = data.D_inverse[i] * x[c * n + i];
    for (int j = model.parent_dof[i]; j >= 0; j = model.parent_dof[j])
      for (int c = 0; c < kColumns; ++c) sum[c] -= L[j * n + i] * x[c * n + j];
    for (int c = 0; c < kColumns; ++c) x[c * n + i] = sum[c];
  }
}

/// Writes the block of a floating body, whose motion subspace is the identity.
template <class S>
void put_floating_inertia(const RobotModel& model, int i, RobotData<S>& data) {
  const int n = model.nv, v = model.joints[i].v;
  S* M = data.M.data() + v;
  const Inertia<S>& y = data.composite[i];
  const Matrix3<S> c = skew(y.moment);
  const S* j = &y.rotational.xx;
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) {
      M[(v + col) * n + row] = row == col ? y.mass : S(0.0);
      M[(v + col) * n + row + 3] = c(row, col);
    }
  }
  constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int col = 0; col < 3; ++col)
    for (int row = col; row < 3; ++row) M[(v + col + 3) * n + row + 3] = j[kPacked[row][col]];
}

/// Writes the row of a one-DoF joint: the forces on this joint and its ancestors due to its motion.
template <class S>
void put_mass_row(const RobotModel& model, int i, RobotData<S>& data) {
  const int n = model.nv;
  const Joint& joint = model.joints[i];
  S* M = data.M.data() + joint.v;
  const Force<S>& f = data.column[i];
  M[joint.v * n] = dot(data.axis[i], f) + S(joint.rotor_inertia);
  for (int p = joint.parent; p >= 0; p = model.joints[p].parent) {
    const int pv = model.joints[p].v;
    if (model.joints[p].type == JointType::floating)
      for (int k = 0; k < 6; ++k) M[(pv + k) * n] = f[k];
    else
      M[pv * n] = dot(data.axis[p], f);
  }
}

/// Number of entries in a row of the factors that are computed together.
constexpr int kRowWidth = 6;

/// Writes D_i L_ij for kCount ancestors j of i, and D_i for j = i, into L_ji above the diagonal.
/// There the rows of a factor are contiguous. The rows after i must be complete.
template <int kCount, class S>
void put_scaled_row(const RobotModel& model, int i, const int* columns, RobotData<S>& data) {
  const int n = model.nv;
  S* row = data.L.data() + i * n;
  S sum[kCount];
  for (int c = 0; c < kCount; ++c) sum[c] = data.M[columns[c] * n + i];
  for (int k = i + 1; k < model.subtree_end[i]; ++k) {
    const S* scaled = data.L.data() + k * n;
    for (int c = 0; c < kCount; ++c) sum[c] -= row[k] * scaled[columns[c]];
  }
  for (int c = 0; c < kCount; ++c) row[columns[c]] = sum[c];
}

template <class S>
void put_scaled_row(const RobotModel& model, int i, const int* columns, int count,
                    RobotData<S>& data) {
  switch (count) {
    case 1:
      return put_scaled_row<1>(model, i, columns, data);
    case 2:
      return put_scaled_row<2>(model, i, columns, data);
    case 3:
      return put_scaled_row<3>(model, i, columns, data);
    case 4:
      return put_scaled_row<4>(model, i, columns, data);
    case 5:
      return put_scaled_row<5>(model, i, columns, data);
    default:
      return put_scaled_row<kRowWidth>(model, i, columns, data);
  }
}

/// Computes 2B m of a subtree from its momentum and the rate of its inertia. It depends only on the
/// angular part w of m.
template <class S>
inline Force<S> twice_b(const Force<S>& h, const Symmetric3<S>& rate, const Vector3<S>& w) {
  return {S(2.0) * cross(w, h.linear), rate * w + cross(w, h.angular)};
}

// The next three functions are the body of one loop, inlined: calls would cost an iteration 0.15 %
// more instructions.

/// Writes the columns of a floating body. Its motion subspace is the identity, so unit linear and
/// angular motions give 3x3 blocks.
template <class S>
[[gnu::always_inline]] inline void put_floating_columns(const RobotModel& model, int i,
                                                        RobotData<S>& data) {
  const int n = model.nv, v = model.joints[i].v;
  const Force<S>& h = data.momentum[i];
  const Symmetric3<S>& rate = data.inertia_rate[i];
  const Inertia<S>& y = data.composite[i];
  const Vector3<S> g = data.gravity(model, i);
  const Vector3<S>& w = data.v[i].angular;
  const auto put = [v](S* column, const Force<S>& change) {
    for (int row = 0; row < 6; ++row) column[v + row] = change[row];
  };
  for (int k = 0; k < 3; ++k) {
    const Vector3<S> e = unit<S>(k);
    const Vector3<S> w_e = cross(w, e);
    S* linear_q = data.tau_q.data() + (v + k) * n;
    S* linear_v = data.tau_v.data() + (v + k) * n;
    put(linear_q, Force<S>::zero());
    put(linear_v, {y.mass * w_e, cross(y.moment, w_e)});
    const Vector3<S> e_g = cross(e, g);
    put(linear_q + 3 * n, {y.mass * e_g, cross(y.moment, e_g)});
    put(linear_v + 3 * n, twice_b(h, rate, e) + y * Motion<S>{cross(data.v[i].linear, e), w_e});
  }
}

/// Writes row i: the ancestors of joint i move the subtree of i.
template <class S>
[[gnu::always_inline]] inline void put_subtree_row(const RobotModel& model, int i,
                                                   RobotData<S>& data) {
  const int n = model.nv, v = model.joints[i].v;
  const Force<S>& h = data.momentum[i];
  const Motion<S>& s = data.axis[i];
  const Force<S>& f = data.column[i];
  const Vector3<S> z = S(2.0) * cross(h.linear, s.linear) + data.inertia_rate[i] * s.angular +
                       cross(h.angular, s.angular);
  for (int j = i; j >= 0; j = model.joints[j].parent) {
    const int vj = model.joints[j].v;
    if (model.joints[j].type == JointType::floating) {
      const Vector3<S> dq = cross(data.gravity(model, j), f.linear);
      const Force<S> dv = cross(data.v[j], f);
      for (int k = 0; k < 3; ++k) {
        data.tau_q[(vj + k) * n + v] = S(0.0);
        data.tau_q[(vj + 3 + k) * n + v] = dq[k];
        data.tau_v[(vj + k) * n + v] = -dv.linear[k];
        data.tau_v[(vj + 3 + k) * n + v] = z[k] - dv.angular[k];
      }
      continue;
    }
    data.tau_q[vj * n + v] = dot(z, data.psi_dot[j].angular) + dot(data.psi_ddot[j], f);
    data.tau_v[vj * n + v] = dot(z, data.axis[j].angular) + dot(data.axis_rate[j], f);
  }
}

/// Writes column i: joint i moves its subtree, which exerts forces on the ancestors.
template <class S>
[[gnu::always_inline]] inline void put_subtree_column(const RobotModel& model, int i,
                                                      RobotData<S>& data) {
  const int n = model.nv;
  const Joint& joint = model.joints[i];
  const Force<S>& h = data.momentum[i];
  const Symmetric3<S>& rate = data.inertia_rate[i];
  const Inertia<S>& y = data.composite[i];
  const Motion<S>& s = data.axis[i];
  const Force<S> dq =
      twice_b(h, rate, data.psi_dot[i].angular) + y * data.psi_ddot[i] + cross(s, data.force[i]);
  const Force<S> dv = twice_b(h, rate, s.angular) + y * data.axis_rate[i];
  S* column_q = data.tau_q.data() + joint.v * n;
  S* column_v = data.tau_v.data() + joint.v * n;
  for (int j = joint.parent; j >= 0; j = model.joints[j].parent) {
    const int vj = model.joints[j].v;
    if (model.joints[j].type == JointType::floating) {
      for (int k = 0; k < 6; ++k) {
        column_q[vj + k] = dq[k];
        column_v[vj + k] = dv[k];
      }
    } else {
      column_q[vj] = dot(data.axis[j], dq);
      column_v[vj] = dot(data.axis[j], dv);
    }
  }
}

/// Writes the change of the weight on a floating body as it rotates.
template <class S>
void put_floating_weight_slopes(const RobotModel& model, int i, const RobotData<S>& data,
                                S* out_q) {
  const int n = model.nv, v = model.joints[i].v;
  const Vector3<S> g = data.gravity(model, i);
  for (int k = 0; k < 3; ++k) {
    const Force<S> dq = data.composite[i] * Motion<S>{cross(unit<S>(k), g), Vector3<S>::zero()};
    for (int row = 0; row < 6; ++row) out_q[(v + 3 + k) * n + v + row] = dq[row];
  }
}

/// Writes the row and column of a one-DoF joint: the change of its torque as its ancestors move,
/// and of theirs as it moves. `weight` is that of its subtree.
template <class S>
void put_weight_slopes(const RobotModel& model, int i, const RobotData<S>& data,
                       const Force<S>& weight, S* out_q) {
  const int n = model.nv, v = model.joints[i].v;
  const Vector3<S> g = data.gravity(model, i);
  const Motion<S>& s = data.axis[i];
  const Force<S>& f = data.column[i];
  const auto turned_gravity = [&g](const Motion<S>& axis) {
    return Motion<S>{cross(axis.angular, g), Vector3<S>::zero()};
  };
  const Force<S> change = data.composite[i] * turned_gravity(s) + cross(s, weight);
  for (int j = i; j >= 0; j = model.joints[j].parent) {
    const int vj = model.joints[j].v;
    if (model.joints[j].type == JointType::floating) {
      const Vector3<S> dq = cross(g, f.linear);
      for (int k = 0; k < 3; ++k) out_q[(vj + 3 + k) * n + v] = dq[k];
      for (int k = 0; k < 6; ++k) out_q[v * n + vj + k] = change[k];
    } else {
      out_q[vj * n + v] = dot(turned_gravity(data.axis[j]), f);
      out_q[v * n + vj] = dot(data.axis[j], change);
    }
  }
}

}  // namespace

template <class S>
void inverse_dynamics(const RobotModel& model, const S* q, const S* v, const S* a,
                      RobotData<S>& data) {
  update_placements(model, q, data);
  update_velocities(model, v, data);
  update_accelerations(model, v, a, data);
  update_composite_inertias(model, data);
  body_forces(model, data);
  subtract_external_wrenches(model, data);
  project_forces(model, data, data.tau.data());
  for (const Joint& joint : model.joints)
    if (joint.rotor_inertia != 0) data.tau[joint.v] += a[joint.v] * S(joint.rotor_inertia);
}

template <class S>
void mass_matrix(const RobotModel& model, RobotData<S>& data) {
  update_composite_inertias(model, data);
  for (int i = 0; i < model.joint_count(); ++i) {
    if (model.joints[i].type == JointType::floating)
      put_floating_inertia(model, i, data);
    else
      put_mass_row(model, i, data);
  }
}

template <class S>
void factorize_mass_matrix(const RobotModel& model, RobotData<S>& data) {
  const int n = model.nv;
  // Processes rows from last to first, each along its path to the root. Subtrees are contiguous.
  for (int i = n - 1; i >= 0; --i) {
    int columns[kRowWidth], count = 0;
    for (int j = i; j >= 0; j = model.parent_dof[j]) {
      columns[count++] = j;
      if (count < kRowWidth && model.parent_dof[j] >= 0) continue;
      put_scaled_row(model, i, columns, count, data);
      count = 0;
    }
    S* scaled = data.L.data() + i * n;
    const S inverse = data.D_inverse[i] = S(1.0) / scaled[i];
    for (int j = model.parent_dof[i]; j >= 0; j = model.parent_dof[j])
      data.L[j * n + i] = scaled[j] * inverse;
  }
}

template <class S>
void solve_mass_matrix(const RobotModel& model, const RobotData<S>& data, S* x, int columns) {
  for (; columns >= 6; columns -= 6, x += 6 * model.nv) solve_columns<6>(model, data, x);
  for (; columns > 0; --columns, x += model.nv) solve_columns<1>(model, data, x);
}

template <class S>
void bias_forces(const RobotModel& model, const S* v, RobotData<S>& data) {
  update_accelerations<S>(model, v, nullptr, data);
  body_forces(model, data);
  subtract_external_wrenches(model, data);
  project_forces(model, data, data.bias.data());
}

template <class S>
void inverse_dynamics_derivatives(const RobotModel& model, const S* v, RobotData<S>& data,
                                  const AlignedVector<Force<S>>* applied) {
  start_inverse_dynamics_derivatives(model, v, data, applied);
  for (int i = model.joint_count() - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) {
      put_floating_columns(model, i, data);
      continue;
    }
    put_subtree_row(model, i, data);
    if (joint.parent < 0) continue;
    put_subtree_column(model, i, data);
    data.momentum[joint.parent] += data.momentum[i];
    data.inertia_rate[joint.parent] += data.inertia_rate[i];
    data.force[joint.parent] += data.force[i];
  }
  subtract_external_wrench_derivatives(model, data);
  put_load_columns(model, data);
}

template <class S>
void gravity_torques(const RobotModel& model, const RobotData<S>& data, S* out, S* out_q) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    const Vector3<S> g = data.gravity(model, i);
    const Inertia<S>& y = data.composite[i];
    const Force<S> weight{-(y.mass * g), -cross(y.moment, g)};
    if (joint.type == JointType::floating) {
      for (int k = 0; k < 6; ++k) out[joint.v + k] = weight[k];
      if (out_q != nullptr) put_floating_weight_slopes(model, i, data, out_q);
      continue;
    }
    out[joint.v] = -dot(data.column[i].linear, g);
    if (out_q != nullptr) put_weight_slopes(model, i, data, weight, out_q);
  }
  if (out_q != nullptr) put_load_weights(model, data, out_q);
}

template <class S>
S kinetic_energy(const RobotModel& model, const RobotData<S>& data) {
  S twice(0.0);
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    twice += dot(data.v[i], data.body[i] * data.v[i]);
    if (joint.rotor_inertia == 0) continue;
    const Motion<S> own = joint.parent < 0 ? data.v[i] : data.v[i] - data.v[joint.parent];
    const S rate = joint.type == JointType::revolute ? dot(data.axis[i].angular, own.angular)
                                                     : dot(data.axis[i].linear, own.linear);
    twice += S(joint.rotor_inertia) * rate * rate;
  }
  return S(0.5) * twice;
}

template <class S>
S potential_energy(const RobotModel& model, const RobotData<S>& data) {
  S energy(0.0);
  for (int i = 0; i < model.joint_count(); ++i) {
    if (model.joints[i].parent >= 0) continue;
    const SE3<S> root = data.root_pose(model, i);
    const Inertia<S>& y = data.composite[i];
    energy -= dot(root.R * y.moment + y.mass * root.p, model.gravity.cast<S>());
  }
  return energy;
}

#define CONDDP_INSTANTIATE(S)                                                                     \
  template void inverse_dynamics(const RobotModel&, const S*, const S*, const S*, RobotData<S>&); \
  template void mass_matrix(const RobotModel&, RobotData<S>&);                                    \
  template void factorize_mass_matrix(const RobotModel&, RobotData<S>&);                          \
  template void solve_mass_matrix(const RobotModel&, const RobotData<S>&, S*, int);               \
  template void bias_forces(const RobotModel&, const S*, RobotData<S>&);                          \
  template void inverse_dynamics_derivatives(const RobotModel&, const S*, RobotData<S>&,          \
                                             const AlignedVector<Force<S>>*);                     \
  template void gravity_torques(const RobotModel&, const RobotData<S>&, S*, S*);                  \
  template S kinetic_energy(const RobotModel&, const RobotData<S>&);                              \
  template S potential_energy(const RobotModel&, const RobotData<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
CONDDP_INSTANTIATE(Dual<Dual<Lane>>)  // for Hessians of functions that take derivatives internally
#undef CONDDP_INSTANTIATE

}  // namespace conddp
