#include "robot/contact.hpp"

#include <gtest/gtest.h>

#include "support/kernel_probe.hpp"
#include "support/random_contact.hpp"

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
        // Distances stay within the smooth range of the logarithm.
        RobotData<double> data(entry.model);
        update_placements(entry.model, x.q.data(), data);
        const Pose<double> off = integrate_se3(Pose<double>{{0, 0, 0}, {0, 0, 0, 1}},
                                               Motion<double>{random.vector(1), random.vector(1)});
        contact.reference = frame_placement(entry.model, data, frame) * placement(off);
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

/// Jacobian of the rows times the generalized velocity.
template <class S>
std::vector<S> velocity_rows(const RobotModel& model, const Contact& contact,
                             const AlignedVector<S>& jacobian, const std::vector<S>& v) {
  const int rows = contact.rows();
  std::vector<S> sum(rows, S(0.0));
  const std::vector<int> columns = support(model, model.frames[contact.frame].joint);
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
  });
}

TEST_P(ContactRows, MatchTheFrameVelocity) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const FrameAxes world = FrameAxes::world_aligned;
    const Motion<double> v = frame_velocity(model, touch.data, contact.frame, world);
    const std::vector<double> expected =
        contact.kind == ContactKind::surface
            ? components(frame_velocity(model, touch.data, contact.frame, FrameAxes::local))
            : rows_of_point(contact, touch.at.world.R, v.linear);
    expect_close(velocity_rows(model, contact, touch.at.jacobian, x.v), expected, kRowTolerance,
                 "velocity");
  });
}

TEST_P(ContactRows, MatchTheStabilizedFrameAcceleration) {
  everywhere([](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const auto frame_motions = [&](FrameAxes axes) {
      return std::pair{frame_velocity(model, touch.data, contact.frame, axes),
                       frame_acceleration(model, touch.data, contact.frame, axes)};
    };
    std::vector<double> expected;
    if (contact.kind == ContactKind::surface) {
      const auto [v, a] = frame_motions(FrameAxes::local);
      const Motion<double> error =
          difference_se3(Pose<double>{contact.reference.p, quaternion(contact.reference.R)},
                         Pose<double>{touch.at.world.p, quaternion(touch.at.world.R)});
      expected = components(a + contact.kd * v + contact.kp * error);
    } else {
      const auto [v, a] = frame_motions(FrameAxes::world_aligned);
      const Vector3<double> error = touch.at.world.p - contact.reference.p;
      expected = rows_of_point(
          contact, touch.at.world.R,
          a.linear + cross(v.angular, v.linear) + contact.kd * v.linear + contact.kp * error);
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
    const std::vector<int> columns = support(model, model.frames[contact.frame].joint);
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
    for (const int k : support(model, model.frames[contact.frame].joint)) {
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
    for (int j = 0; j < model.joint_count(); ++j)
      EXPECT_NEAR(dot(touch.data.v[j], wrenches[j] - before), j == touched ? power : 0,
                  kRowTolerance * (100 + std::abs(power)));

    const Force<double> in_world = contact_force_in_world(touch.at);
    const Motion<double> twist =
        frame_velocity(model, touch.data, contact.frame, FrameAxes::world_aligned);
    EXPECT_NEAR(dot(twist, in_world), power, kRowTolerance * (100 + std::abs(power)));
  });
}

// Jᵀ·(forces of the rows) for directions fixed in the world, minus the same wrench fixed in the
// body.
TEST_P(ContactRows, TurnTheirDirectionsAgainstTheBody) {
  RandomNumbers random(702);
  everywhere([&](const RobotModel& model, const RobotState& x, const Contact& contact) {
    const int n = model.nv, rows = contact.rows();
    Touch<double> touch(model, contact, ProbeState<double>::at(x));
    const std::vector<double> forces = random.numbers(rows, 10);
    set_contact_force(contact, forces.data(), touch.at);
    const std::vector<int> columns = support(model, model.frames[contact.frame].joint);

    const std::vector<double> before = random.numbers(n * n, 1);
    std::vector<double> expected = before;
    for (const int k : columns) {
      const Touch<Dual<double>> moved(model, contact,
                                      moving_along(model, x, Along::configuration, k));
      for (std::size_t c = 0; c < columns.size(); ++c) {
        double change = 0;
        for (int i = 0; i < rows; ++i) change += forces[i] * moved.at.jacobian[rows * c + i].d;
        for (int i = 0; i < 6; ++i)
          change -= touch.at.local[i] * moved.at.frame_jacobian[6 * c + i].d;
        expected[k * n + columns[c]] -= change;
      }
    }
    AlignedVector<double> tau_q(before.begin(), before.end());
    subtract_direction_derivative(model, contact, touch.at, tau_q);
    expect_close({tau_q.begin(), tau_q.end()}, expected, kRowTolerance, "derivative");

    const std::vector<double> w = random.numbers(n, 1), start = random.numbers(n, 1);
    std::vector<double> contracted = start;
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < n; ++i) contracted[k] += w[i] * (expected[k * n + i] - before[k * n + i]);
    AlignedVector<double> gradient(start.begin(), start.end());
    subtract_direction_gradient(model, contact, touch.at, w.data(), gradient);
    expect_close({gradient.begin(), gradient.end()}, contracted, kRowTolerance, "gradient");
  });
}

INSTANTIATE_TEST_SUITE_P(All, ContactRows, testing::ValuesIn(kSettings),
                         [](const auto& suite) { return std::string(suite.param.name); });

}  // namespace
}  // namespace conddp
