#include "robot/contact.hpp"

namespace conddp {
namespace {

template <class S>
Vector3<S> load(const S* p) {
  return {p[0], p[1], p[2]};
}
template <class S>
Vector3<S> linear(const AlignedVector<S>& columns, int c) {
  return load(&columns[6 * c]);
}
template <class S>
Vector3<S> angular(const AlignedVector<S>& columns, int c) {
  return load(&columns[6 * c + 3]);
}
template <class S>
void store(const Vector3<S>& v, S* out) {
  for (int i = 0; i < 3; ++i) out[i] = v[i];
}

int columns_of(const RobotModel& model, const Contact& contact) {
  return support_size(model, model.frames[contact.frame].joint);
}

int direction_count(const Contact& contact) {
  return contact.kind == ContactKind::normal ? 1 : contact.kind == ContactKind::planar ? 2 : 0;
}

bool turns_against_body(const Contact& contact) {
  return direction_count(contact) > 0 && contact.axes == FrameAxes::world_aligned;
}

/// Calls act_on(column, velocity index) for all degrees of freedom that move the contact.
template <class F>
void for_each_dof(const RobotModel& model, const Contact& contact, F act_on) {
  int c = columns_of(model, contact);
  for (int j = model.frames[contact.frame].joint; j >= 0; j = model.joints[j].parent)
    for (int k = model.joints[j].nv() - 1; k >= 0; --k) act_on(--c, model.joints[j].v + k);
}

/// The position error in the frame's axes.
template <class S>
Vector3<S> position_error(const Contact& contact, const ContactData<S>& at) {
  return transpose_times(at.world.R, at.world.p - contact.reference.p.cast<S>());
}

template <class S>
Motion<S> placement_error(const Contact& contact, const ContactData<S>& at) {
  return difference_se3(
      Pose<S>{contact.reference.p.cast<S>(), quaternion(contact.reference.R.cast<S>())},
      Pose<S>{at.world.p, quaternion(at.world.R)});
}

/// Acceleration of the point with its Baumgarte terms, in the frame's axes.
template <class S>
Vector3<S> point_acceleration(const Contact& contact, const ContactData<S>& at, const Motion<S>& a,
                              const Motion<S>& v) {
  Vector3<S> sum = a.linear + cross(v.angular, v.linear) + S(contact.kd) * v.linear;
  if (contact.kp != 0) sum += S(contact.kp) * position_error(contact, at);
  return sum;
}

/// Writes a column of a contact's rows from the matching column of the point's vector, the rotation
/// of the frame, and the vector itself.
template <class S>
void put_point_column(const Contact& contact, const ContactData<S>& at, const Vector3<S>& column,
                      const Vector3<S>& turn, const Vector3<S>& value, S* out) {
  if (contact.kind == ContactKind::point) return store(column, out);
  for (int i = 0; i < direction_count(contact); ++i) {
    out[i] = dot(at.directions[i], column);
    if (turns_against_body(contact)) out[i] += dot(cross(at.directions[i], turn), value);
  }
}

/// The directions of a contact's rows in the axes of its frame.
template <class S>
void update_directions(const Contact& contact, ContactData<S>& out) {
  for (int i = 0; i < direction_count(contact); ++i) {
    const Vector3<S> d = (i == 0 ? contact.normal : contact.tangent).cast<S>();
    out.directions[i] = contact.axes == FrameAxes::local ? d : transpose_times(out.world.R, d);
  }
}

/// Views into a contact's scratch: columns of the twist's rate with respect to q and v, then of the
/// twist with respect to q.
template <class S>
struct TwistColumns {
  S *rate_q, *rate_v, *twist_q;

  TwistColumns(S* scratch, int columns)
      : rate_q(scratch), rate_v(rate_q + 6 * columns), twist_q(rate_v + 6 * columns) {}
};

template <class S>
void surface_acceleration_derivatives(const Contact& contact, int columns,
                                      const TwistColumns<S>& twist, ContactData<S>& at) {
  const S kd(contact.kd), kp(contact.kp);
  const Matrix6<S> log_derivative =
      contact.kp != 0 ? inverse_right_jacobian_se3(placement_error(contact, at)) : Matrix6<S>{};
  for (int c = 0; c < columns; ++c) {
    const S* J = &at.frame_jacobian[6 * c];
    for (int i = 0; i < 6; ++i) {
      S& q = at.wrt_q[6 * c + i];
      q = twist.rate_q[6 * c + i] + kd * twist.twist_q[6 * c + i];
      at.wrt_v[6 * c + i] = twist.rate_v[6 * c + i] + kd * J[i];
      if (contact.kp == 0) continue;
      for (int k = 0; k < 6; ++k) q += kp * log_derivative(i, k) * J[k];
    }
  }
}

template <class S>
void point_acceleration_derivatives(const RobotModel& model, const Contact& contact, int columns,
                                    const RobotData<S>& data, const TwistColumns<S>& twist,
                                    ContactData<S>& at) {
  const int joint = model.frames[contact.frame].joint, rows = contact.rows();
  const S kd(contact.kd), kp(contact.kp);
  Motion<S> a = data.a[joint];
  a.linear += data.gravity(model, joint);
  a = act_inverse(at.placement, a);
  const Motion<S> v = act_inverse(at.placement, data.v[joint]);
  const Vector3<S> sum = point_acceleration(contact, at, a, v);
  const Vector3<S> error = position_error(contact, at);
  for (int c = 0; c < columns; ++c) {
    const Vector3<S> lin = linear(at.frame_jacobian, c), turn = angular(at.frame_jacobian, c);
    const auto change = [&](const S* rate, const Vector3<S>& v_lin, const Vector3<S>& w) {
      return load(rate + 6 * c) + cross(w, v.linear) + cross(v.angular, v_lin) + kd * v_lin;
    };
    Vector3<S> q =
        change(twist.rate_q, load(twist.twist_q + 6 * c), load(twist.twist_q + 6 * c + 3));
    if (contact.kp != 0) q += kp * (lin + cross(error, turn));
    put_point_column(contact, at, q, turn, sum, &at.wrt_q[rows * c]);
    put_point_column(contact, at, change(twist.rate_v, lin, turn), Vector3<S>::zero(), sum,
                     &at.wrt_v[rows * c]);
  }
}

}  // namespace

template <class S>
ContactData<S>::ContactData(const RobotModel& model, const Contact& contact)
    : placement(SE3<S>::identity()),
      world(SE3<S>::identity()),
      directions{Vector3<S>::zero(), Vector3<S>::zero()},
      frame_jacobian(6 * columns_of(model, contact), S(0.0)),
      jacobian(contact.rows() * columns_of(model, contact), S(0.0)),
      wrt_q(jacobian),
      wrt_v(jacobian),
      scratch(18 * columns_of(model, contact), S(0.0)),
      local(Force<S>::zero()) {}

template <class S>
void update_contact(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                    ContactData<S>& out) {
  const Frame& frame = model.frames[contact.frame];
  out.placement = data.placement[frame.joint] * frame.placement;
  out.world = data.root_pose(model, frame.joint) * out.placement;
  update_directions(contact, out);
  frame_jacobian(model, data, contact.frame, FrameAxes::local, out.frame_jacobian.data());
  const int rows = contact.rows(), columns = columns_of(model, contact);
  for (int c = 0; c < columns; ++c) {
    const S* full = &out.frame_jacobian[6 * c];
    S* column = &out.jacobian[rows * c];
    if (const int directions = direction_count(contact); directions > 0)
      for (int i = 0; i < directions; ++i) column[i] = dot(out.directions[i], load(full));
    else
      for (int i = 0; i < rows; ++i) column[i] = full[i];
  }
}

template <class S>
void contact_acceleration(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                          const ContactData<S>& at, S* rows) {
  const int joint = model.frames[contact.frame].joint;
  Motion<S> a = data.a[joint];
  a.linear += data.gravity(model, joint);
  a = act_inverse(at.placement, a);
  const Motion<S> v = act_inverse(at.placement, data.v[joint]);
  if (contact.kind != ContactKind::surface) {
    const Vector3<S> sum = point_acceleration(contact, at, a, v);
    if (contact.kind == ContactKind::point) return store(sum, rows);
    for (int i = 0; i < direction_count(contact); ++i) rows[i] = dot(at.directions[i], sum);
    return;
  }
  Motion<S> sum = a + S(contact.kd) * v;
  if (contact.kp != 0) sum = sum + S(contact.kp) * placement_error(contact, at);
  for (int i = 0; i < 6; ++i) rows[i] = sum[i];
}

template <class S>
void contact_acceleration_derivatives(const RobotModel& model, const Contact& contact,
                                      const RobotData<S>& data, ContactData<S>& at) {
  const int columns = columns_of(model, contact);
  const TwistColumns<S> twist(at.scratch.data(), columns);
  frame_acceleration_derivatives(model, data, contact.frame, twist.rate_q, twist.rate_v);
  frame_velocity_derivative(model, data, contact.frame, FrameAxes::local, twist.twist_q);
  if (contact.kind == ContactKind::surface)
    surface_acceleration_derivatives(contact, columns, twist, at);
  else
    point_acceleration_derivatives(model, contact, columns, data, twist, at);
}

template <class S>
void contact_velocity_derivative(const RobotModel& model, const Contact& contact,
                                 const RobotData<S>& data, ContactData<S>& at) {
  const int columns = columns_of(model, contact), rows = contact.rows();
  S* twist_q = at.scratch.data();
  frame_velocity_derivative(model, data, contact.frame, FrameAxes::local, twist_q);
  const Vector3<S> v = act_inverse(at.placement, data.v[model.frames[contact.frame].joint]).linear;
  for (int c = 0; c < columns; ++c) {
    if (contact.kind == ContactKind::surface)
      for (int i = 0; i < 6; ++i) at.wrt_q[6 * c + i] = twist_q[6 * c + i];
    else
      put_point_column(contact, at, load(twist_q + 6 * c), angular(at.frame_jacobian, c), v,
                       &at.wrt_q[rows * c]);
  }
}

template <class S>
void set_contact_force(const Contact& contact, const S* rows, ContactData<S>& at) {
  at.local = Force<S>::zero();
  if (const int directions = direction_count(contact); directions > 0) {
    for (int i = 0; i < directions; ++i) at.local.linear += rows[i] * at.directions[i];
    return;
  }
  at.local.linear = load(rows);
  if (contact.kind == ContactKind::surface) at.local.angular = load(rows + 3);
}

template <class S>
void add_contact_wrench(const RobotModel& model, const Contact& contact, const ContactData<S>& at,
                        AlignedVector<Force<S>>& forces) {
  forces[model.frames[contact.frame].joint] += act(at.placement, at.local);
}

template <class S>
void subtract_direction_derivative(const RobotModel& model, const Contact& contact,
                                   const ContactData<S>& at, AlignedVector<S>& tau_q) {
  if (!turns_against_body(contact)) return;
  for_each_dof(model, contact, [&](int column, int at_column) {
    const Vector3<S> change = cross(at.local.linear, angular(at.frame_jacobian, column));
    for_each_dof(model, contact, [&](int row, int at_row) {
      tau_q[at_column * model.nv + at_row] -= dot(linear(at.frame_jacobian, row), change);
    });
  });
}

template <class S>
void subtract_direction_gradient(const RobotModel& model, const Contact& contact,
                                 const ContactData<S>& at, const S* w, AlignedVector<S>& wrt_q) {
  if (!turns_against_body(contact)) return;
  Vector3<S> velocity = Vector3<S>::zero();
  for_each_dof(model, contact, [&](int row, int at_row) {
    velocity += w[at_row] * linear(at.frame_jacobian, row);
  });
  for_each_dof(model, contact, [&](int column, int at_column) {
    wrt_q[at_column] -= dot(velocity, cross(at.local.linear, angular(at.frame_jacobian, column)));
  });
}

#define CONDDP_INSTANTIATE(S)                                                                \
  template struct ContactData<S>;                                                            \
  template void update_contact(const RobotModel&, const Contact&, const RobotData<S>&,       \
                               ContactData<S>&);                                             \
  template void contact_acceleration(const RobotModel&, const Contact&, const RobotData<S>&, \
                                     const ContactData<S>&, S*);                             \
  template void contact_acceleration_derivatives(const RobotModel&, const Contact&,          \
                                                 const RobotData<S>&, ContactData<S>&);      \
  template void contact_velocity_derivative(const RobotModel&, const Contact&,               \
                                            const RobotData<S>&, ContactData<S>&);           \
  template void set_contact_force(const Contact&, const S*, ContactData<S>&);                \
  template void add_contact_wrench(const RobotModel&, const Contact&, const ContactData<S>&, \
                                   AlignedVector<Force<S>>&);                                \
  template void subtract_direction_derivative(const RobotModel&, const Contact&,             \
                                              const ContactData<S>&, AlignedVector<S>&);     \
  template void subtract_direction_gradient(const RobotModel&, const Contact&,               \
                                            const ContactData<S>&, const S*, AlignedVector<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
