// Soft constraints with rows that scale with a free duration, compared with formulas by hand.
#include "ocp/residuals/residual_by_duration.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "ocp/knot/knot_model.hpp"
#include "ocp/residuals/expression_residual.hpp"
#include "ocp/residuals/residuals.hpp"
#include "support/knot_case.hpp"

namespace conddp {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

TEST(RowsByDuration, MeasureExistingBoundsFromZero) {
  const RowsByDuration made =
      rows_by_duration(ConstraintKind::bounds, 5, {-1, 2, -kUnbounded, 4, -kUnbounded},
                       {1, 2, 3, kUnbounded, kUnbounded});
  EXPECT_EQ(made.rows, (std::vector<int>{0, 0, 1, 2, 3}));
  EXPECT_EQ(made.offsets, (std::vector<double>{-1, 1, 2, 3, 4}));
  EXPECT_EQ(made.lower, (std::vector<double>{0, -kUnbounded, 0, -kUnbounded, 0}));
  EXPECT_EQ(made.upper, (std::vector<double>{kUnbounded, 0, 0, 0, kUnbounded}));
}

TEST(RowsByDuration, ConeHasItsOwnRows) {
  const RowsByDuration made = rows_by_duration(ConstraintKind::second_order_cone, 3, {}, {});
  EXPECT_EQ(made.rows, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(made.offsets, (std::vector<double>{0, 0, 0}));
  EXPECT_TRUE(made.lower.empty() && made.upper.empty());
}

/// A pendulum knot with two more states; the last, x[3], is the duration.
class ByDuration : public ::testing::Test {
 protected:
  static constexpr double kWritten = 0.8;

  ConstraintTerm term(const std::shared_ptr<const Residual>& residual, ConstraintKind kind,
                      const RowsByDuration& rows, double slope = 1) {
    return by_duration(make_constraint("soft", residual, kind, slope, Softness::l1), rows,
                       {.state = 3, .tangent = 3, .written = kWritten});
  }

  /// Values and Jacobian, by rows of z = (x, u), at x and u.
  struct Rows {
    Eigen::VectorXd values;
    Eigen::MatrixXd jacobian;
  };
  Rows rows_of(const ConstraintTerm& constraint, const std::vector<double>& numbers,
               bool derivatives) {
    KnotModel model(step_with(pendulum({}), Integrator::rk4, Memory::none, 2));
    model.add_constraint(constraint);
    std::vector<double> parameters(model.parameter_count(), 0.0);
    std::copy(numbers.begin(), numbers.end(), parameters.begin());
    parameters[constraint.active()] = 1;
    KnotWorkspace<double> work(model);
    const KnotInput<double> in{x_.data(), u_.data(), parameters.data(), 0.1, 0.1};
    if (derivatives)
      model.differentiate(in, work, false);
    else
      model.evaluate(in, work);
    Rows rows{Eigen::Map<const Eigen::VectorXd>(work.constraint.data(), constraint.rows),
              Eigen::MatrixXd::Zero(constraint.rows, model.nz())};
    if (!derivatives) return rows;
    for (std::size_t e = 0; e < model.constraint_pattern().size(); ++e) {
      const auto& [row, column] = model.constraint_pattern()[e];
      rows.jacobian(row, column) = work.constraint_jacobian[e];
    }
    return rows;
  }
  void expect(const ConstraintTerm& constraint, const std::vector<double>& numbers,
              const Eigen::VectorXd& values, const Eigen::MatrixXd& jacobian) {
    const Rows evaluated = rows_of(constraint, numbers, false);
    const Rows differentiated = rows_of(constraint, numbers, true);
    EXPECT_LT((evaluated.values - values).norm(), 1e-14);
    EXPECT_LT((differentiated.values - values).norm(), 1e-14);
    EXPECT_LT((differentiated.jacobian - jacobian).norm(), 1e-14)
        << differentiated.jacobian << "\ninstead of\n"
        << jacobian;
  }

  std::vector<double> x_ = {0.3, -0.7, 5, 2}, u_ = {1.5};
};

// The control with reference 0.25, between −1 and 2, in a phase of 2 s with nominal 0.8 s: rows 2.5
// (1.25 + 1) and 2.5 (1.25 − 2).
TEST_F(ByDuration, ControlBoundsGrowWithIt) {
  const RowsByDuration rows = rows_by_duration(ConstraintKind::bounds, 1, {-1}, {2});
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, 5);
  jacobian.col(3) << 2.25 / 0.8, -0.75 / 0.8;
  jacobian.col(4) << 2.5, 2.5;
  expect(term(control_residual(4, 1), ConstraintKind::bounds, rows), {0.25, -1, 2},
         Eigen::Vector2d(5.625, -1.875), jacobian);
}

// All four states, some bounded; if a row reads the duration itself, both derivatives add up.
TEST_F(ByDuration, RowMayReadTheDurationItself) {
  const KnotModel model(step_with(pendulum({}), Integrator::rk4, Memory::none, 2));
  const RowsByDuration rows = rows_by_duration(
      ConstraintKind::bounds, 4, {-kUnbounded, -2, -kUnbounded, 1.5}, {0.1, 3, kUnbounded, 1.5});
  const std::vector<double> numbers = {0.1, 0.2, 0.3, 0.4, 0.1, -2, 3, 1.5};
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(4, 5);
  jacobian(0, 0) = jacobian(1, 1) = jacobian(2, 1) = jacobian(3, 3) = 2.5;
  const Eigen::Vector4d distances(0.2 - 0.1, -0.9 + 2, -0.9 - 3, 1.6 - 1.5);
  jacobian.col(3) += distances / 0.8;
  expect(term(state_residual(model.manifold()), ConstraintKind::bounds, rows), numbers,
         2.5 * distances, jacobian);
}

// Norm of (0.3, −0.7), at most 0.5.
TEST_F(ByDuration, NormIsFormedBeforeScaling) {
  const double norm = std::hypot(0.3 - 0.1, -0.7 - 0.2);
  const auto names = knot_names(*pendulum({}));
  const KnotModel model(step_with(pendulum({}), Integrator::rk4, Memory::none, 2));
  const ParsedExpressionResidual parsed = make_expression_residual(
      model.manifold(), {.names = names, .rows = {names[0].name, names[1].name}});
  ASSERT_TRUE(parsed.residual);
  const RowsByDuration rows = rows_by_duration(ConstraintKind::norm, 1, {-kUnbounded}, {0.5});
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(1, 5);
  jacobian << 2.5 * 0.2 / norm, 2.5 * -0.9 / norm, 0, (norm - 0.5) / 0.8, 0;
  expect(term(parsed.residual, ConstraintKind::norm, rows), {0.1, 0.2, 0.5},
         Eigen::VectorXd::Constant(1, 2.5 * (norm - 0.5)), jacobian);
}

TEST_F(ByDuration, CoversConstraintsSoftByDistance) {
  const RowsByDuration rows = rows_by_duration(ConstraintKind::bounds, 1, {-1}, {1});
  for (const Softness softness : {Softness::hard, Softness::l2})
    EXPECT_THROW(by_duration(make_constraint("c", control_residual(4, 1), ConstraintKind::bounds, 1,
                                             softness),
                             rows, {.state = 3, .tangent = 3, .written = 1}),
                 std::invalid_argument);
  EXPECT_TRUE(term(control_residual(4, 1), ConstraintKind::bounds, rows).by_duration);
}

}  // namespace
}  // namespace conddp
