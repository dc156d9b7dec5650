#include "analysis/terminal/terminal_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Rows that a unit of the ellipsoid moves by less are constant.
constexpr double kSmallestReach = 1e-12;

/// Meets bounds one by one.
class SetBuilder {
 public:
  explicit SetBuilder(const TerminalIngredients& ingredients)
      : given_(ingredients), eigen_(ingredients.regulator.P), linear_(*ingredients.knot) {
    Trajectory trajectory = given_.knot->create_trajectory();
    trajectory.u(0) = given_.u;
    Evaluator(*given_.knot).differentiate(trajectory, linear_);
  }

  TerminalSet build() {
    add_control_bounds();
    for (const NodeConstraint& constraint : given_.knot->constraints())
      if (constraint.node == 0 && !constraint.is_soft()) add_constraint(constraint);
    std::stable_sort(set_.bounds.begin(), set_.bounds.end(),
                     [](const auto& a, const auto& b) { return a.level < b.level; });
    set_.level = set_.bounds.empty() ? kUnbounded : set_.bounds.front().level;
    return std::move(set_);
  }

 private:
  /// The columns of rows of P^−½ C T-coordinates: how far the ellipsoid of level 1 moves them.
  Eigen::MatrixXd scaled(const Eigen::MatrixXd& rows) const {
    const Eigen::VectorXd& values = eigen_.eigenvalues();
    Eigen::MatrixXd out = rows * eigen_.eigenvectors();
    for (int i = 0; i < values.size(); ++i)
      out.col(i) /= std::sqrt(std::max(values[i], std::numeric_limits<double>::min()));
    return out;
  }

  /// Rows of z under the regulator, by the coordinates of the tangent space.
  Eigen::MatrixXd under_regulator(const Eigen::MatrixXd& C) const {
    const int n = static_cast<int>(given_.tangent.rows());
    return C.leftCols(n) * given_.tangent - C.rightCols(C.cols() - n) * given_.regulator.K;
  }

  /// Something that the ellipsoid of level 1 moves by `reach`, `distance` from where it may go.
  void add(std::string name, double distance, double reach) {
    if (reach < kSmallestReach || distance == kUnbounded) return;
    const double steps = std::max(distance, 0.0) / reach;
    set_.bounds.push_back({std::move(name), distance, steps * steps});
  }

  void add_control_bounds() {
    const KnotModel& model = *given_.knot->knot(0).model;
    const Eigen::MatrixXd reach = scaled(given_.regulator.K);
    for (int i = 0; i < model.nu(); ++i)
      add(model.system().control_columns()[i].name,
          std::min(model.control_upper()[i] - given_.u[i], given_.u[i] - model.control_lower()[i]),
          reach.row(i).norm());
  }

  void add_constraint(const NodeConstraint& constraint) {
    const ConstraintTerm& term = *constraint.term;
    const Eigen::MatrixXd reach =
        scaled(under_regulator(linear_.knots[0].C.middleRows(constraint.row, term.rows)));
    const Eigen::VectorXd value = linear_.constraint.segment(constraint.row, term.rows);
    if (term.is_cone()) return add_cone(term, value, reach);
    if (!term.has_bounds()) return;
    for (int i = 0; i < term.rows; ++i)
      add(term.rows == 1 ? term.name : fmt::format("{} row {}", term.name, i + 1),
          std::min(constraint.upper[i] - value[i], value[i] - constraint.lower[i]),
          reach.row(i).norm());
  }

  /// ‖v‖ ≤ t holds where v and t together move by less than t − ‖v‖.
  void add_cone(const ConstraintTerm& term, const Eigen::VectorXd& value,
                const Eigen::MatrixXd& reach) {
    const int n = term.rows - 1;
    const double across = Eigen::JacobiSVD<Eigen::MatrixXd>(reach.topRows(n)).singularValues()[0];
    add(term.name, value[n] - value.head(n).norm(), across + reach.row(n).norm());
  }

  const TerminalIngredients& given_;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_;
  Linearization linear_;
  TerminalSet set_;
};

}  // namespace

TerminalSet largest_terminal_set(const TerminalIngredients& ingredients) {
  return SetBuilder(ingredients).build();
}

}  // namespace conddp
