#include "analysis/findings/singular_rate.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "systems/system.hpp"

namespace conddp {
namespace {

/// The equations of a knot, linearized in any state.
class KnotEquations {
 public:
  KnotEquations(const KnotModel& model, const double* u, double dt)
      : system_(model.system()), u_(u), dt_(dt), data_(system_.create_data(double{})) {}

  void look(const Eigen::VectorXd& x) { system_.differentiate(x.data(), u_, *data_); }
  /// First row that is not finite, or −1.
  int singular_row() const {
    for (int i = 0; i < system_.rows(); ++i)
      if (!std::isfinite(data_->f[i])) return i;
    return -1;
  }
  /// True if no state changes its own rate much within the step.
  bool is_resolved() const {
    const Eigen::Map<const Eigen::MatrixXd> fx(data_->fx.data(), system_.rows(), system_.ndx());
    return fx.allFinite() && (system_.kind() == SystemKind::discrete ||
                              dt_ * fx.cwiseAbs().rowwise().sum().maxCoeff() <= 1);
  }

 private:
  const System& system_;
  const double* u_;
  const double dt_;
  std::unique_ptr<SystemData<double>> data_;
};

}  // namespace

std::optional<SingularRate> singular_rate(const ShootingProblem& problem,
                                          const Trajectory& trajectory, int knot) {
  const KnotModel& model = *problem.knot(knot).model;
  const System& system = model.system();
  if (system.robot_inside() != nullptr || system.as_collocation() != nullptr) return std::nullopt;
  const Eigen::VectorXd x = trajectory.x(knot).head(system.nx());
  const double* u =
      model.step().first_control(trajectory.x(knot).data(), trajectory.u(knot).data());
  KnotEquations equations(model, u, problem.knot(knot).dt);
  equations.look(x);
  const int row = equations.singular_row();
  if (row < 0) return std::nullopt;
  const std::vector<Column> columns = tangent_columns(system);
  SingularRate found{.row = columns[system.ndx() - system.rows() + row].name};
  if (!system.manifold().curved().empty()) return found;
  const std::vector<Column>& states = system.state_columns();
  for (int i = 0; i < system.nx() && found.state.empty(); ++i) {
    if (states[i].by_name_only) continue;
    for (const double share : {0.01, 0.1, 1.0}) {
      Eigen::VectorXd moved = x;
      moved[i] += share * std::max(1.0, std::abs(x[i]));
      equations.look(moved);
      if (equations.singular_row() >= 0) continue;
      found.state = states[i].name;
      found.value = x[i];
      found.nearby = moved[i];
      if (equations.is_resolved()) break;
    }
  }
  return found;
}

}  // namespace conddp
