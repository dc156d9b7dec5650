// Equations of a contact-implicit step, and complementary pairs as a constraint.
#include "ocp/residuals/stepping_residual.hpp"

#include <gtest/gtest.h>

#include "ocp/knot/knot_model.hpp"
#include "robot/dynamics.hpp"
#include "support/stepping_robot.hpp"

namespace conddp {
namespace {

constexpr double kStep = 0.05;

struct Point {
  std::vector<double> x, w;
};

Point random_point(const SteppingSystem& system, std::uint64_t seed) {
  RandomNumbers random(seed);
  Point p;
  std::vector<double> off;
  for (int i = 0; i < system.ndx(); ++i) off.push_back(random.uniform(-1, 1));
  p.x = system.manifold().neutral();
  system.manifold().integrate(p.x.data(), off.data(), p.x.data());
  for (int i = 0; i < system.nu(); ++i) p.w.push_back(random.uniform(-2, 2));
  return p;
}

std::vector<double> values(const SteppingSystem& system, const Residual& residual, const Point& p) {
  const auto data = system.create_data(double{});
  system.evaluate(p.x.data(), p.w.data(), *data);
  std::vector<double> r(residual.size());
  residual.evaluate(ResidualInput<double>{p.x.data(), p.w.data(), &kStep, *data}, r.data());
  return r;
}

TEST(SteppingLayout, ConeWithOneTangentIsThePyramid) {
  const auto names = [](bool planar, FrictionModel friction) {
    const auto system = stepping_robot(planar, SteppingScheme::backward_euler, friction);
    std::vector<std::string> list;
    for (const Column& column : system->layout().columns) list.push_back(column.name);
    return list;
  };
  EXPECT_EQ(names(true, FrictionModel::cone), names(true, FrictionModel::polyhedron));
  const auto cone = names(false, FrictionModel::cone);
  EXPECT_NE(cone, names(false, FrictionModel::polyhedron));
  EXPECT_EQ(std::count(cone.begin(), cone.end(), "contact/ball/ft2"), 1);
  EXPECT_EQ(std::count(cone.begin(), cone.end(), "contact/pad/ft2"), 0);  // without friction
}

class SteppingDerivatives
    : public ::testing::TestWithParam<std::tuple<bool, SteppingScheme, FrictionModel, bool>> {};

TEST_P(SteppingDerivatives, MatchDifferences) {
  const auto& [planar, scheme, friction, floating] = GetParam();
  const auto system = stepping_robot(planar, scheme, friction, floating);
  const auto residual = stepping_residual(system, system->ndx());
  const Point p = random_point(*system, 3);
  const auto data = system->create_data(double{});
  system->differentiate(p.x.data(), p.w.data(), *data);
  std::vector<double> r(residual->size()), packed(residual->jacobian_size());
  residual->differentiate(ResidualInput<double>{p.x.data(), p.w.data(), &kStep, *data}, r.data(),
                          packed.data());
  const std::vector<double> same = values(*system, *residual, p);
  const int nz = system->ndx() + system->nu();
  std::vector<double> jacobian(residual->size() * nz, 0.0);
  const double* entry = packed.data();
  int first = 0;
  for (const RowBlock& block : residual->blocks()) {
    EXPECT_TRUE(std::is_sorted(block.columns.begin(), block.columns.end()));
    for (const int c : block.columns)
      for (int i = 0; i < block.rows; ++i) jacobian[(first + i) * nz + c] += *entry++;
    first += block.rows;
  }
  const auto names = stepping_row_names(*system);
  ASSERT_EQ(static_cast<int>(names.size()), residual->size());
  for (int c = 0; c < nz; ++c) {
    constexpr double kDifference = 1e-6;
    const auto beside = [&](double off) {
      Point moved = p;
      if (c >= system->ndx()) {
        moved.w[c - system->ndx()] += off;
      } else {
        std::vector<double> direction(system->ndx(), 0.0);
        direction[c] = off;
        system->manifold().integrate(p.x.data(), direction.data(), moved.x.data());
      }
      return values(*system, *residual, moved);
    };
    const auto above = beside(kDifference), below = beside(-kDifference);
    for (int i = 0; i < residual->size(); ++i) {
      EXPECT_EQ(r[i], same[i]);
      EXPECT_NEAR(jacobian[i * nz + c], (above[i] - below[i]) / (2 * kDifference), 2e-6)
          << names[i] << " by column " << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, SteppingDerivatives,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(SteppingScheme::backward_euler,
                                                              SteppingScheme::variational_midpoint),
                                            ::testing::Values(FrictionModel::polyhedron,
                                                              FrictionModel::cone),
                                            ::testing::Values(false)));
INSTANTIATE_TEST_SUITE_P(
    FloatingBase, SteppingDerivatives,
    ::testing::Combine(::testing::Bool(), ::testing::Values(SteppingScheme::backward_euler),
                       ::testing::Values(FrictionModel::polyhedron, FrictionModel::cone),
                       ::testing::Values(true)));

/// The equations are evaluated at x⁺ of the dynamics: q ⊕ h v⁺ with v⁺ = v + h a.
TEST(SteppingSystem, FloatingBaseMovesByVelocityAfterTheStep) {
  const auto system =
      stepping_robot(false, SteppingScheme::backward_euler, FrictionModel::polyhedron, true);
  const Point p = random_point(*system, 11);
  const int nq = system->nq(), nv = system->nv();
  ASSERT_EQ(nq, nv + 1);
  const auto data = system->create_data(double{});
  auto& step = static_cast<SteppingSystem::Data<double>&>(*data);
  system->take_step(p.x.data(), p.w.data(), kStep, false, step);
  const KnotModel model(system, Integrator::semi_implicit_euler);
  KnotWorkspace<double> work(model);
  model.evaluate(KnotInput<double>{p.x.data(), p.w.data(), nullptr, kStep, 1}, work);
  const auto& next = work.next();
  for (int i = 0; i < nq; ++i) EXPECT_NEAR(step.q[i], next[i], 1e-14) << i;
  for (int i = 0; i < nv; ++i) EXPECT_NEAR(step.v[i], next[nq + i], 1e-14) << i;
  // The pose by many small screws.
  constexpr int kParts = 1000;
  std::vector<double> off(2 * nv, 0.0), x(p.x);
  for (int i = 0; i < nv; ++i) off[i] = kStep / kParts * step.v[i];
  for (int s = 0; s < kParts; ++s) system->manifold().integrate(x.data(), off.data(), x.data());
  for (int i = 0; i < nq; ++i) EXPECT_NEAR(step.q[i], x[i], 1e-11) << i;
}

TEST(SteppingSystem, MidpointRuleRejectsAFloatingBase) {
  try {
    stepping_robot(false, SteppingScheme::variational_midpoint, FrictionModel::polyhedron, true);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("variational_midpoint"), std::string::npos) << e.what();
  }
}

/// Momentum is ∂T/∂v; the load is the bias force without the change of momentum. Differences of
/// kinetic energy give both.
TEST(HalfStep, MatchesKineticEnergy) {
  const auto system = stepping_robot(false, SteppingScheme::variational_midpoint);
  RobotModel robot = system->multibody().robot();
  robot.wrenches.clear();  // wrenches have no energy
  RobotModel free = robot;
  free.gravity = Vector3<double>::zero();
  RandomNumbers random(9);
  std::vector<double> q(robot.nq), v(robot.nv);
  for (double& x : q) x = random.uniform(-1, 1);
  for (double& x : v) x = random.uniform(-2, 2);
  const auto energy = [&](const std::vector<double>& at, const std::vector<double>& speed) {
    RobotData<double> data(robot);
    update_placements(robot, at.data(), data);
    update_velocities(robot, speed.data(), data);
    update_composite_inertias(robot, data);
    return kinetic_energy(robot, data) - potential_energy(robot, data);
  };
  HalfStep<double> half(robot);
  std::copy(q.begin(), q.end(), half.position.begin());
  update_half_step(robot, free, v.data(), false, half);
  constexpr double kDifference = 1e-6;
  for (int i = 0; i < robot.nv; ++i) {
    const auto slope = [&](std::vector<double>& x) {
      const double before = x[i];
      x[i] = before + kDifference;
      const double above = energy(q, v);
      x[i] = before - kDifference;
      const double below = energy(q, v);
      x[i] = before;
      return (above - below) / (2 * kDifference);
    };
    EXPECT_NEAR(half.momentum[i], slope(v), 1e-7) << i;
    EXPECT_NEAR(half.load[i], -slope(q), 1e-6) << i;
  }
}

TEST(SteppingResidual, EquationsOfMotionMatchInverseDynamics) {
  const auto system = stepping_robot(true);
  Point p = random_point(*system, 5);
  const SteppingLayout& layout = system->layout();
  for (std::size_t i = layout.acceleration + layout.nv; i < p.w.size(); ++i) p.w[i] = 0;
  const std::vector<double> r = values(*system, *stepping_residual(system, system->ndx()), p);
  const RobotModel& model = system->multibody().robot();
  std::vector<double> q(layout.nv), v(layout.nv), a(layout.nv);
  for (int i = 0; i < layout.nv; ++i) {
    a[i] = p.w[layout.acceleration + i];
    v[i] = p.x[layout.nv + i] + kStep * a[i];
    q[i] = p.x[i] + kStep * v[i];
  }
  RobotData<double> data(model);
  inverse_dynamics(model, q.data(), v.data(), a.data(), data);
  const std::vector<double>& B = system->multibody().actuation().B;
  for (int i = 0; i < layout.nv; ++i) {
    double expected = data.tau[i];
    for (int c = 0; c < layout.actuators; ++c) expected -= B[c * layout.nv + i] * p.w[c];
    EXPECT_NEAR(r[i], expected, 1e-10) << i;
  }
}

// Step forces in the equations of motion: Jᵀf along the normal and both signs of each tangent,
// stops towards the middle, dry friction as it acts.
TEST(SteppingResidual, EquationsIncludeContactStopAndDryFrictionForces) {
  for (const bool planar : {false, true})
    for (const FrictionModel friction : {FrictionModel::polyhedron, FrictionModel::cone}) {
      const auto system = stepping_robot(planar, SteppingScheme::backward_euler, friction);
      const Point p = random_point(*system, 8);
      Point idle = p;
      const SteppingLayout& w = system->layout();
      const RobotModel& model = system->multibody().robot();
      std::vector<double> q(w.nv);
      for (int i = 0; i < w.nv; ++i)
        q[i] = p.x[i] + kStep * (p.x[w.nv + i] + kStep * p.w[w.acceleration + i]);
      RobotData<double> data(model);
      update_placements(model, q.data(), data);
      std::vector<double> pushed(w.nv, 0.0);
      const auto take = [&](int entry) {
        idle.w[entry] = 0;
        return p.w[entry];
      };
      for (std::size_t c = 0; c < w.candidates.size(); ++c) {
        const SteppingLayout::Candidate& at = w.candidates[c];
        double force[3] = {take(at.force), 0, 0};
        for (int i = 0; i < at.friction.count; i += 2) {
          const double forth = take(at.friction.force[i]), back = take(at.friction.force[i + 1]);
          force[1 + i / 2] = forth - back;
        }
        for (int i = 0; at.cone.present && i < 2; ++i) force[1 + i] = take(at.cone.force[i]);
        const CandidateGeometry geometry(model, system->contacts().candidates[c],
                                         system->contacts().plane);
        auto rows = geometry.create_rows<double>();
        geometry.evaluate(data, rows);
        const int k = static_cast<int>(geometry.columns().size());
        for (std::size_t e = 0; e < rows.rows.size(); ++e)
          pushed[geometry.columns()[e % k]] += force[e / k] * rows.rows[e];
      }
      for (const SteppingLayout::Stop& stop : w.stops)
        pushed[model.joints[stop.joint].v] += (stop.upper ? -1 : 1) * take(stop.force);
      for (std::size_t i = 0; i < w.frictions.size(); ++i) {
        const double forth = take(w.frictions[i].force[0]), back = take(w.frictions[i].force[1]);
        pushed[model.joints[system->contacts().frictions[i].joint].v] += forth - back;
      }
      const auto residual = stepping_residual(system, system->ndx());
      const std::vector<double> with = values(*system, *residual, p),
                                without = values(*system, *residual, idle);
      for (int i = 0; i < w.nv; ++i)
        EXPECT_NEAR(with[i], without[i] - pushed[i], 1e-11) << planar << ' ' << i;
    }
}

// Rows after the equations of motion, compared with their definition at the end of the step.
TEST(SteppingResidual, ContactRowsUseEndOfStepGeometry) {
  for (const FrictionModel friction : {FrictionModel::polyhedron, FrictionModel::cone}) {
    const auto system = stepping_robot(false, SteppingScheme::backward_euler, friction);
    const Point p = random_point(*system, 6);
    const SteppingLayout& w = system->layout();
    const RobotModel& model = system->multibody().robot();
    const auto control = [&](int i) { return p.w[i]; };
    std::vector<double> q(w.nv), v(w.nv), expected;
    for (int i = 0; i < w.nv; ++i) {
      v[i] = p.x[w.nv + i] + kStep * control(w.acceleration + i);
      q[i] = p.x[i] + kStep * v[i];
    }
    RobotData<double> data(model);
    update_placements(model, q.data(), data);
    const auto add_friction = [&](const FrictionIndices& f, double budget, auto speed) {
      if (f.count == 0) return;
      double forces = 0;
      for (int i = 0; i < f.count; ++i) {
        const double sign = i % 2 == 0 ? 1 : -1;
        expected.push_back(control(f.slip[i]) - control(f.gamma) - sign * speed(i / 2));
        forces += control(f.force[i]);
      }
      expected.push_back(control(f.rest) - (budget - forces));
    };
    for (std::size_t c = 0; c < w.candidates.size(); ++c) {
      const ContactCandidate& candidate = system->contacts().candidates[c];
      const CandidateGeometry geometry(model, candidate, {});
      auto rows = geometry.create_rows<double>();
      geometry.evaluate(data, rows);
      const int k = static_cast<int>(geometry.columns().size());
      const double force = control(w.candidates[c].force);
      const auto speed = [&](int tangent) {
        double sum = 0;
        for (int j = 0; j < k; ++j)
          sum += rows.rows[(1 + tangent) * k + j] * v[geometry.columns()[j]];
        return sum;
      };
      expected.push_back(control(w.candidates[c].gap) -
                         (rows.gap + (candidate.stiffness ? force / *candidate.stiffness : 0)));
      const double budget = candidate.friction * force;
      add_friction(w.candidates[c].friction, budget, speed);
      const ConeIndices& cone = w.candidates[c].cone;
      EXPECT_EQ(cone.present, friction == FrictionModel::cone && candidate.friction > 0);
      if (!cone.present) continue;
      const Eigen::Vector2d e(control(cone.use[0]), control(cone.use[1]));
      for (int i = 0; i < 2; ++i) expected.push_back(control(cone.speed) * e[i] - speed(i));
      for (int i = 0; i < 2; ++i) expected.push_back(control(cone.force[i]) + budget * e[i]);
      expected.push_back(control(cone.rest) - (1 - e.squaredNorm()));
    }
    for (const JointStop& stop : system->contacts().stops)
      for (const bool upper : {false, true}) {
        const double limit = upper ? stop.upper : stop.lower;
        if (!std::isfinite(limit)) continue;
        const auto at = std::find_if(w.stops.begin(), w.stops.end(), [&](const auto& s) {
          return s.joint == stop.joint && s.upper == upper;
        });
        ASSERT_NE(at, w.stops.end());
        const double joint = q[model.joints[stop.joint].q];
        expected.push_back(control(at->distance) - (upper ? limit - joint : joint - limit));
      }
    for (std::size_t i = 0; i < w.frictions.size(); ++i) {
      const JointFriction& dry = system->contacts().frictions[i];
      add_friction(w.frictions[i], dry.limit, [&](int) { return v[model.joints[dry.joint].v]; });
    }
    const std::vector<double> r = values(*system, *stepping_residual(system, system->ndx()), p);
    ASSERT_EQ(r.size(), w.nv + expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(r[w.nv + i], expected[i], 1e-12) << i;
    EXPECT_EQ(stepping_row_names(*system).size(), r.size());
  }
}

TEST(SteppingPairs, AreTheForcesAndSlacksOfTheLayout) {
  const auto system = stepping_robot(true);
  const Point p = random_point(*system, 7);
  const auto& pairs = system->layout().pairs;
  const std::vector<double> r =
      values(*system, *stepping_pairs_residual(*system, system->ndx()), p);
  ASSERT_EQ(r.size(), 2 * pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(r[2 * i], p.w[pairs[i].first]);
    EXPECT_EQ(r[2 * i + 1], p.w[pairs[i].second]);
  }
}

TEST(ComplementarityConstraint, MeasuresTheSmallerValueOfEachPair) {
  const auto term = make_constraint("pairs", chosen_controls_residual(2, {0, 1, 3, 2}),
                                    ConstraintKind::complementarity);
  EXPECT_EQ(term.rows, 4);
  const auto distance = [&](std::vector<double> g) {
    return distance_to_set(term, g.data(), nullptr, nullptr);
  };
  EXPECT_EQ(distance({0, 5, 3, 0}), 0);
  EXPECT_EQ(distance({1e-3, 5, 3, 0}), 1e-3);
  EXPECT_EQ(distance({0, 5, 3, -0.2}), 0.2);
  EXPECT_TRUE(std::isnan(distance({0, 5, std::nan(""), 1})));
  const std::vector<double> g = {0, 5, 3, 0};
  const auto product = [&](std::vector<double> nu) {
    return complementarity(term, g.data(), nullptr, nullptr, nu.data());
  };
  EXPECT_EQ(product({-7, 0, 0, 8}), 0);  // zero values allow multipliers of either sign
  EXPECT_EQ(product({0, 2, 0, 0}), 10);
  EXPECT_THROW(make_constraint("odd", chosen_controls_residual(2, {0, 1, 2}),
                               ConstraintKind::complementarity),
               std::invalid_argument);
}

}  // namespace
}  // namespace conddp
