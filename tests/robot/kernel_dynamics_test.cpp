#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/kernel_probe.hpp"

// Identities between kernels in random states.

namespace conddp {
namespace {

using Matrix = Eigen::MatrixXd;

/// Symmetric matrix from the lower triangle of a column-major nv x nv array.
Matrix from_lower(const std::vector<double>& values, int n) {
  const Matrix lower = Eigen::Map<const Matrix>(values.data(), n, n);
  return lower.selfadjointView<Eigen::Lower>();
}

std::vector<double> as_vector(const Matrix& m) { return {m.data(), m.data() + m.size()}; }

class KernelDynamics : public testing::TestWithParam<std::size_t> {
 protected:
  const RobotModel& model() const { return kernel_models()[GetParam()].model; }

  template <class F>
  void in_random_states(F test) const {
    RandomNumbers random(200 + GetParam());
    for (int i = 0; i < 5; ++i) {
      const RobotState x = random_state(model(), random);
      test(x, KernelProbe<double>(model(), ProbeState<double>::at(x)));
    }
  }

  std::vector<double> inverse_dynamics_of(const RobotModel& robot, const RobotState& x) const {
    RobotData<double> data(robot);
    inverse_dynamics(robot, x.q.data(), x.v.data(), x.a.data(), data);
    return {data.tau.begin(), data.tau.end()};
  }
};

// At rest without gravity and wrenches, the forces for a unit acceleration are a column of M.
TEST_P(KernelDynamics, InertiaMatrixIsInverseDynamicsByColumns) {
  RobotModel weightless = model();
  weightless.gravity = {0, 0, 0};
  weightless.wrenches.clear();
  const int n = model().nv;
  in_random_states([&](RobotState x, const KernelProbe<double>& probe) {
    x.v.assign(n, 0.0);
    Matrix columns(n, n);
    for (int k = 0; k < n; ++k) {
      x.a.assign(n, 0.0);
      x.a[k] = 1;
      const std::vector<double> tau = inverse_dynamics_of(weightless, x);
      columns.col(k) = Eigen::Map<const Eigen::VectorXd>(tau.data(), n);
    }
    expect_close(as_vector(from_lower(probe["M"], n)), as_vector(columns), 1e-13, "M");
  });
}

TEST_P(KernelDynamics, FactorsMultiplyToTheInertiaMatrix) {
  const int n = model().nv;
  in_random_states([&](const RobotState&, const KernelProbe<double>& probe) {
    const Matrix packed = Eigen::Map<const Matrix>(probe["L"].data(), n, n);
    const Matrix l = packed.triangularView<Eigen::UnitLower>();
    const Matrix product = l.transpose() * packed.diagonal().asDiagonal() * l;
    expect_close(as_vector(product), as_vector(from_lower(probe["M"], n)), 1e-13, "Lᵀ D L");
  });
}

TEST_P(KernelDynamics, FactorsSolveLinearSystems) {
  const int n = model().nv;
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    RobotData<double> data(model());
    forward_dynamics(model(), x.q.data(), x.v.data(), x.tau.data(), data);
    const Matrix m = from_lower(probe["M"], n);
    std::vector<double> solution = x.a;
    solve_mass_matrix(model(), data, solution.data());
    const Eigen::VectorXd back = m * Eigen::Map<const Eigen::VectorXd>(solution.data(), n);
    expect_close(as_vector(back), x.a, 1e-10, "M M⁻¹ a");
  });
}

TEST_P(KernelDynamics, ManyRightHandSidesMatchSingleOnes) {
  const int n = model().nv;
  RandomNumbers random(250 + GetParam());
  in_random_states([&](const RobotState&, const KernelProbe<double>& probe) {
    for (const int columns : {0, 1, 5, 6, 13}) {
      std::vector<double> together(columns * n);
      for (double& value : together) value = random.uniform(-1, 1);
      std::vector<double> single = together;
      solve_mass_matrix(model(), probe.data(), together.data(), columns);
      for (int k = 0; k < columns; ++k)
        solve_mass_matrix(model(), probe.data(), single.data() + k * n);
      expect_close(together, single, 1e-14, std::to_string(columns) + " columns");
    }
  });
}

TEST_P(KernelDynamics, InverseDynamicsIsInertiaTimesAccelerationPlusBias) {
  const int n = model().nv;
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    const Eigen::VectorXd tau =
        from_lower(probe["M"], n) * Eigen::Map<const Eigen::VectorXd>(x.a.data(), n) +
        Eigen::Map<const Eigen::VectorXd>(probe["bias"].data(), n);
    expect_close(as_vector(tau), probe["tau"], 1e-12, "M a + bias");
  });
}

TEST_P(KernelDynamics, ForwardDynamicsInvertsInverseDynamics) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    RobotData<double> data(model());
    forward_dynamics(model(), x.q.data(), x.v.data(), probe["tau"].data(), data);
    expect_close({data.acceleration.begin(), data.acceleration.end()}, x.a, 1e-10, "acceleration");
  });
}

TEST_P(KernelDynamics, NoForcesAreZeroForces) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>&) {
    RobotData<double> none(model()), zero(model());
    const std::vector<double> forces(model().nv, 0.0);
    forward_dynamics<double>(model(), x.q.data(), x.v.data(), nullptr, none);
    forward_dynamics(model(), x.q.data(), x.v.data(), forces.data(), zero);
    EXPECT_EQ(none.acceleration, zero.acceleration);
  });
}

TEST_P(KernelDynamics, GravityTorquesAreTheBiasAtRest) {
  RobotModel quiet = model();
  quiet.wrenches.clear();
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    const std::vector<double> rest(model().nv, 0.0);
    RobotData<double> data(quiet);
    inverse_dynamics(quiet, x.q.data(), rest.data(), rest.data(), data);
    expect_close(probe["gravity torques"], {data.tau.begin(), data.tau.end()}, 1e-13, "gravity");
  });
}

// A wrench w on a frame acts as the generalized force Jᵀ w.
TEST_P(KernelDynamics, ExternalWrenchesActThroughTheFramesJacobian) {
  const int n = model().nv;
  RobotModel loaded = model();
  loaded.wrenches.clear();
  RandomNumbers random(300 + GetParam());
  for (int f = 0; f < static_cast<int>(loaded.frames.size()); ++f) {
    const Vector3<double> force = random.vector(10);
    loaded.wrenches.push_back({f, {force, random.vector(10)}});
  }
  RobotModel quiet = model();
  quiet.wrenches.clear();
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    std::vector<double> expected = inverse_dynamics_of(quiet, x);
    for (const ExternalWrench& w : loaded.wrenches) {
      const std::vector<double>& jacobian = probe["jacobian world " + std::to_string(w.frame)];
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < 6; ++i) expected[k] -= jacobian[6 * k + i] * w.wrench[i];
    }
    expect_close(inverse_dynamics_of(loaded, x), expected, 1e-12, "inverse dynamics");
  });
}

TEST_P(KernelDynamics, KineticEnergyIsHalfOfVelocityInertiaVelocity) {
  const int n = model().nv;
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    const auto v = Eigen::Map<const Eigen::VectorXd>(x.v.data(), n);
    const double expected = 0.5 * v.dot(from_lower(probe["M"], n) * v);
    EXPECT_NEAR(probe["energy"][0], expected, 1e-12 * expected);
  });
}

/// Mass of the bodies and their loads.
double mass_in(const RobotModel& model, const RobotState& x) {
  double mass = model.total_mass();
  for (const Load& load : model.loads) mass += x.q[model.joints[load.parameter].q] * load.unit.mass;
  return mass;
}

TEST_P(KernelDynamics, PotentialEnergyIsWeightTimesCenterHeight) {
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    const std::vector<double>& com = probe["com"];
    const double mass = mass_in(model(), x);
    const double fall =
        com[0] * model().gravity.x + com[1] * model().gravity.y + com[2] * model().gravity.z;
    EXPECT_NEAR(probe["energy"][1], -mass * fall, 1e-12 * mass * (10 + std::abs(fall)));
  });
}

TEST_P(KernelDynamics, VelocitiesAreJacobiansTimesGeneralizedVelocities) {
  const int n = model().nv;
  in_random_states([&](const RobotState& x, const KernelProbe<double>& probe) {
    const auto times_v = [&](const std::string& name, int rows) {
      const Matrix j = Eigen::Map<const Matrix>(probe[name].data(), rows, n);
      return as_vector(j * Eigen::Map<const Eigen::VectorXd>(x.v.data(), n));
    };
    for (int f = 0; f < static_cast<int>(model().frames.size()); ++f)
      for (const char* axes : {" local ", " world "}) {
        const std::string in = axes + std::to_string(f);
        expect_close(probe["velocity" + in], times_v("jacobian" + in, 6), 1e-13, in);
      }
    expect_close(probe["momentum"], times_v("momentum_v", 6), 1e-12, "momentum");
    std::vector<double> linear = times_v("com jacobian", 3);
    for (double& value : linear) value *= mass_in(model(), x);
    expect_close({probe["momentum"].begin(), probe["momentum"].begin() + 3}, linear, 1e-12,
                 "linear momentum");
  });
}

// Only the directions of wrenches and gravity depend on the position of a floating base.
TEST_P(KernelDynamics, IgnoresThePositionOfTheBase) {
  in_random_states([&](RobotState x, const KernelProbe<double>& probe) {
    for (const Joint& joint : model().joints)
      if (joint.type == JointType::floating)
        for (int i = 0; i < 3; ++i) x.q[joint.q + i] += 10;
    const KernelProbe<double> moved(model(), ProbeState<double>::at(x));
    for (const char* name : {"M", "tau", "tau_q", "tau_v", "acceleration"})
      EXPECT_EQ(moved[name], probe[name]) << name;
  });
}

TEST_P(KernelDynamics, OverwritesEarlierEvaluations) {
  RandomNumbers random(350 + GetParam());
  const auto former = ProbeState<double>::at(random_state(model(), random));
  in_random_states([&](const RobotState& x, const KernelProbe<double>& fresh) {
    const KernelProbe<double> again(model(), ProbeState<double>::at(x),
                                    KernelProbe<double>(model(), former).data());
    for (const auto& [name, values] : fresh.outputs()) EXPECT_EQ(again[name], values) << name;
  });
}

INSTANTIATE_TEST_SUITE_P(AllRobots, KernelDynamics,
                         testing::Range<std::size_t>(0, kernel_models().size()),
                         [](const auto& suite) { return kernel_models()[suite.param].name; });

}  // namespace
}  // namespace conddp
