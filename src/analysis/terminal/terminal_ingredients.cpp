#include "analysis/terminal/terminal_ingredients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/matrix_decompositions.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "systems/multibody/multibody.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// In the solution of an equation, values below this share of the largest of n numbers are
/// rounding.
double rounding(int n) { return 16 * n * std::numeric_limits<double>::epsilon(); }

/// Square roots of the diagonal; 0 if they are rounding.
Eigen::VectorXd scale_of(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(0.0).cwiseSqrt();
  const double least = rounding(static_cast<int>(scale.size())) * scale.maxCoeff();
  return scale.unaryExpr([least](double s) { return s > least ? s : 0.0; });
}

/// A state that changes faster, in its units per second, is not an equilibrium.
constexpr double kLargestDrift = 1e-6;
/// Largest part of the linear map that may leave the contacts' tangent space, relative to its size.
constexpr double kLargestLeak = 1e-5;
/// Singular values of Jacobians below this share of the largest are rounding.
constexpr double kSmallestSingularValue = 1e-8;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size())};
}

/// A problem with a single knot of a phase, starting at a state.
std::shared_ptr<ShootingProblem> lone_knot(const EquilibriumGuess& guess) {
  const Phase& phase = guess.phase;
  const KnotModel& model = *phase.model;
  const auto first = phase.parameters.begin() + guess.knot * model.parameter_count();
  Phase knot{.name = phase.name,
             .model = phase.model,
             .dt = {phase.dt[guess.knot]},
             .cost_scale = {phase.cost_scale[guess.knot]},
             .parameters = {first, first + model.parameter_count()}};
  auto end = std::make_shared<KnotModel>(model.step().without_dynamics());
  return std::make_shared<ShootingProblem>(
      guess.x, std::vector{std::move(knot)},
      Phase{.name = "end", .model = std::move(end), .dt = {0.0}, .cost_scale = {1.0}});
}

/// Unit vectors of the first coordinates, without those that no control moves.
Eigen::MatrixXd own_directions(const System& system, int count) {
  Eigen::MatrixXd E = Eigen::MatrixXd::Identity(count, count);
  std::vector<int> own;
  const std::vector<int> others = other_coordinates(system);
  for (int i = 0; i < count; ++i)
    if (std::ranges::find(others, i) == others.end()) own.push_back(i);
  return E(Eigen::all, own);
}

/// Orthonormal basis of the velocities that the contacts of a robot allow in a state at rest.
Eigen::MatrixXd allowed_velocities(const MultibodySystem& system, const double* x) {
  const int nv = system.nv(), rows = system.contacts().rows();
  MultibodySystem::Data<double> data(system);
  system.update_kinematics(x, static_cast<SystemData<double>&>(data));
  system.contacts().update(system.robot(), data.robot, nv, data.contacts);  // Jᵀ in `response`
  const Eigen::Map<const Eigen::MatrixXd> Jt(data.contacts.response.data(), nv, rows);
  const Eigen::MatrixXd E = own_directions(system, nv);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(E.transpose() * Jt, Eigen::ComputeFullU);
  const Eigen::VectorXd& values = svd.singularValues();
  const int rank =
      static_cast<int>((values.array() > kSmallestSingularValue * values.maxCoeff()).count());
  return E * svd.matrixU().rightCols(E.cols() - rank);
}

/// Tangent vectors of the states that a knot allows.
Eigen::MatrixXd tangent_space(const KnotModel& model, const double* x) {
  const Step& step = model.step();
  const int n = model.ndx(), memory = step.tail() - static_cast<int>(step.held_columns().size());
  const MultibodySystem* system = model.system().as_multibody();
  const bool touches = system != nullptr && !system->contacts().empty();
  const int own = model.system().ndx(), nv = own / 2;
  const Eigen::MatrixXd N =
      touches ? allowed_velocities(*system, x) : own_directions(model.system(), own);
  const int free = static_cast<int>(N.cols());
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, (touches ? 2 * free : free) + memory);
  T.topLeftCorner(N.rows(), free) = N;
  if (touches) T.block(nv, free, nv, free) = N;
  T.bottomRightCorner(memory, memory).setIdentity();
  return T;
}

/// Finds the ingredients step by step; a step returns false if it fails.
class IngredientsFinder {
 public:
  IngredientsFinder(const EquilibriumGuess& guess, const std::vector<std::string>& names)
      : names_(names),
        problem_(lone_knot(guess)),
        model_(*problem_->knot(0).model),
        evaluator_(*problem_),
        trajectory_(problem_->create_trajectory()),
        linear_(*problem_),
        unmoved_(other_coordinates(model_.system())) {
    const std::vector<int> held = model_.step().held_columns();
    unmoved_.insert(unmoved_.end(), held.begin(), held.end());
    trajectory_.u(0) = guess.u;
  }

  TerminalResult find() {
    if (has_control() && costs_no_unmoved() && stays() && within_bounds() && linearize()) solve();
    return std::move(result_);
  }

 private:
  bool fail(std::string fault, std::string hint = {}) {
    result_ = {std::nullopt, std::move(fault), std::move(hint)};
    return false;
  }

  bool has_control() {
    return model_.nu() > 0 || fail("the system has no control", "a regulator needs one");
  }

  /// Costs on coordinates that no control moves never end, nor do those on integrals, which keep
  /// growing.
  bool costs_no_unmoved() {
    for (const CostTerm& cost : model_.costs())
      for (const RowBlock& block : cost.residual->blocks())
        for (const int column : block.columns)
          if (std::ranges::find(unmoved_, column) != unmoved_.end())
            return fail(fmt::format("the running cost '{}' depends on '{}', which no regulator "
                                    "can control",
                                    cost.name, names_[column]),
                        "leave it out of costs of the last phase that takes time");
    return true;
  }

  /// Takes Newton steps on the control within bounds while they reduce the drift of the state.
  /// Returns true if the state is an equilibrium.
  bool hold(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
    constexpr int kMost = 20;
    double best = move_to(trajectory_.u(0).cwiseMax(lower).cwiseMin(upper));
    for (int i = 0; i < kMost && best > 0; ++i) {
      const Eigen::VectorXd former = trajectory_.u(0);
      const double now = move_to(newton_step(former, lower, upper));
      if (now < best) {
        best = now;
        continue;
      }
      move_to(former);
      break;
    }
    return drift_ <= kLargestDrift;
  }

  /// Nearest control that keeps the linear map at the state. Controls that would exceed their
  /// bounds stay at them, and the others compensate.
  Eigen::VectorXd newton_step(const Eigen::VectorXd& u, const Eigen::VectorXd& lower,
                              const Eigen::VectorXd& upper) const {
    const int n = model_.system().ndx(), m = model_.nu();
    const Eigen::MatrixXd B = linear_.knots[0].dense_jacobian().topRightCorner(n, m);
    const Eigen::VectorXd gap = linear_.gap.col(0).head(n);
    Eigen::VectorXd next = u;
    Eigen::MatrixXd free = B;  // columns of controls at their bounds are zero
    // Controls that oppose each other through contacts move the state by rounding only.
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> moved;
    moved.setThreshold(kSmallestSingularValue);
    for (int pass = 0; pass <= m; ++pass) {
      const Eigen::VectorXd rest = gap + (B - free) * (next - u);
      moved.compute(free);
      const Eigen::VectorXd step = -moved.solve(rest);
      bool within = true;
      for (int i = 0; i < m; ++i) {
        if (free.col(i).isZero(0)) continue;
        next[i] = std::clamp(u[i] + step[i], lower[i], upper[i]);
        if (next[i] == u[i] + step[i]) continue;
        free.col(i).setZero();
        within = false;
      }
      if (within) break;
    }
    return next;
  }

  /// Linearizes at a control and returns the drift of the state.
  double move_to(const Eigen::VectorXd& u) {
    trajectory_.u(0) = u;
    for (int k : {0, 1}) model_.step().hand_on(u.data(), trajectory_.x(k).data());
    evaluator_.differentiate(trajectory_, linear_);
    Eigen::VectorXd gap = linear_.gap.col(0);
    for (const int column : model_.step().held_columns()) gap[column] = 0;
    drift_ = gap.cwiseAbs().maxCoeff(&fastest_) / problem_->knot(0).dt;
    return std::isfinite(drift_) ? drift_ : kInfinity;
  }

  bool stays() {
    const Eigen::VectorXd infinite = Eigen::VectorXd::Constant(model_.nu(), kInfinity);
    if (hold(-infinite, infinite)) return true;
    if (!std::isfinite(drift_))
      return fail("the system is not finite at this state, or its derivatives are not",
                  "give a state at rest that controls and contacts can hold");
    return fail(fmt::format("the state is not an equilibrium: with the control that holds it best, "
                            "'{}' changes by {:.3g} in a second",
                            names_[fastest_], drift_),
                "give a state at rest that controls and contacts can hold");
  }

  /// If the smallest control that holds the state exceeds bounds, another one may hold it.
  bool within_bounds() {
    const Eigen::VectorXd u = trajectory_.u(0);
    for (int i = 0; i < model_.nu(); ++i) {
      const double lower = model_.control_lower()[i], upper = model_.control_upper()[i];
      if (u[i] >= lower && u[i] <= upper) continue;
      if (hold(as_vector(model_.control_lower()), as_vector(model_.control_upper()))) return true;
      return fail(
          fmt::format("the control that holds the state exceeds its bounds: '{}' is {:.4g}, "
                      "and may be {:.4g} to {:.4g}",
                      model_.system().control_columns()[i].name, u[i], lower, upper));
    }
    return true;
  }

  /// Computes the linear map of the knot and the exact Hessian of its cost on the tangent space.
  bool linearize() {
    const int n = model_.ndx(), m = model_.nu();
    Eigen::MatrixXd F = linear_.knots[0].dense_jacobian();
    for (const int column : model_.step().held_columns()) F.row(column).setZero();
    T_ = tangent_space(model_, trajectory_.x(0).data());
    const Eigen::MatrixXd A = F.leftCols(n) * T_, B = F.rightCols(m);
    const auto across = [this](const Eigen::MatrixXd& M) {
      return (M - T_ * (T_.transpose() * M)).cwiseAbs().maxCoeff() / M.cwiseAbs().maxCoeff();
    };
    for (const int other : other_coordinates(model_.system()))
      if (const Eigen::VectorXd shift = T_.transpose() * F.col(other);
          !(shift.cwiseAbs().maxCoeff() <= kLargestLeak * A.cwiseAbs().maxCoeff()))
        return fail(
            fmt::format("the equilibrium depends on '{}', which no control moves", names_[other]),
            "write a terminal cost on the states: '{residual: state, columns: [x, v]}'");
    const double leak = std::max(across(A), across(B));
    if (!(leak <= kLargestLeak))
      return fail(
          fmt::format(
              "the contacts are not held exactly: a step leaves their tangent space by {:.3g}",
              leak),
          "redundant contacts are soft; leave some out");
    evaluator_.lagrangian_hessian(trajectory_, Eigen::MatrixXd::Zero(n, 2), linear_);
    const Eigen::MatrixXd H = linear_.knots[0].hessian();
    problem_of_y_ = {.A = T_.transpose() * A,
                     .B = T_.transpose() * B,
                     .Q = T_.transpose() * H.topLeftCorner(n, n) * T_,
                     .R = H.bottomRightCorner(m, m),
                     .S = T_.transpose() * H.topRightCorner(n, m)};
    return true;
  }

  bool solve() {
    RegulatorResult solved = solve_regulator(problem_of_y_);
    if (!solved.regulator) return explain(solved);
    solved.regulator->P = without_rounding(solved.regulator->P);
    TerminalIngredients& out = result_.ingredients.emplace();
    out.x.assign(trajectory_.x(0).begin(), trajectory_.x(0).end());
    problem_->set_initial_state(out.x);
    out.knot = problem_;
    out.u = trajectory_.u(0);
    out.drift = drift_;
    out.cost = linear_.cost[0];
    out.gradient = linear_.knots[0].gradient;
    out.P = T_ * solved.regulator->P * T_.transpose();
    out.P = without_rounding(0.5 * (out.P + out.P.transpose()));
    out.K = solved.regulator->K * T_.transpose();
    out.tangent = std::move(T_);
    out.linear = std::move(problem_of_y_);
    out.regulator = *std::move(solved.regulator);
    return true;
  }

  bool explain(const RegulatorResult& solved) {
    switch (solved.fault) {
      case RegulatorFault::control_cost:
        return fail(fmt::format("the running cost leaves a direction of the control free: the "
                                "least eigenvalue of its scaled Hessian in the control is {:.3g}",
                                solved.eigenvalue),
                    "a regulator needs a cost on every control");
      case RegulatorFault::state_cost:
        return fail(fmt::format("the running cost is not convex at the state: the least eigenvalue "
                                "of its scaled Hessian without the control is {:.3g}",
                                solved.eigenvalue),
                    "references that differ from the state may cause this");
      case RegulatorFault::not_stabilizable:
        return fail(fmt::format("no control moves {}", describe(*solved.mode)),
                    "leave such states out of the system, or give it a control");
      case RegulatorFault::not_detectable:
        return fail(fmt::format("the running cost does not depend on {}", describe(*solved.mode)),
                    "give these states a running cost");
      default:
        return fail("rounding spoils the solution of the Riccati equation",
                    "scale the costs, or the units, nearer to each other");
    }
  }

  /// "the mode with eigenvalue 1.05 of 'theta' and 'omega', which does not decay".
  std::string describe(const LinearMode& mode) const {
    constexpr int kMost = 4;
    constexpr double kSmallShare = 0.1;
    const Eigen::VectorXd share = (T_ * mode.share).cwiseAbs();
    std::vector<int> order(share.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return share[a] > share[b]; });
    std::vector<std::string> parts;
    for (const int i : order)
      if (share[i] > kSmallShare * share.maxCoeff() && static_cast<int>(parts.size()) < kMost)
        parts.push_back("'" + names_[i] + "'");
    const double im = std::abs(mode.eigenvalue.imag());
    const std::string eigenvalue = im > 0
                                       ? fmt::format("{:.6g} ± {:.3g}i", mode.eigenvalue.real(), im)
                                       : fmt::format("{:.6g}", mode.eigenvalue.real());
    return fmt::format("the mode with eigenvalue {} of {}, which does not decay", eigenvalue,
                       fmt::join(parts, ", "));
  }

  const std::vector<std::string>& names_;
  std::shared_ptr<ShootingProblem> problem_;
  const KnotModel& model_;
  Evaluator evaluator_;
  Trajectory trajectory_;
  Linearization linear_;
  std::vector<int> unmoved_;  ///< coordinates that no control moves
  double drift_ = 0;
  Eigen::Index fastest_ = 0;
  Eigen::MatrixXd T_;
  RegulatorProblem problem_of_y_;
  TerminalResult result_;
};

}  // namespace

Eigen::MatrixXd without_rounding(const Eigen::MatrixXd& matrix) {
  const int n = static_cast<int>(matrix.rows());
  const Eigen::VectorXd scale = scale_of(matrix);
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd scaled = inverse.asDiagonal() * matrix * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const int rank = static_cast<int>((eigen.eigenvalues().array() > rounding(n)).count());
  if (rank == n) return matrix;
  const Eigen::MatrixXd L = scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                            eigen.eigenvalues().tail(rank).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd product = L * L.transpose();
  return 0.5 * (product + product.transpose());
}

TerminalEllipsoid terminal_ellipsoid(const Eigen::MatrixXd& P) {
  const int n = static_cast<int>(P.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(P);
  const Eigen::VectorXd& values = eigen.eigenvalues();  // ascending
  const double least = rounding(n) * std::max(values[n - 1], 0.0);
  const int rank = static_cast<int>((values.array() > least).count());
  return {eigen.eigenvectors().rightCols(rank) *
              values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal(),
          eigen.eigenvectors().leftCols(n - rank)};
}

TerminalResult find_terminal_ingredients(const EquilibriumGuess& guess,
                                         const std::vector<std::string>& names) {
  return IngredientsFinder(guess, names).find();
}

}  // namespace conddp
