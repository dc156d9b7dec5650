#include "analysis/findings/long_step.hpp"

#include <algorithm>
#include <complex>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/exceeds.hpp"
#include "base/matrix_decompositions.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// Total size of the states that are linearized, which keeps the time far below that of a solve.
constexpr int kSampledNumbers = 1000;

/// Growth factor of a motion x' = λ x in a step of a rule with this order and as many stages, z = h
/// λ.
double growth_of(std::complex<double> z, int order) {
  std::complex<double> sum = 1, term = 1;
  for (int i = 1; i <= order; ++i) sum += term *= z / static_cast<double>(i);
  return std::abs(sum);
}

/// Linearized motion x' = A x, from differentiated data.
Eigen::MatrixXd linear_motion(const System& system, const SystemData<double>& data) {
  const int n = system.ndx(), rows = system.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  A.topRightCorner(n - rows, n - rows).setIdentity();
  A.bottomRows(rows) = Eigen::Map<const Eigen::MatrixXd>(data.fx.data(), rows, n);
  return A;
}

double row_sum(const Eigen::MatrixXd& A) { return A.cwiseAbs().rowwise().sum().maxCoeff(); }

/// Upper bound on the absolute values of all eigenvalues.
double bound_of_eigenvalues(const Eigen::MatrixXd& A) {
  return std::min(row_sum(A), row_sum(A.transpose()));
}

/// A motion grows above this factor; below it, the growth is rounding.
constexpr double kGrows = 1 + 1e-6;

/// The worst motion of an explicit rule: |R(h λ)| > 1 with Re h λ ≤ −1. This requires |h λ| ≥ √2
/// for Euler's rule, and more for others.
LongStep explicit_step(const Eigen::MatrixXd& A, double h, int order) {
  constexpr double kLeastSize = 1.4, kLeastDecay = 1, kStable = 2;
  LongStep worst{.growth = kGrows};
  if (bound_of_eigenvalues(A) * h < kLeastSize) return worst;
  const Eigen::VectorXcd modes = A.eigenvalues();
  for (const std::complex<double>& mode : modes) {
    const double growth = growth_of(h * mode, order);
    if (h * mode.real() > -kLeastDecay || !(growth > worst.growth)) continue;
    const double rate = std::abs(mode);
    worst = {.step = h, .rate = rate, .growth = growth, .longest = kStable / rate};
  }
  return worst;
}

/// Growth factor of a semi-implicit step by its eigenvalue farthest below −1; otherwise 1.
double alternating_growth(const Eigen::MatrixXd& A, double h) {
  const int n = static_cast<int>(A.rows()) / 2;
  // −2 v = (h²/2 A_q + h A_v) v at the limit of stability, where q⁺ = −q and v⁺ = −v.
  Eigen::MatrixXd limit = h / 2 * (h / 2 * A.bottomLeftCorner(n, n) + A.bottomRightCorner(n, n));
  if (bound_of_eigenvalues(limit) < 1) return 1;
  limit = limit * limit;
  limit = limit * limit;
  if (bound_of_eigenvalues(limit) < 1) return 1;
  Eigen::MatrixXd G(2 * n, 2 * n);
  G.bottomRows(n) = h * A.bottomRows(n);
  G.bottomRightCorner(n, n).diagonal().array() += 1;
  G.topRows(n) = h * G.bottomRows(n);
  G.topLeftCorner(n, n).diagonal().array() += 1;
  double growth = 1;
  const Eigen::VectorXcd modes = G.eigenvalues();
  for (const std::complex<double>& mode : modes)
    if (mode.real() < -kGrows) growth = std::max(growth, std::abs(mode));
  return growth;
}

/// Adds the rate and the longest stable step to an unstable semi-implicit step.
void complete(const Eigen::MatrixXd& A, LongStep& step) {
  step.rate = A.eigenvalues().cwiseAbs().maxCoeff();
  step.longest = step.step / 2;
  while (alternating_growth(A, step.longest) > 1) step.longest /= 2;
}

}  // namespace

std::optional<LongStep> long_step(const ShootingProblem& problem, const Trajectory& trajectory) {
  std::map<const System*, std::unique_ptr<SystemData<double>>> memory;
  const int samples = std::max(1, kSampledNumbers / problem.ndx());
  const int stride = (problem.knots() + samples - 1) / samples;
  LongStep worst{.growth = kGrows};
  Eigen::MatrixXd semi_implicit;  // the linearized motion of `worst`, if it is such a step
  int since = 0, phase = -1;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const IntegratorInfo& rule = info_of(model.integrator());
    const bool is_explicit = rule.kind == StepKind::runge_kutta;
    if (problem.takes_no_time(k) || (!is_explicit && rule.kind != StepKind::semi_implicit) ||
        model.system().as_stepping() != nullptr)
      continue;
    // Samples the first step of a phase, and others a stride apart.
    since = problem.knot(k).phase == phase ? since + 1 : 0;
    phase = problem.knot(k).phase;
    if (since % stride != 0) continue;
    const System& system = model.system();
    auto& data = memory[&system];
    if (!data) data = system.create_data(double{});
    const double* x = trajectory.x(k).data();
    system.differentiate(x, model.step().first_control(x, trajectory.u(k).data()), *data);
    Eigen::MatrixXd A = linear_motion(system, *data);
    if (!A.allFinite()) continue;
    const double h = model.step().time_step(problem.knot(k).dt, x);
    LongStep step = is_explicit ? explicit_step(A, h, rule.order)
                                : LongStep{.step = h, .growth = alternating_growth(A, h)};
    step.knot = k;
    if (!exceeds(step.growth, worst.growth)) continue;
    worst = step;
    semi_implicit = is_explicit ? Eigen::MatrixXd() : std::move(A);
  }
  if (semi_implicit.size() > 0) complete(semi_implicit, worst);
  if (worst.rate == 0) return std::nullopt;
  return worst;
}

bool allows_collocation(const ShootingProblem& problem) {
  for (const Phase& phase : problem.phases()) {
    const System& system = phase.model->system();
    const MultibodySystem* robot = system.robot_inside();
    if (system.as_stepping() != nullptr || (robot != nullptr && !robot->contacts().empty()))
      return false;
  }
  return true;
}

std::string remedy_of(const LongStep& step, const ShootingProblem& problem) {
  const bool implicit = problem.manifold().curved().empty() && allows_collocation(problem);
  return fmt::format("{}steps of at most {:.2g} s there, by more knots",
                     implicit ? "'integrator: radau5', stable in steps of any length, or " : "",
                     step.longest);
}

}  // namespace conddp
