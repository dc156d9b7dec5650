#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/system_columns.hpp"

namespace conddp {
namespace {

using SystemPointer = std::shared_ptr<const MultibodySystem>;

/// Common data of one frame's residuals: the robot, the frame and its base, and the columns that
/// move them. Quantities are those of the frame in its base, which is the world by default.
class FrameOf {
 public:
  FrameOf(SystemPointer system, const FramePair& pair)
      : system_(std::move(system)),
        pair_(pair),
        columns_(system_->mimic_map(), support(system_->robot(), pair)) {}

  const RobotModel& robot() const { return system_->robot(); }
  const std::vector<int>& columns() const { return columns_.columns(); }
  int count() const { return columns_.count(); }
  /// The columns of the position, then those of the velocity.
  std::vector<int> position_and_velocity_columns() const {
    std::vector<int> both = columns();
    for (const int c : columns()) both.push_back(system_->nv() + c);
    return both;
  }
  template <class S>
  static RobotData<S>& data(const ResidualInput<S>& in) {
    return multibody_data(in).robot;
  }
  template <class S>
  SE3<S> placement(const ResidualInput<S>& in) const {
    return relative_placement(robot(), data(in), pair_);
  }
  template <class S>
  Motion<S> velocity(const ResidualInput<S>& in, FrameAxes axes) const {
    return relative_velocity(robot(), data(in), pair_, axes);
  }

  /// Writes the derivative of the position, 3 rows.
  template <class S>
  void write_position(const ResidualInput<S>& in, S* jacobian) const {
    write(in, 3, jacobian, [&](S* out) {
      if (!pair_.base) return frame_position_jacobian(robot(), data(in), pair_.frame, out);
      const Matrix3<S> R = placement(in).R;
      for_each_column(in, [&](int c, const Motion<S>& move) { put(R * move.linear, out + 3 * c); });
    });
  }
  /// Writes the derivative of the rotation in the frame's axes, 3 rows.
  template <class S>
  void write_rotation(const ResidualInput<S>& in, S* jacobian) const {
    write(in, 3, jacobian, [&](S* out) {
      if (!pair_.base) return frame_rotation_jacobian(robot(), data(in), pair_.frame, out);
      for_each_column(in, [&](int c, const Motion<S>& move) { put(move.angular, out + 3 * c); });
    });
  }
  /// Writes the derivatives of the velocity by the configuration and by the velocity, 6 rows each.
  template <class S>
  void write_velocity_q(const ResidualInput<S>& in, FrameAxes axes, S* jacobian) const {
    write(in, 6, jacobian, [&](S* out) {
      if (!pair_.base) return frame_velocity_derivative(robot(), data(in), pair_.frame, axes, out);
      relative_velocity_derivative(robot(), data(in), pair_, out);
      if (axes == FrameAxes::local) return;
      const Matrix3<S> R = placement(in).R;
      const Motion<S> v = velocity(in, FrameAxes::local);
      for_each_column(in, [&](int c, const Motion<S>& move) {
        S* column = out + 6 * c;
        const Vector3<S>& turn = move.angular;
        put(R * (Vector3<S>{column[0], column[1], column[2]} + cross(turn, v.linear)), column);
        put(R * (Vector3<S>{column[3], column[4], column[5]} + cross(turn, v.angular)), column + 3);
      });
    });
  }
  template <class S>
  void write_velocity_v(const ResidualInput<S>& in, FrameAxes axes, S* jacobian) const {
    write(in, 6, jacobian, [&](S* out) {
      if (!pair_.base) return frame_jacobian(robot(), data(in), pair_.frame, axes, out);
      if (axes == FrameAxes::local) return relative_jacobian(robot(), data(in), pair_, out);
      const Matrix3<S> R = placement(in).R;
      for_each_column(in, [&](int c, const Motion<S>& move) {
        put(R * move.linear, out + 6 * c);
        put(R * move.angular, out + 6 * c + 3);
      });
    });
  }

 private:
  template <class S>
  static void put(const Vector3<S>& v, S* out) {
    for (int i = 0; i < 3; ++i) out[i] = v[i];
  }
  /// Calls act(column, relative motion in the frame's axes) for the robot's own columns.
  template <class S, class F>
  void for_each_column(const ResidualInput<S>& in, F act) const {
    S* jacobian = multibody_data(in).frame_columns.data();
    relative_jacobian(robot(), data(in), pair_, jacobian);
    const int count = RelativeColumns(robot(), pair_).count();
    for (int c = 0; c < count; ++c, jacobian += 6)
      act(c, Motion<S>{{jacobian[0], jacobian[1], jacobian[2]},
                       {jacobian[3], jacobian[4], jacobian[5]}});
  }
  template <class S, class Kernel>
  void write(const ResidualInput<S>& in, int rows, S* jacobian, Kernel kernel) const {
    write_columns(columns_, rows, multibody_data(in), jacobian, kernel);
  }

  SystemPointer system_;
  FramePair pair_;
  ReducedColumns columns_;
};

template <class S>
Quaternion<S> load_quaternion(const S* p) {
  return {p[0], p[1], p[2], p[3]};
}

class FramePosition : public ResidualBase<FramePosition> {
 public:
  explicit FramePosition(FrameOf frame)
      : ResidualBase({{3, frame.columns()}}, 3, false), frame_(std::move(frame)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Vector3<S> p = frame_.placement(in).p;
    for (int i = 0; i < 3; ++i) r[i] = p[i] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    frame_.write_position(in, jacobian);
  }

 private:
  FrameOf frame_;
};

class FrameRotation : public ResidualBase<FrameRotation> {
 public:
  explicit FrameRotation(FrameOf frame)
      : ResidualBase({{3, frame.columns()}}, 4, false), frame_(std::move(frame)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Quaternion<S> q = quaternion(frame_.placement(in).R);
    const Vector3<S> w = log_so3(conjugate(load_quaternion(in.parameters)) * q);
    for (int i = 0; i < 3; ++i) r[i] = w[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    frame_.write_rotation(in, jacobian);
    const Matrix3<S> inverse = inverse_right_jacobian_so3(Vector3<S>{r[0], r[1], r[2]});
    for (int c = 0; c < frame_.count(); ++c, jacobian += 3) {
      const Vector3<S> column = inverse * Vector3<S>{jacobian[0], jacobian[1], jacobian[2]};
      for (int i = 0; i < 3; ++i) jacobian[i] = column[i];
    }
  }

 private:
  FrameOf frame_;
};

class FramePlacement : public ResidualBase<FramePlacement> {
 public:
  explicit FramePlacement(FrameOf frame)
      : ResidualBase({{6, frame.columns()}}, 7, false), frame_(std::move(frame)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const SE3<S> m = frame_.placement(in);
    const S* p = in.parameters;
    const Motion<S> error = difference_se3(Pose<S>{{p[0], p[1], p[2]}, load_quaternion(p + 3)},
                                           Pose<S>{m.p, quaternion(m.R)});
    for (int i = 0; i < 6; ++i) r[i] = error[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    frame_.write_velocity_v(in, FrameAxes::local, jacobian);
    const Matrix6<S> inverse =
        inverse_right_jacobian_se3(Motion<S>{{r[0], r[1], r[2]}, {r[3], r[4], r[5]}});
    S old[6];
    for (int c = 0; c < frame_.count(); ++c, jacobian += 6) {
      for (int i = 0; i < 6; ++i) old[i] = jacobian[i];
      for (int i = 0; i < 6; ++i) {
        jacobian[i] = inverse(i, 0) * old[0];
        for (int k = 1; k < 6; ++k) jacobian[i] += inverse(i, k) * old[k];
      }
    }
  }

 private:
  FrameOf frame_;
};

class FrameVelocity : public ResidualBase<FrameVelocity> {
 public:
  FrameVelocity(FrameOf frame, FrameAxes axes)
      : ResidualBase({{6, frame.position_and_velocity_columns()}}, 6, false),
        frame_(std::move(frame)),
        axes_(axes) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Motion<S> v = frame_.velocity(in, axes_);
    for (int i = 0; i < 6; ++i) r[i] = v[i] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    frame_.write_velocity_q(in, axes_, jacobian);
    frame_.write_velocity_v(in, axes_, jacobian + 6 * frame_.count());
  }

 private:
  FrameOf frame_;
  FrameAxes axes_;
};

/// Directions of the velocity that a contact constrains: its normal and tangent, or the three axes.
std::vector<Vector3<double>> held_directions(const Contact& contact) {
  if (contact.kind == ContactKind::normal) return {contact.normal};
  if (contact.kind == ContactKind::planar) return {contact.normal, contact.tangent};
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

class ContactVelocity : public ResidualBase<ContactVelocity> {
 public:
  ContactVelocity(FrameOf frame, const Contact& contact)
      : ResidualBase({{contact.rows(), frame.position_and_velocity_columns()}}, 0, false),
        frame_(std::move(frame)),
        axes_(contact.axes),
        directions_(held_directions(contact)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Motion<S> v = frame_.velocity(in, axes_);
    const S rows[] = {v[0], v[1], v[2], v[3], v[4], v[5]};
    choose(rows, r);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    S* all = multibody_data(in).columns.data();
    const auto write_rows = [&] {
      for (int c = 0; c < frame_.count(); ++c, jacobian += size()) choose(all + 6 * c, jacobian);
    };
    frame_.write_velocity_q(in, axes_, all);
    write_rows();
    frame_.write_velocity_v(in, axes_, all);
    write_rows();
  }

 private:
  /// Selects the contact's rows from the six rows of a twist.
  template <class S>
  void choose(const S* twist, S* rows) const {
    for (const Vector3<double>& d : directions_)
      *rows++ = S(d.x) * twist[0] + S(d.y) * twist[1] + S(d.z) * twist[2];
    if (size() == 6)
      for (int i = 3; i < 6; ++i) *rows++ = twist[i];
  }

  FrameOf frame_;
  FrameAxes axes_;
  std::vector<Vector3<double>> directions_;
};

class CentroidalMomentum : public ResidualBase<CentroidalMomentum> {
 public:
  explicit CentroidalMomentum(SystemPointer system)
      : ResidualBase({{6, column_range(0, system->ndx())}}, 6, false),
        system_(std::move(system)),
        columns_(system_->mimic_map(), column_range(0, system_->robot().nv)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Force<S> h = centroidal_momentum(system_->robot(), FrameOf::data(in));
    for (int i = 0; i < 6; ++i) r[i] = h[i] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    auto& data = multibody_data(in);
    S* wrt_v = jacobian + 6 * columns_.count();
    if (columns_.identity())
      return centroidal_momentum_derivatives(system_->robot(), data.robot, jacobian, wrt_v);
    S* full_q = data.mimic.columns.data();
    S* full_v = data.columns.data();
    centroidal_momentum_derivatives(system_->robot(), data.robot, full_q, full_v);
    columns_.gather(full_q, 6, jacobian);
    columns_.gather(full_v, 6, wrt_v);
  }

 private:
  SystemPointer system_;
  ReducedColumns columns_;
};

class ComPosition : public ResidualBase<ComPosition> {
 public:
  explicit ComPosition(SystemPointer system)
      : ResidualBase({{3, column_range(0, system->nv())}}, 3, false),
        system_(std::move(system)),
        columns_(system_->mimic_map(), column_range(0, system_->robot().nv)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const Vector3<S> c = center_of_mass(system_->robot(), FrameOf::data(in));
    for (int i = 0; i < 3; ++i) r[i] = c[i] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    write_columns(columns_, 3, multibody_data(in), jacobian, [&](S* out) {
      center_of_mass_jacobian(system_->robot(), FrameOf::data(in), out);
    });
  }

 private:
  SystemPointer system_;
  ReducedColumns columns_;
};

class ControlGravity : public ResidualBase<ControlGravity> {
 public:
  ControlGravity(SystemPointer system, int ndx)
      : ResidualBase({{static_cast<int>(system->actuated_rows().size()), columns(*system, ndx)}}, 0,
                     true),
        system_(std::move(system)),
        rows_(system_->actuated_rows()) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    auto& data = multibody_data(in);
    system_->gravity_torques(data, false);
    effort(in, data, r);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    auto& data = multibody_data(in);
    system_->gravity_torques(data, true);
    effort(in, data, r);
    const int nv = system_->nv();
    for (int c = 0; c < nv; ++c)
      for (int row : rows_) *jacobian++ = -data.gravity_q[c * nv + row];
    for (int c = 0; c < system_->nu(); ++c)
      for (int row : rows_) *jacobian++ = S(system_->actuation().B[c * nv + row]);
  }

 private:
  template <class S>
  void effort(const ResidualInput<S>& in, const MultibodySystem::Data<S>& data, S* r) const {
    const int nv = system_->nv();
    for (int row : rows_) {
      *r = -data.gravity[row];
      for (int c = 0; c < system_->nu(); ++c)
        *r += in.u[c] * S(system_->actuation().B[c * nv + row]);
      ++r;
    }
  }
  static std::vector<int> columns(const MultibodySystem& system, int ndx) {
    std::vector<int> all = column_range(0, system.nv());
    for (int c : column_range(ndx, system.nu())) all.push_back(c);
    return all;
  }
  SystemPointer system_;
  std::vector<int> rows_;
};

}  // namespace

std::shared_ptr<const Residual> frame_position_residual(const SystemPointer& system,
                                                        const FramePair& frame) {
  return std::make_shared<FramePosition>(FrameOf(system, frame));
}
std::shared_ptr<const Residual> frame_rotation_residual(const SystemPointer& system,
                                                        const FramePair& frame) {
  return std::make_shared<FrameRotation>(FrameOf(system, frame));
}
std::shared_ptr<const Residual> frame_placement_residual(const SystemPointer& system,
                                                         const FramePair& frame) {
  return std::make_shared<FramePlacement>(FrameOf(system, frame));
}
std::shared_ptr<const Residual> frame_velocity_residual(const SystemPointer& system,
                                                        const FramePair& frame, FrameAxes axes) {
  return std::make_shared<FrameVelocity>(FrameOf(system, frame), axes);
}
std::shared_ptr<const Residual> contact_velocity_residual(const SystemPointer& system,
                                                          const Contact& contact) {
  return std::make_shared<ContactVelocity>(FrameOf(system, contact.pair()), contact);
}
std::shared_ptr<const Residual> centroidal_momentum_residual(const SystemPointer& system) {
  return std::make_shared<CentroidalMomentum>(system);
}
std::shared_ptr<const Residual> com_position_residual(const SystemPointer& system) {
  return std::make_shared<ComPosition>(system);
}
std::shared_ptr<const Residual> control_gravity_residual(const SystemPointer& system, int ndx) {
  return std::make_shared<ControlGravity>(system, ndx);
}

}  // namespace conddp
