#include "systems/closed_forms/catalogue.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/random_numbers.hpp"
#include "support/robots.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using D = Dual<double>;
using Eigen::Map;
using Eigen::VectorXd;

std::vector<double> rate_of(const System& system, const std::vector<double>& x,
                            const std::vector<double>& u) {
  const auto data = system.create_data(double{});
  system.evaluate(x.data(), u.data(), *data);
  return {data->f.begin(), data->f.end()};
}

RobotModel load(const std::string& name, UrdfOptions::Base base) {
  const UrdfResult result =
      load_urdf(source_tree() / "problems/robots" / (name + ".urdf"), {.base = base});
  if (!result.model) throw std::runtime_error("cannot load " + name);
  return *result.model;
}

// Energies from mass positions and velocities.

template <class S>
S pendulum_energy(const PendulumParameters& p, const S* x) {
  return S(0.5 * p.inertia) * x[1] * x[1] - S(p.mass * p.gravity * p.length) * cos(x[0]);
}

template <class S>
S cartpole_energy(const CartpoleParameters& p, const S* x) {
  const S vx = x[2] + S(p.length) * x[3] * cos(x[1]), vz = S(p.length) * x[3] * sin(x[1]);
  return S(0.5 * p.cart_mass) * x[2] * x[2] + S(0.5 * p.pole_mass) * (vx * vx + vz * vz) -
         S(p.pole_mass * p.gravity * p.length) * cos(x[1]);
}

template <class S>
S acrobot_energy(const AcrobotParameters& p, const S* x) {
  const S whole = x[0] + x[1], turning = x[2] + x[3];
  const S v1x = -(S(p.length1) * x[2] * sin(x[0])), v1y = S(p.length1) * x[2] * cos(x[0]);
  const S v2x = v1x - S(p.length2) * turning * sin(whole);
  const S v2y = v1y + S(p.length2) * turning * cos(whole);
  const S y1 = S(p.length1) * sin(x[0]), y2 = y1 + S(p.length2) * sin(whole);
  return S(0.5 * p.mass1) * (v1x * v1x + v1y * v1y) + S(0.5 * p.mass2) * (v2x * v2x + v2y * v2y) +
         S(0.5 * p.inertia1) * x[2] * x[2] + S(0.5 * p.inertia2) * turning * turning +
         S(p.gravity) * (S(p.mass1) * y1 + S(p.mass2) * y2);
}

/// Checks dE/dt = power(x, u) at random states of a flat second-order system, and that the energy
/// is constant along a fine integration without power.
template <class Energy, class Power>
void expect_power_balance(const System& system, Energy energy, Power power) {
  RandomNumbers random(101);
  const int n = system.nv();
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<double> x = random.numbers(2 * n, 3);
    const std::vector<double> u = random.numbers(system.nu(), 5);
    const std::vector<double> a = rate_of(system, x, u);
    std::vector<D> moving(2 * n);
    for (int i = 0; i < n; ++i) {
      moving[i] = D(x[i], x[n + i]);
      moving[n + i] = D(x[n + i], a[i]);
    }
    const D e = energy(moving.data());
    EXPECT_NEAR(e.d, power(x, u), 1e-11 * (1 + std::abs(e.v)));
  }
}

template <class Energy>
void expect_conserved(const System& system, Energy energy) {
  RandomNumbers random(102);
  const int n = system.nv();
  const std::vector<double> start = random.numbers(2 * n, 1.5), none(system.nu(), 0.0);
  VectorXd x = Map<const VectorXd>(start.data(), 2 * n);
  const auto data = system.create_data(double{});
  const auto rate = [&](const VectorXd& at) {
    system.evaluate(at.data(), none.data(), *data);
    VectorXd f(2 * n);
    f << at.tail(n), Map<const VectorXd>(data->f.data(), n);
    return f;
  };
  const double h = 1e-3, before = energy(x.data());
  for (int step = 0; step < 2000; ++step) {
    const VectorXd k1 = rate(x), k2 = rate(x + h / 2 * k1), k3 = rate(x + h / 2 * k2),
                   k4 = rate(x + h * k3);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  EXPECT_GT((x - Map<const VectorXd>(start.data(), 2 * n)).norm(), 0.1);
  EXPECT_NEAR(energy(x.data()), before, 1e-9 * (1 + std::abs(before)));
}

TEST(Catalogue, PendulumConservesEnergyExceptTorqueAndDamping) {
  PendulumParameters p{.mass = 1.3, .length = 0.7, .inertia = 0.9, .damping = 0.4};
  const auto energy = [&](const auto* x) { return pendulum_energy(p, x); };
  expect_power_balance(*pendulum(p), energy, [&](const auto& x, const auto& u) {
    return u[0] * x[1] - p.damping * x[1] * x[1];
  });
  p.damping = 0;
  expect_conserved(*pendulum(p), energy);
}

TEST(Catalogue, CartpoleConservesEnergyExceptForThePush) {
  const CartpoleParameters p{.cart_mass = 1.7, .pole_mass = 0.4, .length = 0.8, .gravity = 9.7};
  const auto energy = [&](const auto* x) { return cartpole_energy(p, x); };
  expect_power_balance(*cartpole(p), energy,
                       [](const auto& x, const auto& u) { return u[0] * x[2]; });
  expect_conserved(*cartpole(p), energy);
}

TEST(Catalogue, AcrobotConservesEnergyExceptElbowAndFriction) {
  AcrobotParameters p{.length1 = 0.9,
                      .length2 = 1.2,
                      .mass1 = 1.5,
                      .mass2 = 0.8,
                      .inertia1 = 0.3,
                      .inertia2 = 0.6,
                      .friction = 0.7};
  const auto energy = [&](const auto* x) { return acrobot_energy(p, x); };
  expect_power_balance(*acrobot(p), energy, [&](const auto& x, const auto& u) {
    return u[0] * x[3] - p.friction * (x[2] * x[2] + x[3] * x[3]);
  });
  p.friction = 0;
  expect_conserved(*acrobot(p), energy);
}

TEST(Catalogue, CartpoleMatchesItsUrdf) {
  const RobotModel model = load("cartpole", UrdfOptions::Base::fixed);
  const MultibodySystem robot(std::make_shared<RobotModel>(model),
                              Actuation::joints(model, {"slider"}));
  const auto formula = cartpole({});
  RandomNumbers random(103);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<double> x = random.numbers(4, 3), u = random.numbers(1, 10);
    const std::vector<double> a = rate_of(robot, x, u), b = rate_of(*formula, x, u);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(a[i], b[i], 1e-12 * (1 + std::abs(b[i])));
  }
}

TEST(Catalogue, QuadrotorMatchesItsUrdfWithThrusters) {
  const RobotModel model = load("quadrotor", UrdfOptions::Base::floating);
  const QuadrotorParameters p;
  std::vector<Thruster> rotors;
  for (int i = 1; i <= 4; ++i) {
    const std::string name = "rotor_" + std::to_string(i);
    rotors.push_back({.name = name,
                      .frame = *model.find_frame(name),
                      .torque_ratio = i % 2 ? p.torque_ratio : -p.torque_ratio});
  }
  const MultibodySystem robot(std::make_shared<RobotModel>(model),
                              Actuation::thrusters(model, rotors, {}));
  const auto formula = quadrotor(p);
  ASSERT_EQ(robot.nx(), formula->nx());
  RandomNumbers random(104);
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::vector<double> x = robot.manifold().neutral();
    const std::vector<double> dx = random.numbers(robot.ndx(), 2);
    robot.manifold().integrate(x.data(), dx.data(), x.data());
    const std::vector<double> u = random.numbers(4, 3);
    const std::vector<double> a = rate_of(robot, x, u), b = rate_of(*formula, x, u);
    double scale = 1;
    for (double value : b) scale = std::max(scale, std::abs(value));
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], 1e-12 * scale) << i;
  }
}

TEST(Catalogue, PlanarQuadrotorMatchesTheQuadrotor) {
  // In the x-z plane, the planar angle rotates about −y. Only the front and rear rotors push, and
  // their reaction torques are omitted because they would rotate the body out of the plane.
  const PlanarQuadrotorParameters p{.mass = 0.7, .inertia = 0.05, .arm = 0.2, .gravity = 9.6};
  const auto planar = planar_quadrotor(p);
  const auto spatial = quadrotor({.mass = p.mass,
                                  .jx = 0.03,
                                  .jy = p.inertia,
                                  .jz = 0.06,
                                  .arm = p.arm,
                                  .torque_ratio = 0,
                                  .gravity = p.gravity});
  RandomNumbers random(105);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const std::vector<double> x = random.numbers(6, 2), u = random.numbers(2, 5);
    const double s = std::sin(x[2]), c = std::cos(x[2]), omega = x[5];
    // World to body for a rotation by θ about −y: (c x + s z, −s x + c z).
    const double vx = c * x[3] + s * x[4], vz = -s * x[3] + c * x[4];
    const std::vector<double> X = {
        x[0], 0, x[1], 0, -std::sin(x[2] / 2), 0, std::cos(x[2] / 2), vx, 0, vz, 0, -omega, 0};
    const std::vector<double> a = rate_of(*planar, x, u);
    const std::vector<double> b = rate_of(*spatial, X, {u[0], 0, u[1], 0});
    // World acceleration: R (v̇ + ω × v) with ω = −omega y.
    const double ax = b[0] - omega * vz, az = b[2] + omega * vx;
    EXPECT_NEAR(c * ax - s * az, a[0], 1e-12 * (1 + std::abs(a[0])));
    EXPECT_NEAR(s * ax + c * az, a[1], 1e-12 * (1 + std::abs(a[1])));
    EXPECT_NEAR(-b[4], a[2], 1e-12 * (1 + std::abs(a[2])));
    for (const int i : {1, 3, 5}) EXPECT_EQ(b[i], 0) << i;
  }
}

TEST(Catalogue, CarMatchesTheReferenceFormula) {
  // Tassa, Mansard, Todorov 2014, section IV.B, in long double.
  const long double d = 2.0L, h = 0.03L;
  const auto system = car(2.0, 0.03);
  RandomNumbers random(106);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<double> x = random.numbers(4, 5);
    const std::vector<double> u = {random.uniform(-0.5, 0.5), random.uniform(-2, 2)};
    const long double f = h * x[3], w = u[0];
    const long double b =
        d + f * std::cos(w) - std::sqrt(d * d - f * f * std::sin(w) * std::sin(w));
    const long double expected[] = {x[0] + b * std::cos(static_cast<long double>(x[2])),
                                    x[1] + b * std::sin(static_cast<long double>(x[2])),
                                    x[2] + std::asin(std::sin(w) * f / d), x[3] + h * u[1]};
    const std::vector<double> next = rate_of(*system, x, u);
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(next[i], static_cast<double>(expected[i]), 4e-15 * (1 + std::abs(next[i]))) << i;
  }
}

TEST(Catalogue, CarWheelsDoNotSlip) {
  // The front wheel rolls h v along its heading θ + w; the rear axle moves along θ; their distance
  // remains the wheelbase.
  const double d = 2.3, h = 0.05;
  const auto system = car(d, h);
  RandomNumbers random(107);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<double> x = random.numbers(4, 4);
    const std::vector<double> u = {random.uniform(-0.6, 0.6), 0};
    const std::vector<double> y = rate_of(*system, x, u);
    const auto heading = [](double angle) {
      return Eigen::Vector2d(std::cos(angle), std::sin(angle));
    };
    const Eigen::Vector2d rear(y[0] - x[0], y[1] - x[1]);
    const Eigen::Vector2d front = rear + d * heading(y[2]) - d * heading(x[2]);
    EXPECT_LT((front - h * x[3] * heading(x[2] + u[0])).norm(), 1e-14);
    EXPECT_NEAR(rear.x() * std::sin(x[2]) - rear.y() * std::cos(x[2]), 0, 1e-14);
  }
}

TEST(Catalogue, UnicycleDrivesAnArc) {
  // x(t) = x₀ + (v/ω)(sin(θ₀ + ω t) − sin θ₀), likewise y with −cos, θ = θ₀ + ω t: the rate along
  // it.
  const auto system = unicycle();
  RandomNumbers random(108);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<double> u = {random.uniform(-3, 3), random.uniform(0.2, 2)};
    const double start = random.uniform(-3, 3);
    const D t(random.uniform(0, 4), 1.0);
    const D angle = D(start) + D(u[1]) * t;
    const D x = D(u[0] / u[1]) * (sin(angle) - D(std::sin(start)));
    const D y = D(u[0] / u[1]) * (D(std::cos(start)) - cos(angle));
    const std::vector<double> rate = rate_of(*system, {x.v, y.v, angle.v}, u);
    EXPECT_NEAR(rate[0], x.d, 1e-14 * (1 + std::abs(u[0])));
    EXPECT_NEAR(rate[1], y.d, 1e-14 * (1 + std::abs(u[0])));
    EXPECT_EQ(rate[2], angle.d);
  }
}

TEST(Catalogue, LanderBurnsFuelByThrust) {
  const auto system = lander({.mass = 25, .fuel_rate = 2e-3, .gravity = 3.5});
  const std::vector<double> x = {1, 2, 30, -4, 5, -6, 5}, u = {30, -40, 120};
  const std::vector<double> rate = rate_of(*system, x, u);
  EXPECT_EQ(rate[0], -4);
  EXPECT_EQ(rate[1], 5);
  EXPECT_EQ(rate[2], -6);
  EXPECT_NEAR(rate[3], 1.5, 1e-14);
  EXPECT_NEAR(rate[4], -2, 1e-14);
  EXPECT_NEAR(rate[5], 6 - 3.5, 1e-14);
  EXPECT_NEAR(rate[6], 2e-3 * 130, 1e-10);  // ‖T‖ = 130 N
  // Without thrust it falls, and its Jacobians are finite.
  const std::vector<double> fall = rate_of(*system, x, {0, 0, 0});
  EXPECT_EQ(fall[5], -3.5);
  EXPECT_NEAR(fall[6], 0, 1e-5);
}

TEST(Catalogue, EverySystemNamesItsColumns) {
  for (const auto& system :
       {double_integrator(2), pendulum({}), cartpole({}), acrobot({}), unicycle(), car(2, 0.03),
        planar_quadrotor({}), quadrotor({}), lander({})}) {
    EXPECT_EQ(static_cast<int>(system->state_columns().size()), system->nx());
    EXPECT_EQ(static_cast<int>(system->control_columns().size()), system->nu());
  }
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(2, 2), B = Eigen::MatrixXd::Ones(2, 1);
  EXPECT_THROW(linear_system(A, B, Eigen::VectorXd::Zero(3)), std::invalid_argument);
  EXPECT_EQ(linear_system(A, B, Eigen::VectorXd::Zero(2))->state_columns().size(), 2u);
}

}  // namespace
}  // namespace conddp
