#include "analysis/terminal/terminal_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "analysis/terminal/terminal_ellipsoid.hpp"
#include "base/matrix_decompositions.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Rows that a unit of the ellipsoid moves by less are constant.
constexpr double kSmallestReach = 1e-12;

/// Adds bounds one by one.
class SetBuilder {
 public:
  explicit SetBuilder(const TerminalIngredients& ingredients)
      : given_(ingredients),
        ellipsoid_(terminal_ellipsoid(ingredients.regulator.P)),
        linear_(*ingredients.knot) {
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
  /// Largest joint move of linear functions over the ellipsoid of level 1; `rows` are in
  /// coordinates of the tangent space. Infinite if directions without cost move them, or if rows
  /// are not finite.
  double reach(const Eigen::MatrixXd& rows) const {
    constexpr double kSmallShare = 1e-8;  // √ε
    if (!rows.allFinite()) return kUnbounded;
    if ((rows * ellipsoid_.free).norm() > kSmallShare * rows.norm()) return kUnbounded;
    const Eigen::MatrixXd moved = rows * ellipsoid_.axes;
    if (moved.size() == 0 || moved.rows() == 1) return moved.norm();
    return Eigen::JacobiSVD<Eigen::MatrixXd>(moved).singularValues()[0];
  }

  /// Rows of z under the regulator, in coordinates of the tangent space. Rows that integrals move
  /// are infinite.
  Eigen::MatrixXd under_regulator(const Eigen::MatrixXd& C) const {
    const int n = static_cast<int>(given_.tangent.rows());
    Eigen::MatrixXd rows =
        C.leftCols(n) * given_.tangent - C.rightCols(C.cols() - n) * given_.regulator.K;
    const KnotModel& model = *given_.knot->knot(0).model;
    for (const int column : model.step().held_columns())
      for (Eigen::Index i = 0; i < rows.rows(); ++i)
        if (C(i, column) != 0) rows.row(i).setConstant(kUnbounded);
    return rows;
  }

  /// Adds a quantity that the ellipsoid of level 1 moves by `reach`, at `distance` from its bound.
  void add(std::string name, double distance, double reach) {
    if (reach < kSmallestReach || distance == kUnbounded) return;
    const double steps = std::max(distance, 0.0) / reach;
    set_.bounds.push_back({std::move(name), distance, steps * steps});
  }

  void add_control_bounds() {
    const KnotModel& model = *given_.knot->knot(0).model;
    for (int i = 0; i < model.nu(); ++i)
      add(model.system().control_columns()[i].name,
          std::min(model.control_upper()[i] - given_.u[i], given_.u[i] - model.control_lower()[i]),
          reach(given_.regulator.K.row(i)));
  }

  void add_constraint(const NodeConstraint& constraint) {
    const ConstraintTerm& term = *constraint.term;
    const Eigen::MatrixXd rows =
        under_regulator(linear_.knots[0].C.middleRows(constraint.row, term.rows));
    const Eigen::VectorXd value = linear_.constraint.segment(constraint.row, term.rows);
    if (term.is_cone()) return add_cone(term, value, rows);
    if (term.kind == ConstraintKind::norm) return add_norm(constraint, rows);
    if (!term.has_bounds()) return;
    for (int i = 0; i < term.rows; ++i)
      add(term.rows == 1 ? term.name : fmt::format("{} row {}", term.name, i + 1),
          std::min(constraint.upper[i] - value[i], value[i] - constraint.lower[i]),
          reach(rows.row(i)));
  }

  /// ‖r‖ ≤ upper holds if r moves by less than upper − ‖r‖. For lower ≤ ‖r‖ the slope suffices,
  /// because ‖r‖ is convex.
  void add_norm(const NodeConstraint& constraint, const Eigen::MatrixXd& slope) {
    const ConstraintTerm& term = *constraint.term;
    const auto [r, J] = differentiated(term);
    const double norm = r.norm(), lower = constraint.lower[0];
    add(term.name, constraint.upper[0] - norm, reach(under_regulator(J)));
    if (lower > 0) add(term.name, norm - lower, norm > lower ? reach(slope) : kUnbounded);
  }

  /// A residual and its derivative with respect to z at the equilibrium.
  std::pair<Eigen::VectorXd, Eigen::MatrixXd> differentiated(const ConstraintTerm& term) const {
    const KnotView& knot = given_.knot->knot(0);
    const System& system = knot.model->system();
    const auto data = system.create_data(double{});
    system.differentiate(given_.x.data(), given_.u.data(), *data);
    const Residual& residual = *term.residual;
    Eigen::VectorXd r(residual.size()), packed(residual.jacobian_size());
    residual.differentiate(ResidualInput<double>{given_.x.data(), given_.u.data(),
                                                 knot.parameters + term.parameters, *data},
                           r.data(), packed.data());
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(residual.size(), knot.model->nz());
    int row = 0;
    const double* entry = packed.data();
    for (const RowBlock& block : residual.blocks()) {
      for (const int column : block.columns)
        for (int i = 0; i < block.rows; ++i) J(row + i, column) = *entry++;
      row += block.rows;
    }
    return {std::move(r), std::move(J)};
  }

  /// ‖v‖ ≤ t holds if v and t together move by less than t − ‖v‖.
  void add_cone(const ConstraintTerm& term, const Eigen::VectorXd& value,
                const Eigen::MatrixXd& rows) {
    const int n = term.rows - 1;
    add(term.name, value[n] - value.head(n).norm(), reach(rows.topRows(n)) + reach(rows.row(n)));
  }

  const TerminalIngredients& given_;
  TerminalEllipsoid ellipsoid_;
  Linearization linear_;
  TerminalSet set_;
};

}  // namespace

TerminalSet largest_terminal_set(const TerminalIngredients& ingredients) {
  return SetBuilder(ingredients).build();
}

}  // namespace conddp
