#include "analysis/findings/long_step.hpp"

#include <complex>
#include <map>
#include <memory>

#include <Eigen/Eigenvalues>

#include "base/exceeds.hpp"

namespace conddp {
namespace {

/// What a rule of this order, with as many stages, multiplies a motion x' = λ x by, z = h λ.
double growth_of(std::complex<double> z, int order) {
  std::complex<double> sum = 1, term = 1;
  for (int i = 1; i <= order; ++i) sum += term *= z / static_cast<double>(i);
  return std::abs(sum);
}

/// Eigenvalues of the linearized motion, whose data have been differentiated.
Eigen::VectorXcd modes_of(const System& system, const SystemData<double>& data) {
  const int n = system.ndx(), rows = system.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  A.topRightCorner(n - rows, n - rows).setIdentity();
  A.bottomRows(rows) = Eigen::Map<const Eigen::MatrixXd>(data.fx.data(), rows, n);
  if (!A.allFinite()) return {};
  return A.eigenvalues();
}

}  // namespace

std::optional<LongStep> long_step(const ShootingProblem& problem, const Trajectory& trajectory) {
  constexpr double kLeastGrowth = 2, kLeastDecay = 1, kStable = 2;
  std::map<const System*, std::unique_ptr<SystemData<double>>> memory;
  LongStep worst{.growth = kLeastGrowth};
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const IntegratorInfo& rule = info_of(model.integrator());
    if (rule.kind != StepKind::runge_kutta || problem.takes_no_time(k)) continue;
    const System& system = model.system();
    auto& data = memory[&system];
    if (!data) data = system.create_data(double{});
    const double* x = trajectory.x(k).data();
    const KnotInput<double> in{x, trajectory.u(k).data(), nullptr, problem.knot(k).dt, 1};
    system.differentiate(x, model.first_control(in), *data);
    const double h = model.step(in.dt, x);
    const Eigen::VectorXcd modes = modes_of(system, *data);
    for (const std::complex<double>& mode : modes) {
      const double growth = growth_of(h * mode, rule.order);
      if (h * mode.real() > -kLeastDecay || !exceeds(growth, worst.growth)) continue;
      worst = {
          .knot = k, .rate = -mode.real(), .growth = growth, .longest = kStable / std::abs(mode)};
    }
  }
  if (worst.rate == 0) return std::nullopt;
  return worst;
}

}  // namespace conddp
