#include "analysis/terminal/terminal_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>

#include "base/matrix_decompositions.hpp"
#include "base/random_numbers.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/node_values.hpp"

namespace conddp {
namespace {

constexpr int kLevels = 11;           ///< each a fourth of the previous one
constexpr double kLargestMove = 0.1;  ///< of a state, if nothing bounds the ellipsoid
/// Relative rounding allowed when decreases are compared with stage costs.
constexpr double kRounding = 1e-8;

/// Figures at one level of the ellipsoid.
struct Measured {
  double state_violation = 0, control_violation = 0;
  double ratio = 0;  ///< largest V(x⁺) / level
  double decrease = std::numeric_limits<double>::infinity();
};

class ConditionChecker {
 public:
  ConditionChecker(const TerminalIngredients& ingredients, const ConditionOptions& options)
      : given_(ingredients),
        options_(options),
        model_(*ingredients.knot->knot(0).model),
        axes_(terminal_ellipsoid(given_.regulator.P).axes),
        evaluation_(*ingredients.knot) {}

  TerminalConditions check() {
    if (axes_.cols() == 0) return {};
    const double largest = level();
    if (largest <= 0) return check_equilibrium();
    draw();
    TerminalConditions out{.level = largest, .samples = options_.samples, .conditions = named()};
    double scale = 1;
    for (int k = 0; k < kLevels; ++k, scale /= 4) {
      const Measured m = measure(out.level * scale);
      const double figures[] = {m.state_violation, m.control_violation, m.ratio, m.decrease};
      const bool holds[] = {m.state_violation <= options_.tolerance,
                            m.control_violation <= options_.tolerance, m.ratio <= 1 + kRounding,
                            m.decrease >= 1 - kRounding};
      for (int i = 0; i < 4; ++i) {
        TerminalCondition& condition = out.conditions[i];
        if (k == 0) condition.holds = holds[i], condition.figure = figures[i];
        if (holds[i] && condition.level == 0) condition.level = out.level * scale;
      }
      if (m.decrease > 0 && out.decrease.level == 0)
        out.decrease = {out.level * scale, std::max(1.0, 1 / m.decrease)};
    }
    return out;
  }

 private:
  /// Conditions of a set that is the equilibrium alone: nothing leaves it, and nothing decreases.
  TerminalConditions check_equilibrium() {
    Measured m;
    measure_constraints(evaluation_.at(0, given_.x.data(), given_.u.data()), given_.u, m);
    TerminalConditions out{.conditions = named()};
    out.conditions.resize(2);
    out.conditions[0].figure = m.state_violation;
    out.conditions[1].figure = m.control_violation;
    for (TerminalCondition& c : out.conditions) c.holds = c.figure <= options_.tolerance;
    return out;
  }

  static std::vector<TerminalCondition> named() {
    return {{"A1", "constraints on the state hold in the set"},
            {"A2", "the regulator's control satisfies bounds and constraints in the set"},
            {"A3", "a step of the regulator stays in the set"},
            {"A4", "the terminal cost decreases by the stage cost at least"}};
  }

  /// Draws points of the unit ball in the coordinates of the ellipsoid, half of them on its
  /// boundary.
  void draw() {
    NormalNumbers random(options_.seed);
    const int m = static_cast<int>(axes_.cols());
    points_.resize(m, options_.samples);
    for (int s = 0; s < options_.samples; ++s) {
      for (int i = 0; i < m; ++i) points_(i, s) = random.next();
      points_.col(s).normalize();
      if (s % 2 == 1) points_.col(s) *= std::pow((s + 0.5) / options_.samples, 1.0 / m);
    }
  }

  double level() const {
    if (std::isfinite(options_.level)) return options_.level;
    // Level 1 moves state i by the length of this row.
    const Eigen::MatrixXd rows = given_.tangent * axes_;
    return kLargestMove * kLargestMove / rows.rowwise().squaredNorm().maxCoeff();
  }

  Measured measure(double level) {
    Measured out;
    for (int s = 0; s < options_.samples; ++s)
      measure(axes_ * (std::sqrt(level) * points_.col(s)), level, out);
    return out;
  }

  void measure(const Eigen::VectorXd& y, double level, Measured& out) {
    const Eigen::VectorXd dx = given_.tangent * y, du = -(given_.regulator.K * y);
    const Eigen::VectorXd u = given_.u + du;
    std::vector<double> x(given_.x.size());
    model_.manifold().integrate(given_.x.data(), dx.data(), x.data());
    const KnotWorkspace<double>& work = evaluation_.at(0, x.data(), u.data());
    measure_constraints(work, u, out);
    Eigen::VectorXd next(dx.size());
    model_.manifold().difference(given_.x.data(), work.next().data(), next.data());
    const double before = dx.dot(given_.P * dx), after = next.dot(given_.P * next);
    out.ratio = larger(out.ratio, after / level);
    Eigen::VectorXd z(dx.size() + du.size());
    z << dx, du;
    const double stage = work.cost - given_.cost - given_.gradient.dot(z);
    const double decrease = 0.5 * options_.weight * (before - after) / stage;
    if (!(out.decrease <= decrease)) out.decrease = decrease;
  }

  static double larger(double a, double b) { return b <= a ? a : b; }

  void measure_constraints(const KnotWorkspace<double>& work, const Eigen::VectorXd& u,
                           Measured& out) const {
    for (int i = 0; i < u.size(); ++i)
      out.control_violation =
          larger(out.control_violation,
                 std::max(u[i] - model_.control_upper()[i], model_.control_lower()[i] - u[i]));
    for (const NodeConstraint& c : given_.knot->constraints()) {
      if (c.node != 0 || c.is_soft()) continue;
      double& violation =
          c.term->depends_on_control(model_.ndx()) ? out.control_violation : out.state_violation;
      violation = larger(
          violation, distance_to_set(*c.term, work.constraint.data() + c.row, c.lower, c.upper));
    }
  }

  const TerminalIngredients& given_;
  const ConditionOptions& options_;
  const KnotModel& model_;
  Eigen::MatrixXd axes_;  ///< axes of the ellipsoid in the tangent space
  NodeEvaluation evaluation_;
  Eigen::MatrixXd points_;  ///< one point per column
};

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

bool TerminalConditions::hold() const {
  return std::all_of(conditions.begin(), conditions.end(),
                     [](const TerminalCondition& c) { return c.holds; });
}

TerminalConditions check_terminal_conditions(const TerminalIngredients& ingredients,
                                             const ConditionOptions& options) {
  return ConditionChecker(ingredients, options).check();
}

}  // namespace conddp
