// Forces and energies of a plant, compared with robot functions, formulas, and finite differences.
#include "analysis/contact/contact_mechanics.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "robot/dynamics.hpp"
#include "support/candidate_cases.hpp"
#include "support/random_numbers.hpp"
#include "support/random_robot.hpp"
#include "support/stepping_robot.hpp"
#include "systems/contact/candidate_geometry.hpp"

namespace conddp {
namespace {

std::shared_ptr<const RobotModel> random_arm() {
  return std::make_shared<const RobotModel>(
      random_robot(61, {.joints = 5, .floating = false, .wrenches = 0}));
}

TEST(ContactMechanics, LoadHasDampingAndSmoothFriction) {
  const ContactPlant bare{.robot = random_arm()};
  ContactPlant resisting = bare;
  const int n = bare.nv();
  for (int i = 0; i < n; ++i) {
    resisting.damping.push_back(0.5 + i);
    resisting.smooth_friction.push_back(i == 1 ? 0 : 2.0 + i);
  }
  resisting.friction_velocity = 0.3;
  RandomNumbers random(71);
  const std::vector<double> q = random.numbers(n, 1), v = random.numbers(n, 0.5),
                            a = random.numbers(n, 1);
  ContactMechanics<double> without(bare), with(resisting);
  const std::vector<double> less = without.load(q.data(), v.data(), a.data());
  const std::vector<double> more = with.load(q.data(), v.data(), a.data());
  RobotData<double> data(*bare.robot);
  inverse_dynamics(*bare.robot, q.data(), v.data(), a.data(), data);
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(less[i], data.tau[i], 1e-12);
    EXPECT_NEAR(more[i] - less[i],
                (0.5 + i) * v[i] + (i == 1 ? 0 : 2.0 + i) * std::tanh(v[i] / 0.3), 1e-12)
        << "joint " << i;
  }
  EXPECT_NEAR(with.resistance(0, 1e6), 0.5e6 + 2, 1e-9);
  EXPECT_NEAR(with.resistance(0, -1e6), -0.5e6 - 2, 1e-9);
}

TEST(ContactMechanics, KineticSlopeMatchesKineticEnergy) {
  const ContactPlant plant{.robot = random_arm()};
  const int n = plant.nv();
  RandomNumbers random(72);
  const std::vector<double> q = random.numbers(n, 1), v = random.numbers(n, 1), zero(n, 0.0);
  ContactMechanics<double> mechanics(plant);
  const std::vector<double> slope = mechanics.kinetic_slope(q.data(), v.data());
  // M v is the inverse dynamics at rest for acceleration v minus that for zero acceleration.
  RobotData<double> data(*plant.robot);
  const auto energy = [&](const std::vector<double>& at) {
    inverse_dynamics(*plant.robot, at.data(), zero.data(), v.data(), data);
    std::vector<double> momentum(data.tau.begin(), data.tau.end());
    inverse_dynamics(*plant.robot, at.data(), zero.data(), zero.data(), data);
    double twice = 0;
    for (int i = 0; i < n; ++i) twice += v[i] * (momentum[i] - data.tau[i]);
    return twice / 2;
  };
  constexpr double kStep = 1e-5;
  for (int i = 0; i < n; ++i) {
    std::vector<double> above = q, below = q;
    above[i] += kStep;
    below[i] -= kStep;
    EXPECT_NEAR(slope[i], (energy(above) - energy(below)) / (2 * kStep), 1e-7) << "joint " << i;
  }
}

TEST(ContactMechanics, AppliedForcesAreColumnsTimesControls) {
  ContactPlant plant{.robot = random_arm()};
  const int n = plant.nv();
  for (int i = 0; i < 2 * n; ++i) plant.B.push_back(1 + i);
  EXPECT_EQ(plant.nu(), 2);
  const double u[] = {2, -3};
  const std::vector<double> forces = plant.applied(u);
  for (int i = 0; i < n; ++i) EXPECT_EQ(forces[i], 2 * (1 + i) - 3 * (1 + n + i));
}

/// A random robot, fixed or floating, in a random state, and the candidates of a sphere on it.
class GeometryOfContacts : public ::testing::TestWithParam<bool> {
 protected:
  GeometryOfContacts()
      : robot_(std::make_shared<const RobotModel>(
            random_robot(7, {.joints = 6, .floating = GetParam(), .branching = 0.6}))) {
    RandomNumbers random(3);
    q_ = random_state(*robot_, random).q;
  }
  ContactPlant plant_of(const CandidateCase& c) const {
    ContactPlant plant{.robot = robot_};
    plant.contacts.candidates = {c.candidate};
    plant.contacts.plane = c.plane;
    return plant;
  }
  /// The solver's version, with slopes.
  CandidateRows<double> of_the_solver(const CandidateGeometry& geometry) const {
    RobotData<double> data(*robot_);
    update_placements(*robot_, q_.data(), data);
    auto rows = geometry.create_rows<double>();
    geometry.differentiate(data, rows);
    return rows;
  }
  static void expect_near(const Vector3<double>& a, const Vector3<double>& b) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
  }

  std::shared_ptr<const RobotModel> robot_;
  std::vector<double> q_;
};

TEST_P(GeometryOfContacts, MatchesTheSolver) {
  for (const CandidateCase& c : candidate_cases(*robot_)) {
    SCOPED_TRACE(c.name);
    const ContactPlant plant = plant_of(c);
    const CandidateGeometry geometry(*robot_, c.candidate, c.plane);
    const CandidateRows<double> expected = of_the_solver(geometry);
    ContactMechanics<double> mechanics(plant);
    const ContactInstant<double>& found = mechanics.look(q_.data()).front();
    EXPECT_NEAR(found.gap, expected.gap, 1e-12);
    expect_near(found.point, expected.point);
    const int k = static_cast<int>(geometry.columns().size());
    std::vector<double> rows(3 * plant.nv(), 0.0);
    for (int r = 0; r <= geometry.tangents(); ++r) {
      expect_near(found.directions[r], expected.directions[r]);
      for (int i = 0; i < k; ++i)
        rows[r * plant.nv() + geometry.columns()[i]] = expected.rows[r * k + i];
    }
    ASSERT_EQ(found.rows.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_NEAR(found.rows[i], rows[i], 1e-12) << i;
  }
}

TEST_P(GeometryOfContacts, MovesLikeTheSolvers) {
  for (const CandidateCase& c : candidate_cases(*robot_)) {
    SCOPED_TRACE(c.name);
    const ContactPlant plant = plant_of(c);
    const CandidateGeometry geometry(*robot_, c.candidate, c.plane);
    const CandidateRows<double> expected = of_the_solver(geometry);
    const std::vector<int>& columns = geometry.columns();
    const int k = static_cast<int>(columns.size()), n = 1 + geometry.tangents();
    ContactMechanics<Dual<double>> mechanics(plant);
    for (int i = 0; i < k; ++i) {
      std::vector<Dual<double>> way(plant.nv(), Dual<double>(0.0)), q(plant.nq());
      way[columns[i]].d = 1;
      move_configuration(*robot_, q_.data(), way.data(), q.data());
      const ContactInstant<Dual<double>>& found = mechanics.look(q.data()).front();
      EXPECT_NEAR(found.gap.d, expected.rows[i], 1e-12);
      for (int r = 0; r < n; ++r)
        for (int j = 0; j < k; ++j)
          EXPECT_NEAR(found.rows[r * plant.nv() + columns[j]].d,
                      expected.slopes[i * n * k + r * k + j], 1e-11)
              << "row " << r << ", column " << j << " by " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, GeometryOfContacts, ::testing::Bool(),
                         [](const auto& suite) { return suite.param ? "floating" : "bolted"; });

/// A floating robot that rotates by less or more than a radian, covering both series and sines.
class RigidStep : public ::testing::TestWithParam<double> {
 protected:
  RigidStep()
      : system_(
            stepping_robot(true, SteppingScheme::backward_euler, FrictionModel::polyhedron, true)),
        robot_(system_->multibody().robot()),
        q_(system_->manifold().neutral()),
        d_(system_->ndx(), 0.0) {
    RandomNumbers random(5);
    std::vector<double> off(system_->ndx());
    for (double& x : off) x = random.uniform(-1, 1);
    system_->manifold().integrate(q_.data(), off.data(), q_.data());
    for (int i = 0; i < robot_.nv; ++i) d_[i] = random.uniform(-1, 1) * GetParam();
  }
  std::vector<double> moved(const std::vector<double>& d) const {
    std::vector<double> out(robot_.nq);
    move_configuration(robot_, q_.data(), d.data(), out.data());
    return out;
  }

  std::shared_ptr<const SteppingSystem> system_;
  const RobotModel& robot_;
  std::vector<double> q_, d_;
};

TEST_P(RigidStep, MatchesTheStateManifold) {
  std::vector<double> state(system_->nx());
  system_->manifold().integrate(q_.data(), d_.data(), state.data());
  const std::vector<double> q = moved(d_);
  for (int i = 0; i < robot_.nq; ++i) EXPECT_NEAR(q[i], state[i], 1e-14) << i;
}

TEST_P(RigidStep, IsFoundAgainFromItsEnds) {
  std::vector<double> difference(robot_.nv);
  configuration_difference(robot_, q_.data(), moved(d_).data(), difference.data());
  for (int i = 0; i < robot_.nv; ++i) EXPECT_NEAR(difference[i], d_[i], 1e-13) << i;
}

TEST_P(RigidStep, MatchesFiniteDifferences) {
  constexpr double kStep = 1e-6;
  for (int j = 0; j < robot_.nv; ++j) {
    std::vector<Dual<double>> d(d_.begin(), d_.end()), dual(robot_.nq);
    d[j].d = 1;
    move_configuration(robot_, q_.data(), d.data(), dual.data());
    std::vector<double> up = d_, down = d_;
    up[j] += kStep;
    down[j] -= kStep;
    const std::vector<double> above = moved(up), below = moved(down);
    for (int i = 0; i < robot_.nq; ++i)
      EXPECT_NEAR(dual[i].d, (above[i] - below[i]) / (2 * kStep), 1e-8) << i << " by " << j;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, RigidStep, ::testing::Values(1e-3, 0.5, 1.5));

}  // namespace
}  // namespace conddp
