#include "robot/contact.hpp"

#include "robot/joint_axes.hpp"

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

int joint_of(const RobotModel& model, const Contact& contact) {
  return model.frames[contact.frame].joint;
}
/// The joint that moves the base; −1 for the world.
int joint_of_base(const RobotModel& model, const Contact& contact) {
  return contact.base ? model.frames[*contact.base].joint : -1;
}

template <class S>
int columns_of(const ContactData<S>& at) {
  return static_cast<int>(at.support.size());
}

int direction_count(const Contact& contact) {
  return contact.kind == ContactKind::normal ? 1 : contact.kind == ContactKind::planar ? 2 : 0;
}

bool turns_against_body(const Contact& contact) {
  return direction_count(contact) > 0 && contact.axes == FrameAxes::world_aligned;
}

/// Calls act_on(column, velocity index) for all degrees of freedom that move the contact.
template <class S, class F>
void for_each_dof(const ContactData<S>& at, F act_on) {
  for (int c = columns_of(at) - 1; c >= 0; --c) act_on(c, at.support[c]);
}

/// Velocity of the frame relative to its base, in its axes, and its rate.
template <class S>
struct RelativeMotion {
  Motion<S> v, a;
};

/// The rate of the difference v − X v_base, where the transformation X of the base's twist to the
/// frame's axes changes with that difference.
template <class S>
RelativeMotion<S> relative_motion(const RobotModel& model, const Contact& contact,
                                  const RobotData<S>& data, const ContactData<S>& at) {
  const int joint = joint_of(model, contact);
  Motion<S> a = data.a[joint];
  a.linear += data.gravity(model, joint);
  const RelativeMotion<S> own{act_inverse(at.placement, data.v[joint]),
                              act_inverse(at.placement, a)};
  if (joint_of_base(model, contact) < 0) return own;
  const auto in_frame = [&](const Motion<S>& m) { return act_inverse(at.relative, m); };
  const Motion<S> base = in_frame(frame_velocity(model, data, *contact.base, FrameAxes::local));
  const Motion<S> v = own.v - base;
  return {v, own.a - in_frame(frame_acceleration(model, data, *contact.base, FrameAxes::local)) +
                 cross(v, base)};
}

/// The position error in the frame's axes.
template <class S>
Vector3<S> position_error(const Contact& contact, const ContactData<S>& at) {
  return transpose_times(at.relative.R, at.relative.p - contact.reference.p.cast<S>());
}

template <class S>
Motion<S> placement_error(const Contact& contact, const ContactData<S>& at) {
  return difference_se3(
      Pose<S>{contact.reference.p.cast<S>(), quaternion(contact.reference.R.cast<S>())},
      Pose<S>{at.relative.p, quaternion(at.relative.R)});
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
    out.directions[i] = contact.axes == FrameAxes::local ? d : transpose_times(out.relative.R, d);
  }
}

/// Columns in a contact's scratch: of the twist's rate with respect to q and v, then of the twist
/// with respect to q.
template <class S>
struct TwistColumns {
  S *rate_q, *rate_v, *twist_q;
};

template <class S>
TwistColumns<S> twist_columns(const RobotModel& model, const Contact& contact,
                              const RobotData<S>& data, ContactData<S>& at) {
  const int size = 6 * columns_of(at);
  S* scratch = at.scratch.data();
  const TwistColumns<S> out{scratch, scratch + size, scratch + 2 * size};
  relative_velocity_derivative(model, data, contact.pair(), out.twist_q);
  relative_acceleration_derivatives(model, data, contact.pair(), at.frame_jacobian.data(),
                                    out.twist_q, scratch + 3 * size, out.rate_q, out.rate_v);
  return out;
}

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
  const int rows = contact.rows();
  const S kd(contact.kd), kp(contact.kp);
  const RelativeMotion<S> motion = relative_motion(model, contact, data, at);
  const Motion<S>&a = motion.a, &v = motion.v;
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
    : support(conddp::support(model, contact.pair())),
      placement(SE3<S>::identity()),
      world(SE3<S>::identity()),
      relative(SE3<S>::identity()),
      base_placement(SE3<S>::identity()),
      directions{Vector3<S>::zero(), Vector3<S>::zero()},
      frame_jacobian(6 * support.size(), S(0.0)),
      jacobian(contact.rows() * support.size(), S(0.0)),
      wrt_q(jacobian),
      wrt_v(jacobian),
      scratch(18 * support.size(), S(0.0)),
      local(Force<S>::zero()) {
  if (joint_of_base(model, contact) < 0) return;
  const RelativeColumns columns(model, contact.pair());
  base_jacobian.assign(6 * support.size(), S(0.0));
  scratch.resize(18 * support.size() + 12 * (columns.frame + columns.base), S(0.0));
}

template <class S>
void update_contact(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                    ContactData<S>& out) {
  const Frame& frame = model.frames[contact.frame];
  out.placement = data.placement[frame.joint] * frame.placement;
  out.world = data.root_pose(model, frame.joint) * out.placement;
  out.relative = out.world;
  if (contact.base) {
    const Frame& base = model.frames[*contact.base];
    if (base.joint >= 0) out.base_placement = data.placement[base.joint] * base.placement;
    out.relative = inverse(frame_placement(model, data, *contact.base)) * out.world;
  }
  update_directions(contact, out);
  relative_jacobian(model, data, contact.pair(), out.frame_jacobian.data(),
                    out.base_jacobian.data());
  const int rows = contact.rows(), columns = columns_of(out);
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
void contact_error(const Contact& contact, const ContactData<S>& at, S* rows) {
  if (contact.kind == ContactKind::surface)
    return store_column(placement_error(contact, at), rows, 0);
  const Vector3<S> error = position_error(contact, at);
  if (contact.kind == ContactKind::point) return store(error, rows);
  for (int i = 0; i < direction_count(contact); ++i) rows[i] = dot(at.directions[i], error);
}

template <class S>
void contact_acceleration(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                          const ContactData<S>& at, S* rows) {
  const RelativeMotion<S> motion = relative_motion(model, contact, data, at);
  const Motion<S>&a = motion.a, &v = motion.v;
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
  const int columns = columns_of(at);
  const TwistColumns<S> twist = twist_columns(model, contact, data, at);
  if (contact.kind == ContactKind::surface)
    surface_acceleration_derivatives(contact, columns, twist, at);
  else
    point_acceleration_derivatives(model, contact, columns, data, twist, at);
}

template <class S>
void contact_velocity_derivative(const RobotModel& model, const Contact& contact,
                                 const RobotData<S>& data, ContactData<S>& at) {
  const int columns = columns_of(at), rows = contact.rows();
  S* twist_q = at.scratch.data();
  relative_velocity_derivative(model, data, contact.pair(), twist_q);
  const Vector3<S> v = relative_velocity(model, data, contact.pair(), FrameAxes::local).linear;
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
  forces[joint_of(model, contact)] += act(at.placement, at.local);
  const int base = joint_of_base(model, contact);
  if (base < 0) return;
  forces[base] = forces[base] - act(at.base_placement * at.relative, at.local);
}

namespace {

/// Calls act(velocity index, turned, moved) for each column with changes of the force as the frame
/// moves relative to its base: of directions fixed in the base, and of the force on
/// a base that the frame leaves. Both in the frame's axes.
template <class S, class F>
void for_each_force_change(const Contact& contact, const ContactData<S>& at, F act) {
  const bool turns = turns_against_body(contact), moves = !at.base_jacobian.empty();
  if (!turns && !moves) return;
  for_each_dof(at, [&](int column, int at_column) {
    const Motion<S> move = load_column(at.frame_jacobian.data(), column);
    Force<S> turned = Force<S>::zero();
    if (turns) turned.linear = cross(at.local.linear, move.angular);
    act(at_column, turned, moves ? cross(move, at.local) : Force<S>::zero());
  });
}

}  // namespace

template <class S>
void subtract_contact_derivative(const RobotModel& model, const Contact& contact,
                                 const ContactData<S>& at, AlignedVector<S>& tau_q) {
  const bool moves_base = !at.base_jacobian.empty();
  for_each_force_change(contact, at,
                        [&](int at_column, const Force<S>& turned, const Force<S>& moved) {
                          for_each_dof(at, [&](int row, int at_row) {
                            S& entry = tau_q[at_column * model.nv + at_row];
                            entry -= dot(linear(at.frame_jacobian, row), turned.linear);
                            if (moves_base)
                              entry -= dot(load_column(at.base_jacobian.data(), row), moved);
                          });
                        });
}

template <class S>
void subtract_contact_gradient(const RobotModel& /*model*/, const Contact& contact,
                               const ContactData<S>& at, const S* w, AlignedVector<S>& wrt_q) {
  const bool moves_base = !at.base_jacobian.empty();
  Vector3<S> velocity = Vector3<S>::zero();
  Motion<S> of_base = Motion<S>::zero();
  for_each_dof(at, [&](int row, int at_row) {
    velocity += w[at_row] * linear(at.frame_jacobian, row);
    if (moves_base) of_base += w[at_row] * load_column(at.base_jacobian.data(), row);
  });
  for_each_force_change(contact, at,
                        [&](int at_column, const Force<S>& turned, const Force<S>& moved) {
                          wrt_q[at_column] -= dot(velocity, turned.linear) + dot(of_base, moved);
                        });
}

#define CONDDP_INSTANTIATE(S)                                                                \
  template struct ContactData<S>;                                                            \
  template void update_contact(const RobotModel&, const Contact&, const RobotData<S>&,       \
                               ContactData<S>&);                                             \
  template void contact_error(const Contact&, const ContactData<S>&, S*);                    \
  template void contact_acceleration(const RobotModel&, const Contact&, const RobotData<S>&, \
                                     const ContactData<S>&, S*);                             \
  template void contact_acceleration_derivatives(const RobotModel&, const Contact&,          \
                                                 const RobotData<S>&, ContactData<S>&);      \
  template void contact_velocity_derivative(const RobotModel&, const Contact&,               \
                                            const RobotData<S>&, ContactData<S>&);           \
  template void set_contact_force(const Contact&, const S*, ContactData<S>&);                \
  template void add_contact_wrench(const RobotModel&, const Contact&, const ContactData<S>&, \
                                   AlignedVector<Force<S>>&);                                \
  template void subtract_contact_derivative(const RobotModel&, const Contact&,               \
                                            const ContactData<S>&, AlignedVector<S>&);       \
  template void subtract_contact_gradient(const RobotModel&, const Contact&,                 \
                                          const ContactData<S>&, const S*, AlignedVector<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
