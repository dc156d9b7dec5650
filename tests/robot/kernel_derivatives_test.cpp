#include <gtest/gtest.h>

#include "robot/dynamics.hpp"
#include "support/kernel_probe.hpp"

// First derivatives of the kernels, compared with dual numbers through the same kernels, which are
// exact, at random states with any base rotation.

namespace conddp {
namespace {

constexpr double kTolerance = 1e-11;

using D = Dual<double>;

/// Derivatives of all quantities along the tangent direction (dq, dv), with the other inputs fixed.
class Slope {
 public:
  Slope(const RobotModel& model, const RobotState& x, const std::vector<double>& dq,
        const std::vector<double>& dv)
      : probe_(model, seeded(model, x, dq, dv)) {}

  std::vector<double> operator[](const std::string& name) const {
    std::vector<double> slopes;
    for (const D& value : probe_[name]) slopes.push_back(value.d);
    return slopes;
  }

 private:
  static ProbeState<D> seeded(const RobotModel& model, const RobotState& x,
                              const std::vector<double>& dq, const std::vector<double>& dv) {
    ProbeState<D> state = ProbeState<D>::at(x);
    std::vector<D> step(model.nv);
    for (int i = 0; i < model.nv; ++i) {
      step[i] = D(0.0, dq[i]);
      state.v[i].d = dv[i];
    }
    state.q = move_configuration(model, state.q, step);
    return state;
  }

  KernelProbe<D> probe_;
};

/// Slopes along every unit direction of the configuration or the velocity.
class Gradient {
 public:
  enum class Of { configuration, velocity };
  Gradient(const RobotModel& model, const RobotState& x, Of of) {
    const std::vector<double> zero(model.nv);
    for (int k = 0; k < model.nv; ++k) {
      std::vector<double> unit(model.nv);
      unit[k] = 1;
      slopes_.emplace_back(model, x, of == Of::configuration ? unit : zero,
                           of == Of::velocity ? unit : zero);
    }
  }
  /// Column-major, one column per direction.
  std::vector<double> operator[](const std::string& name) const {
    std::vector<double> all;
    for (const Slope& slope : slopes_) {
      const std::vector<double> column = slope[name];
      all.insert(all.end(), column.begin(), column.end());
    }
    return all;
  }

 private:
  std::vector<Slope> slopes_;
};

class KernelDerivatives : public testing::TestWithParam<std::size_t> {
 protected:
  const TestModel& entry() const { return kernel_models()[GetParam()]; }
  const RobotModel& model() const { return entry().model; }

  /// Calls test(state, analytic quantities) in several states.
  template <class F>
  void in_random_states(F test) const {
    RandomNumbers random(100 + GetParam());
    for (int i = 0; i < 2; ++i) {
      const RobotState x = random_state(model(), random);
      const KernelProbe<double> analytic(model(), ProbeState<double>::at(x));
      test(x, analytic);
      if (testing::Test::HasFailure()) return;
    }
  }
  template <class F>
  void for_each_frame(F test) const {
    for (int f = 0; f < static_cast<int>(model().frames.size()); ++f) test(std::to_string(f));
  }
};

TEST_P(KernelDerivatives, InverseDynamics) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    const Gradient wrt_v(model(), x, Gradient::Of::velocity);
    expect_close(analytic["tau_q"], wrt_q["tau"], kTolerance, "tau_q");
    expect_close(analytic["tau_v"], wrt_v["tau"], kTolerance, "tau_v");
  });
}

// Rows of the derivatives and of M, contracted with w.
TEST_P(KernelDerivatives, GradientOfWeightedInverseDynamics) {
  RobotModel free = model();
  free.wrenches.clear();
  const int n = free.nv;
  RandomNumbers random(55 + GetParam());
  const RobotState x = random_state(free, random);
  const std::vector<double> w = random.numbers(n, 1);
  RobotData<double> data(free);
  forward_dynamics(free, x.q.data(), x.v.data(), x.tau.data(), data);
  AlignedVector<Force<double>> applied;
  for (int i = 0; i < free.joint_count(); ++i)
    applied.push_back({random.vector(3), random.vector(3)});
  inverse_dynamics_derivatives(free, x.v.data(), data, &applied);
  std::vector<double> expected_q(n), expected_v(n), expected_a(n);
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < n; ++r) {
      expected_q[c] += w[r] * data.tau_q[c * n + r];
      expected_v[c] += w[r] * data.tau_v[c * n + r];
      expected_a[c] += w[r] * data.M[std::min(r, c) * n + std::max(r, c)];
    }
  InverseDynamicsGradient<double> gradient(free);
  inverse_dynamics_gradient(free, x.v.data(), w.data(), data, &applied, gradient);
  const auto numbers = [](const AlignedVector<double>& a) {
    return std::vector<double>(a.begin(), a.end());
  };
  expect_close(numbers(gradient.wrt_q), expected_q, kTolerance, "by q");
  expect_close(numbers(gradient.wrt_v), expected_v, kTolerance, "by v");
  expect_close(numbers(gradient.wrt_a), expected_a, kTolerance, "by a");
}

// a(q, v, τ) from M a = τ − bias: a_q = −M⁻¹ τ_q and a_v = −M⁻¹ τ_v at that acceleration.
TEST_P(KernelDerivatives, ForwardDynamics) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>&) {
    const int n = model().nv;
    RobotData<double> data(model());
    forward_dynamics(model(), x.q.data(), x.v.data(), x.tau.data(), data);
    inverse_dynamics_derivatives(model(), x.v.data(), data);
    std::vector<double> a_q, a_v;
    for (const auto& [in, out] : {std::pair{&data.tau_q, &a_q}, std::pair{&data.tau_v, &a_v}}) {
      for (const double entry : *in) out->push_back(-entry);
      for (int k = 0; k < n; ++k) solve_mass_matrix(model(), data, out->data() + k * n);
    }
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    const Gradient wrt_v(model(), x, Gradient::Of::velocity);
    expect_close(a_q, wrt_q["acceleration"], 1e-10, "a_q");
    expect_close(a_v, wrt_v["acceleration"], 1e-10, "a_v");
  });
}

TEST_P(KernelDerivatives, GravityTorques) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    expect_close(analytic["gravity torques_q"], wrt_q["gravity torques"], kTolerance, "gravity");
  });
}

TEST_P(KernelDerivatives, CenterOfMassAndMomentum) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    const Gradient wrt_v(model(), x, Gradient::Of::velocity);
    expect_close(analytic["com jacobian"], wrt_q["com"], kTolerance, "com");
    expect_close(analytic["momentum_q"], wrt_q["momentum"], kTolerance, "momentum_q");
    expect_close(analytic["momentum_v"], wrt_v["momentum"], kTolerance, "momentum_v");
  });
}

TEST_P(KernelDerivatives, FramePlacementIsTheLocalJacobian) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    for_each_frame([&](const std::string& id) {
      Matrix3<double> r;
      std::copy_n(analytic["rotation " + id].begin(), 9, r.m);
      const std::vector<double> position = wrt_q["position " + id];
      const std::vector<double> rotation = wrt_q["rotation " + id];
      std::vector<double> twists;
      for (int k = 0; k < model().nv; ++k) {
        const double* p = &position[3 * k];
        Matrix3<double> dr;
        std::copy_n(&rotation[9 * k], 9, dr.m);
        const Matrix3<double> turn = transpose(r) * dr;  // skew matrix of the angular part
        const Vector3<double> linear = transpose_times(r, Vector3<double>{p[0], p[1], p[2]});
        const double twist[] = {linear.x, linear.y, linear.z, turn(2, 1), turn(0, 2), turn(1, 0)};
        twists.insert(twists.end(), std::begin(twist), std::end(twist));
      }
      expect_close(analytic["jacobian local " + id], twists, kTolerance, "frame " + id);
    });
  });
}

TEST_P(KernelDerivatives, FrameVelocity) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    const Gradient wrt_v(model(), x, Gradient::Of::velocity);
    for (const char* axes : {"local ", "world "})
      for_each_frame([&](const std::string& id) {
        const std::string in = axes + id;
        expect_close(analytic["velocity_q " + in], wrt_q["velocity " + in], kTolerance,
                     "velocity_q " + in);
        expect_close(analytic["jacobian " + in], wrt_v["velocity " + in], kTolerance,
                     "velocity_v " + in);
      });
  });
}

// Parts that only position and rotation residuals read.
TEST_P(KernelDerivatives, PartsOfTheFrameJacobian) {
  in_random_states([&](const RobotState&, const KernelProbe<double>& analytic) {
    for (int f = 0; f < static_cast<int>(model().frames.size()); ++f) {
      const std::string id = std::to_string(f);
      const std::vector<int> columns = support(model(), model().frames[f].joint);
      std::vector<double> position(3 * columns.size()), rotation(position);
      frame_position_jacobian(model(), analytic.data(), f, position.data());
      frame_rotation_jacobian(model(), analytic.data(), f, rotation.data());
      std::vector<double> linear, angular;
      for (const int k : columns)
        for (int i = 0; i < 3; ++i) {
          linear.push_back(analytic["jacobian world " + id][6 * k + i]);
          angular.push_back(analytic["jacobian local " + id][6 * k + 3 + i]);
        }
      expect_close(position, linear, kTolerance, "position of frame " + id);
      expect_close(rotation, angular, kTolerance, "rotation of frame " + id);
    }
  });
}

TEST_P(KernelDerivatives, FrameAcceleration) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Gradient wrt_q(model(), x, Gradient::Of::configuration);
    const Gradient wrt_v(model(), x, Gradient::Of::velocity);
    for_each_frame([&](const std::string& id) {
      expect_close(analytic["acceleration_q " + id], wrt_q["acceleration local " + id], kTolerance,
                   "acceleration_q " + id);
      expect_close(analytic["acceleration_v " + id], wrt_v["acceleration local " + id], kTolerance,
                   "acceleration_v " + id);
    });
  });
}

// Along the motion q̇ = v, v̇ = a.
TEST_P(KernelDerivatives, RatesInTime) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    const Slope rate(model(), x, x.v, x.a);
    for_each_frame([&](const std::string& id) {
      expect_close(analytic["acceleration local " + id], rate["velocity local " + id], kTolerance,
                   "acceleration " + id);
    });
  });
}

// The power of the joints and external wrenches equals the rate of kinetic and potential energy.
TEST_P(KernelDerivatives, EnergyBalance) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& analytic) {
    double power = 0, size = 1;
    for (int i = 0; i < model().nv; ++i) {
      power += x.v[i] * analytic["tau"][i];
      size += std::abs(x.v[i] * analytic["tau"][i]);
    }
    for (const ExternalWrench& w : model().wrenches) {
      const std::vector<double>& twist = analytic["velocity world " + std::to_string(w.frame)];
      for (int i = 0; i < 6; ++i) power += twist[i] * w.wrench[i];
    }
    const std::vector<double> rate = Slope(model(), x, x.v, x.a)["energy"];
    EXPECT_NEAR(rate[0] + rate[1], power, 1e-12 * size);
  });
}

INSTANTIATE_TEST_SUITE_P(AllRobots, KernelDerivatives,
                         testing::Range<std::size_t>(0, kernel_models().size()),
                         [](const auto& suite) { return kernel_models()[suite.param].name; });

}  // namespace
}  // namespace conddp
