#include "analysis/terminal/terminal_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "analysis/terminal/terminal_ellipsoid.hpp"
#include "base/random_numbers.hpp"
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

}  // namespace

bool TerminalConditions::hold() const {
  return std::all_of(conditions.begin(), conditions.end(),
                     [](const TerminalCondition& c) { return c.holds; });
}

TerminalConditions check_terminal_conditions(const TerminalIngredients& ingredients,
                                             const ConditionOptions& options) {
  return ConditionChecker(ingredients, options).check();
}

}  // namespace conddp
