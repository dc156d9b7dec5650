// Residual between a state and a free initial state.
#include <algorithm>

#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

struct Cycle {
  std::shared_ptr<const MultibodySystem> system;
  ChosenStart start;
  std::vector<double> offset;
};

/// A robot with some free coordinates of its initial state, given by tangent indices.
Cycle cycle_of(bool floating, RandomNumbers& random) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(81, {.joints = 4, .floating = floating, .wrenches = 0}));
  Cycle cycle{std::make_shared<MultibodySystem>(robot, Actuation::full(*robot)), {}, {}};
  const StateManifold& manifold = cycle.system->manifold();
  cycle.start.state = random_manifold_state(manifold, random, 1);
  cycle.start.coordinates = {1, 3, manifold.ndx() - 2};
  if (floating) cycle.start.coordinates = {4, 0, 7, manifold.ndx() - 1};
  cycle.offset.assign(manifold.nx(), 0.0);
  for (int i = 0; i < manifold.nx(); ++i)
    if (!floating || i < 3 || i > 6) cycle.offset[i] = random.uniform(-1, 1);
  return cycle;
}

TEST(CycleResidual, IsDistanceFromChosenStartWithOffset) {
  RandomNumbers random(41);
  for (const bool floating : {false, true}) {
    const Cycle cycle = cycle_of(floating, random);
    const StateManifold& manifold = cycle.system->manifold();
    const auto residual = cycle_residual(manifold, cycle.start, cycle.offset);
    const std::vector<double> chosen = random.numbers(cycle.start.coordinates.size(), 1);
    std::vector<double> step(manifold.ndx(), 0.0), x = cycle.start.state;
    for (std::size_t i = 0; i < chosen.size(); ++i) step[cycle.start.coordinates[i]] = chosen[i];
    manifold.integrate(x.data(), step.data(), x.data());
    for (int i = 0; i < manifold.nx(); ++i) x[i] += cycle.offset[i];
    std::vector<double> way(manifold.ndx());
    for (double& d : way) d = random.uniform(-0.7, 0.7);
    manifold.integrate(x.data(), way.data(), x.data());
    x.insert(x.end(), chosen.begin(), chosen.end());
    const auto data = cycle.system->create_data(double{});
    std::vector<double> r(residual->size());
    ASSERT_EQ(residual->size(), manifold.ndx());
    residual->evaluate(ResidualInput<double>{x.data(), nullptr, nullptr, *data}, r.data());
    for (int i = 0; i < manifold.ndx(); ++i) EXPECT_NEAR(r[i], way[i], 1e-12) << "row " << i;
  }
}

TEST(CycleResidual, GradientsMatchDualNumbers) {
  RandomNumbers random(42);
  for (const bool floating : {false, true}) {
    const Cycle cycle = cycle_of(floating, random);
    auto model = std::make_shared<KnotModel>(
        step_with(cycle.system, Integrator::semi_implicit_euler, Memory::none,
                  static_cast<int>(cycle.start.coordinates.size())));
    model->add_cost("cycle", cycle_residual(cycle.system->manifold(), cycle.start, cycle.offset),
                    {});
    const KnotCase c = make_case("cycle", model, random);
    KnotWorkspace<double> work(*model);
    model->differentiate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt},
                         work, true);
    double scale = 1;
    for (double g : work.gradient) scale = std::max(scale, std::abs(g));
    for (int d = 0; d < model->nz(); ++d)
      EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-10 * scale)
          << (floating ? "floating" : "fixed") << " direction " << d;
  }
}

/// Rows of a cycle at a random state, and their Jacobian.
Eigen::MatrixXd values_and_jacobian(const Cycle& cycle, const std::vector<int>& left_out) {
  RandomNumbers random(44);
  KnotModel model(step_with(cycle.system, Integrator::none, Memory::none,
                            static_cast<int>(cycle.start.coordinates.size())));
  model.add_constraint(make_constraint(
      "cycle", cycle_residual(cycle.system->manifold(), cycle.start, cycle.offset, left_out),
      ConstraintKind::bounds));
  const std::vector<double> x = random_manifold_state(model.manifold(), random, 1);
  std::vector<double> parameters(model.parameter_count(), 0.0);
  parameters.back() = 1;
  KnotWorkspace<double> work(model);
  model.differentiate(KnotInput<double>{x.data(), nullptr, parameters.data(), 0, 1}, work, false);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(model.constraint_rows(), 1 + model.ndx());
  for (int i = 0; i < rows.rows(); ++i) rows(i, 0) = work.constraint[i];
  for (std::size_t e = 0; e < model.constraint_pattern().size(); ++e)
    rows(model.constraint_pattern()[e].first, 1 + model.constraint_pattern()[e].second) =
        work.constraint_jacobian[e];
  return rows;
}

TEST(CycleResidual, HasRowsOfAllIncludedCoordinates) {
  RandomNumbers random(43);
  for (const bool floating : {false, true}) {
    const Cycle cycle = cycle_of(floating, random);
    const std::vector<int> left_out =
        floating ? std::vector{7, 11, 19} : std::vector{0, 3, 7};  // with and without a memory
    const Eigen::MatrixXd all = values_and_jacobian(cycle, {}),
                          some = values_and_jacobian(cycle, left_out);
    ASSERT_EQ(some.rows(), all.rows() - 3);
    int row = 0;
    for (int i = 0; i < all.rows(); ++i) {
      if (std::ranges::find(left_out, i) != left_out.end()) continue;
      EXPECT_LT((some.row(row++) - all.row(i)).norm(), 1e-14) << i;
      EXPECT_GT(all.row(i).tail(all.cols() - 1).norm(), 0.1) << i;
    }
  }
}

// Scalars before, between, and after a pose and a rotation; some of them are chosen.
TEST(CycleResidual, HasDerivativesOnCurvedStateParts) {
  using Part = StateManifold::Part;
  using D = Dual<Lane>;
  StateManifold manifold = StateManifold::flat(2);
  manifold.append(Part::se3);
  manifold.append(Part::flat, 1);
  manifold.append(Part::so3);
  manifold.append(Part::flat, 2);
  RandomNumbers random(45);
  const int nx = manifold.nx(), ndx = manifold.ndx();
  ChosenStart start{random_manifold_state(manifold, random, 1), {0, 3, 5, 8, 9, 11}};
  std::vector<double> offset(nx, 0.0);
  offset[1] = 0.3;
  offset[3] = -0.4;
  const int rows = ndx - 1, choices = static_cast<int>(start.coordinates.size());
  const auto residual = cycle_residual(manifold, start, offset, {1});
  ASSERT_EQ(residual->size(), rows);
  std::vector<double> x = random_manifold_state(manifold, random, 1);
  const std::vector<double> chosen = random.numbers(choices, 0.7);
  x.insert(x.end(), chosen.begin(), chosen.end());
  const auto system = pendulum({});
  const auto data = system->create_data(double{});
  std::vector<double> r(rows), packed(residual->jacobian_size());
  residual->differentiate(ResidualInput<double>{x.data(), nullptr, nullptr, *data}, r.data(),
                          packed.data());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, ndx + choices);
  const double* entry = packed.data();
  int first = 0;
  for (const RowBlock& block : residual->blocks()) {
    for (const int column : block.columns)
      for (int i = 0; i < block.rows; ++i) J(first + i, column) = *entry++;
    first += block.rows;
  }
  const auto dual_data = system->create_data(D{});
  for (int c = 0; c < ndx + choices; ++c) {
    AlignedVector<D> moved(x.begin(), x.end()), step(ndx, D(0.0)), out(rows);
    if (c < ndx) {
      step[c].d = Lane(1.0);
      manifold.integrate(moved.data(), step.data(), moved.data());
    } else {
      moved[nx + c - ndx].d = Lane(1.0);
    }
    residual->evaluate(ResidualInput<D>{moved.data(), nullptr, nullptr, *dual_data}, out.data());
    for (int i = 0; i < rows; ++i) {
      EXPECT_NEAR(out[i].v[0], r[i], 1e-13) << i;
      EXPECT_NEAR(out[i].d[0], J(i, c), 1e-12) << i << " by " << c;
    }
  }
}

}  // namespace
}  // namespace conddp
