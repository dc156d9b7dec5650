#include "robot/contact.hpp"

#include <gtest/gtest.h>

#include "support/kernel_probe.hpp"
#include "support/random_contact.hpp"
#include "support/relative_frame.hpp"

// Contact rows, compared with the motion of their frames at random states with any base rotation.
// Derivatives are compared with dual numbers.

namespace conddp {
namespace {

constexpr double kRowTolerance = 1e-11;

/// Robot data with everything that contacts read up to date.
template <class S>
RobotData<S> moving_data(const RobotModel& model, const ProbeState<S>& x) {
  RobotData<S> data(model);
  inverse_dynamics(model, x.q.data(), x.v.data(), x.a.data(), data);
  update_derivative_columns(model, data);
  return data;
}

/// Direction of differentiation: the k-th direction of the configuration or of the velocity.
enum class Along { configuration, velocity };
ProbeState<Dual<double>> moving_along(const RobotModel& model, const RobotState& x, Along along,
                                      int k) {
  auto state = ProbeState<Dual<double>>::at(x);
  if (along == Along::velocity) {
    state.v[k].d = 1;
    return state;
  }
  std::vector<Dual<double>> step(model.nv, Dual<double>(0.0));
  step[k].d = 1;
  state.q = move_configuration(model, state.q, step);
  return state;
}

/// A contact in a state.
template <class S>
struct Touch {
  Touch(const RobotModel& model, const Contact& contact, const ProbeState<S>& x)
      : data(moving_data(model, x)), at(model, contact) {
    update_contact(model, contact, data, at);
  }
  RobotData<S> data;
  ContactData<S> at;
};

struct ContactSetting {
  const char* name;
  ContactKind kind;
  FrameAxes axes;
  bool position_gain;
  bool loop = false;  ///< the base is another frame
};

constexpr ContactSetting kSettings[] = {
    {"normal_in_the_world", ContactKind::normal, FrameAxes::world_aligned, true},
    {"normal_of_the_body", ContactKind::normal, FrameAxes::local, true},
    {"planar_in_the_world", ContactKind::planar, FrameAxes::world_aligned, true},
    {"planar_of_the_body", ContactKind::planar, FrameAxes::local, false},
    {"point", ContactKind::point, FrameAxes::world_aligned, true},
    {"point_without_reference", ContactKind::point, FrameAxes::local, false},
    {"surface", ContactKind::surface, FrameAxes::local, true},
    {"surface_without_reference", ContactKind::surface, FrameAxes::world_aligned, false},
    {"normal_of_a_base", ContactKind::normal, FrameAxes::world_aligned, true, true},
    {"planar_of_the_body_on_a_base", ContactKind::planar, FrameAxes::local, true, true},
    {"planar_on_a_base", ContactKind::planar, FrameAxes::world_aligned, false, true},
    {"point_on_a_base", ContactKind::point, FrameAxes::local, true, true},
    {"surface_on_a_base", ContactKind::surface, FrameAxes::local, true, true},
    {"surface_without_reference_on_a_base", ContactKind::surface, FrameAxes::local, false, true},
};

class ContactRows : public testing::TestWithParam<ContactSetting> {
 protected:
  /// Calls test(model, state, contact) for frames of all random robots.
  template <class F>
  void everywhere(F test) const {
    RandomNumbers random(700);
    for (const TestModel& entry : random_robots()) {
      const std::vector<int> frames = moving_frames(entry.model);
      for (int i = 0; i < 2; ++i) {
        const RobotState x = random_state(entry.model, random);
        const int frame = frames[random.index(static_cast<int>(frames.size()))];
        Contact contact = random_contact(frame, GetParam().kind, GetParam().axes, random);
        contact.kp = GetParam().position_gain ? contact.kp + 1 : 0;
        if (GetParam().loop) {
          contact.base = frame_elsewhere(entry.model, frame, random.index(100), 3);
          if (!contact.base) continue;
        }
        // Distances stay within the smooth range of the logarithm.
        RobotData<double> data(entry.model);
        update_placements(entry.model, x.q.data(), data);
        const Pose<double> off = integrate_se3(Pose<double>{{0, 0, 0}, {0, 0, 0, 1}},
                                               Motion<double>{random.vector(1), random.vector(1)});
        update_velocities(entry.model, x.v.data(), data);
        contact.reference =
            RelativeFrame<double>(entry.model, data, contact).placement * placement(off);
        test(entry.model, x, contact);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
};

std::vector<double> components(const Vector3<double>& a) { return {a.x, a.y, a.z}; }
std::vector<double> components(const Motion<double>& m) {
  std::vector<double> all;
  for (int i = 0; i < 6; ++i) all.push_back(m[i]);
  return all;
}

/// Rows of a contact-point vector given in world axes.
std::vector<double> rows_of_point(const Contact& contact, const Matrix3<double>& frame_axes,
                                  const Vector3<double>& in_world) {
  const Vector3<double> local = transpose_times(frame_axes, in_world);
  if (contact.kind == ContactKind::point) return components(local);
  const Vector3<double>& seen = contact.axes == FrameAxes::local ? local : in_world;
  std::vector<double> rows{dot(contact.normal, seen)};
  if (contact.kind == ContactKind::planar) rows.push_back(dot(contact.tangent, seen));
  return rows;
}

/// Rates of RelativeFrame's velocity of the point, in the axes of the base, and of its twist, in
/// the axes of the frame. By the rules for rotating axes.
struct RelativeAcceleration {
  Vector3<double> of_point;
  Motion<double> of_twist;

  RelativeAcceleration(const RobotModel& model, const RobotData<double>& data,
                       const Contact& contact) {
    const auto rate_in_world = [&](std::optional<int> frame) {
      if (!frame) return Motion<double>::zero();
      const FrameInWorld<double> at(model, data, *frame);
      Motion<double> a = frame_acceleration(model, data, *frame, FrameAxes::world_aligned);
      a.linear += cross(at.v.angular, at.v.linear);
      return a;
    };
    const FrameInWorld<double> frame(model, data, contact.frame);
    const FrameInWorld<double> base =
        contact.base ? FrameInWorld<double>(model, data, *contact.base) : FrameInWorld<double>();
    const Motion<double> a = rate_in_world(contact.frame) - rate_in_world(contact.base);
    const Vector3<double> turn = base.v.angular, lever = frame.placement.p - base.placement.p;
    const Vector3<double> v = frame.v.linear - base.v.linear, seen = v - cross(turn, lever);
    const Vector3<double> rate =
        a.linear - cross(rate_in_world(contact.base).angular, lever) - cross(turn, v);
    of_point = transpose_times(base.placement.R, rate - cross(turn, seen));
    const Vector3<double>& own = frame.v.angular;
    of_twist = {transpose_times(frame.placement.R, rate - cross(own, seen)),
                transpose_times(frame.placement.R, a.angular - cross(own, own - turn))};
  }
};

/// Jacobian of the rows times the generalized velocity.
template <class S>
std::vector<S> velocity_rows(const RobotModel& model, const Contact& contact,
                             const AlignedVector<S>& jacobian, const std::vector<S>& v) {
  const int rows = contact.rows();
  std::vector<S> sum(rows, S(0.0));
  const std::vector<int> columns = support(model, contact.pair());
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (int i = 0; i < rows; ++i) sum[i] += jacobian[rows * c + i] * v[columns[c]];
  return sum;
}

std::vector<double> slopes(const std::vector<Dual<double>>& duals) {
  std::vector<double> all;
  for (const Dual<double>& dual : duals) all.push_back(dual.d);
  return all;
}

TEST_P(ContactRows, FollowTheFrame) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const SE3<double> world = frame_placement(model, touch.data, contact.frame);
    expect_close(components(touch.at.world.p), components(world.p), kRowTolerance, "position");
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(touch.at.world.R.m[i], world.R.m[i], kRowTolerance);
    const SE3<double> back =
        touch.data.root_pose(model, model.frames[contact.frame].joint) * touch.at.placement;
    expect_close(components(back.p), components(world.p), kRowTolerance, "from the root frame");
    const SE3<double> relative = RelativeFrame<double>(model, touch.data, contact).placement;
    expect_close(components(touch.at.relative.p), components(relative.p), kRowTolerance, "in base");
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(touch.at.relative.R.m[i], relative.R.m[i], kRowTolerance);
  });
}

TEST_P(ContactRows, MatchTheFrameVelocity) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const RelativeFrame<double> frame(model, touch.data, contact);
    const std::vector<double> expected =
        contact.kind == ContactKind::surface
            ? components(frame.twist())
            : rows_of_point(contact, frame.placement.R, frame.v.linear);
    expect_close(velocity_rows(model, contact, touch.at.jacobian, x.v), expected, kRowTolerance,
                 "velocity");
  });
}

TEST_P(ContactRows, MatchTheStabilizedFrameAcceleration) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const RelativeFrame<double> frame(model, touch.data, contact);
    const RelativeAcceleration rate(model, touch.data, contact);
    std::vector<double> expected;
    if (contact.kind == ContactKind::surface) {
      const SE3<double>& m = frame.placement;
      const Motion<double> error =
          difference_se3(Pose<double>{contact.reference.p, quaternion(contact.reference.R)},
                         Pose<double>{m.p, quaternion(m.R)});
      expected = components(rate.of_twist + contact.kd * frame.twist() + contact.kp * error);
    } else {
      const Vector3<double> error = frame.placement.p - contact.reference.p;
      expected = rows_of_point(contact, frame.placement.R,
                               rate.of_point + contact.kd * frame.v.linear + contact.kp * error);
    }
    std::vector<double> rows(contact.rows());
    contact_acceleration(model, contact, touch.data, touch.at, rows.data());
    expect_close(rows, expected, kRowTolerance, "acceleration");
  });
}

TEST_P(ContactRows, AccelerationDerivativesMatchDualNumbers) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    Touch<double> touch(model, contact, ProbeState<double>::at(x));
    contact_acceleration_derivatives(model, contact, touch.data, touch.at);
    const std::vector<int> columns = support(model, contact.pair());
    std::vector<double> by_q, by_v;
    for (auto [along, all] :
         {std::pair{Along::configuration, &by_q}, std::pair{Along::velocity, &by_v}})
      for (const int k : columns) {
        const Touch<Dual<double>> moved(model, contact, moving_along(model, x, along, k));
        std::vector<Dual<double>> rows(contact.rows());
        contact_acceleration(model, contact, moved.data, moved.at, rows.data());
        for (const double slope : slopes(rows)) all->push_back(slope);
      }
    expect_close({touch.at.wrt_q.begin(), touch.at.wrt_q.end()}, by_q, kRowTolerance, "by q");
    expect_close({touch.at.wrt_v.begin(), touch.at.wrt_v.end()}, by_v, kRowTolerance, "by v");
  });
}

TEST_P(ContactRows, VelocityDerivativesMatchDualNumbers) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    Touch<double> touch(model, contact, ProbeState<double>::at(x));
    contact_velocity_derivative(model, contact, touch.data, touch.at);
    std::vector<double> by_q;
    for (const int k : support(model, contact.pair())) {
      const auto state = moving_along(model, x, Along::configuration, k);
      const Touch<Dual<double>> moved(model, contact, state);
      for (const double slope : slopes(velocity_rows(model, contact, moved.at.jacobian, state.v)))
        by_q.push_back(slope);
    }
    expect_close({touch.at.wrt_q.begin(), touch.at.wrt_q.end()}, by_q, kRowTolerance, "by q");
  });
}

// The power of the contact wrench on its body equals that of the row forces.
TEST_P(ContactRows, ForcesHaveThePowerOfTheirRows) {
  RandomNumbers random(701);
  everywhere([&](const RobotModel& model, const RobotState& x, const Contact& contact) {
    Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const std::vector<double> forces = random.numbers(contact.rows(), 10);
    set_contact_force(contact, forces.data(), touch.at);
    const std::vector<double> v = velocity_rows(model, contact, touch.at.jacobian, x.v);
    double power = 0;
    for (int i = 0; i < contact.rows(); ++i) power += forces[i] * v[i];

    const Force<double> before{random.vector(3), random.vector(3)};
    AlignedVector<Force<double>> wrenches(model.joint_count(), before);
    add_contact_wrench(model, contact, touch.at, wrenches);
    const int touched = model.frames[contact.frame].joint;
    const int base = contact.base ? model.frames[*contact.base].joint : -1;
    const double tolerance = kRowTolerance * (100 + std::abs(power));
    double sum = 0;
    for (int j = 0; j < model.joint_count(); ++j) {
      const double own = dot(touch.data.v[j], wrenches[j] - before);
      if (j != touched && j != base) {
        EXPECT_EQ(own, 0);
      }
      sum += own;
    }
    EXPECT_NEAR(sum, power, 10 * tolerance);

    const Force<double> in_world = contact_force_in_world(touch.at);
    const RelativeFrame<double> frame(model, touch.data, contact);
    const Motion<double> twist = frame.twist();
    const Matrix3<double>& R = touch.at.world.R;
    EXPECT_NEAR(dot(Motion<double>{R * twist.linear, R * twist.angular}, in_world), power,
                tolerance);
  });
}

/// Derivative of the generalized forces of a contact's wrenches, fixed in the bodies as they are at
/// `touch`.
std::vector<double> slope_of_fixed_wrenches(const RobotModel& model, const Contact& contact,
                                            const Touch<double>& touch,
                                            const Touch<Dual<double>>& moved) {
  std::vector<double> slope(model.nv, 0.0);
  const auto add = [&](int frame, const Force<double>& local) {
    const std::vector<int> columns = support(model, model.frames[frame].joint);
    std::vector<Dual<double>> J(6 * columns.size());
    frame_jacobian(model, moved.data, frame, FrameAxes::local, J.data());
    for (std::size_t c = 0; c < columns.size(); ++c)
      for (int i = 0; i < 6; ++i) slope[columns[c]] += local[i] * J[6 * c + i].d;
  };
  add(contact.frame, touch.at.local);
  if (contact.base && model.frames[*contact.base].joint >= 0)
    add(*contact.base, Force<double>::zero() - act(touch.at.relative, touch.at.local));
  return slope;
}

// Jᵀ·(forces of the rows), minus the same wrenches fixed in their bodies.
TEST_P(ContactRows, TurnAndMoveAgainstTheBodies) {
  RandomNumbers random(702);
  everywhere([&](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const int n = model.nv, rows = contact.rows();
    Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const std::vector<double> forces = random.numbers(rows, 10);
    set_contact_force(contact, forces.data(), touch.at);
    const std::vector<int> columns = support(model, contact.pair());

    const std::vector<double> before = random.numbers(n * n, 1);
    std::vector<double> expected = before;
    for (const int k : columns) {
      const Touch<Dual<double>> moved(model, contact,
                                      moving_along(model, x, Along::configuration, k));
      const std::vector<double> fixed = slope_of_fixed_wrenches(model, contact, touch, moved);
      for (std::size_t c = 0; c < columns.size(); ++c) {
        double change = 0;
        for (int i = 0; i < rows; ++i) change += forces[i] * moved.at.jacobian[rows * c + i].d;
        expected[k * n + columns[c]] -= change - fixed[columns[c]];
      }
    }
    AlignedVector<double> tau_q(before.begin(), before.end());
    subtract_contact_derivative(model, contact, touch.at, tau_q);
    expect_close({tau_q.begin(), tau_q.end()}, expected, kRowTolerance, "derivative");

    const std::vector<double> w = random.numbers(n, 1), start = random.numbers(n, 1);
    std::vector<double> contracted = start;
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < n; ++i) contracted[k] += w[i] * (expected[k * n + i] - before[k * n + i]);
    AlignedVector<double> gradient(start.begin(), start.end());
    subtract_contact_gradient(model, contact, touch.at, w.data(), gradient);
    expect_close({gradient.begin(), gradient.end()}, contracted, kRowTolerance, "gradient");
  });
}

INSTANTIATE_TEST_SUITE_P(All, ContactRows, testing::ValuesIn(kSettings),
                         [](const auto& suite) { return std::string(suite.param.name); });

}  // namespace
}  // namespace conddp
