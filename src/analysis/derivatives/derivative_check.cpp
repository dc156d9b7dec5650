#include "analysis/derivatives/derivative_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/problem.hpp"
#include "systems/libraries/slope_interval.hpp"

namespace conddp {
namespace {

using D = Dual<Lane>;

/// Derivatives of one knot, by either method.
struct KnotDerivatives {
  Eigen::MatrixXd dynamics;                ///< ndx x nz
  std::vector<Eigen::MatrixXd> residuals;  ///< rows x nz, one per cost
  Eigen::MatrixXd constraints;             ///< constraint rows x nz
  Eigen::MatrixXd gradient;                ///< 1 x nz
};

/// A knot in dual numbers that move along one direction of z.
class DualKnot {
 public:
  DualKnot(const KnotView& knot, const Trajectory& trajectory, int k, int direction)
      : model_(*knot.model), batch_(model_) {
    for (int i = 0; i < model_.nx(); ++i) batch_.x[i] = D(trajectory.x(k)[i]);
    for (int i = 0; i < model_.nu(); ++i) batch_.u[i] = D(trajectory.u(k)[i]);
    for (int i = 0; i < model_.parameter_count(); ++i) batch_.parameters[i] = D(knot.parameters[i]);
    batch_.dt = D(knot.dt);
    batch_.cost_scale = D(knot.cost_scale);
    if (direction < model_.ndx()) {
      batch_.tangent[direction].d = Lane(1.0);
      model_.manifold().integrate(batch_.x.data(), batch_.tangent.data(), batch_.x.data());
    } else {
      batch_.u[direction - model_.ndx()].d = Lane(1.0);
    }
    model_.evaluate(batch_.input(), batch_.work);
  }

  double cost() const { return batch_.work.cost.d[0]; }
  Eigen::VectorXd constraints() const {
    return derivatives(batch_.work.constraint.data(), model_.constraint_rows());
  }

  Eigen::VectorXd next() {
    const AlignedVector<D>& next = batch_.work.next();
    for (int i = 0; i < model_.nx(); ++i) batch_.x_next[i] = D(next[i].v, Lane(0.0));
    model_.manifold().difference(batch_.x_next.data(), next.data(), batch_.tangent.data());
    return derivatives(batch_.tangent.data(), model_.ndx());
  }

  Eigen::VectorXd residual(const CostTerm& term) {
    const System& system = model_.system();
    const auto data = system.create_data(D{});
    const KnotInput<D> in = batch_.input();
    if (model_.step().has_control())
      system.evaluate(in.x, model_.step().first_control(in.x, in.u), *data);
    else
      system.update_kinematics(in.x, *data);
    AlignedVector<D> r(term.residual->size());
    term.residual->evaluate(model_.residual_input(term.parameters, in, *data), r.data());
    return derivatives(r.data(), term.residual->size());
  }

 private:
  static Eigen::VectorXd derivatives(const D* values, int n) {
    Eigen::VectorXd result(n);
    for (int i = 0; i < n; ++i) result[i] = values[i].d[0];
    return result;
  }

  const KnotModel& model_;
  KnotBatch<D> batch_;
};

KnotDerivatives reference_derivatives(const KnotView& knot, const Trajectory& trajectory, int k) {
  const KnotModel& model = *knot.model;
  const bool terminal = model.integrator() == Integrator::none;
  KnotDerivatives out{Eigen::MatrixXd(terminal ? 0 : model.ndx(), model.nz()),
                      {},
                      Eigen::MatrixXd(model.constraint_rows(), model.nz()),
                      Eigen::MatrixXd(1, model.nz())};
  for (const CostTerm& term : model.costs())
    out.residuals.emplace_back(term.residual->size(), model.nz());
  for (int c = 0; c < model.nz(); ++c) {
    DualKnot dual(knot, trajectory, k, c);
    if (!terminal) out.dynamics.col(c) = dual.next();
    for (std::size_t t = 0; t < model.costs().size(); ++t)
      out.residuals[t].col(c) = dual.residual(model.costs()[t]);
    out.constraints.col(c) = dual.constraints();
    out.gradient(0, c) = dual.cost();
  }
  return out;
}

/// Jacobian as the residual declares it, in the scalar type of solvers.
Eigen::MatrixXd residual_jacobian(const KnotModel& model, const CostTerm& term,
                                  const KnotBatch<Lane>& batch, SystemData<Lane>& data) {
  const Residual& residual = *term.residual;
  AlignedVector<Lane> r(residual.size()), packed(residual.jacobian_size());
  residual.differentiate(model.residual_input(term.parameters, batch.input(), data), r.data(),
                         packed.data());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(residual.size(), model.nz());
  const Lane* entry = packed.data();
  int row = 0;
  for (const RowBlock& block : residual.blocks()) {
    for (const int column : block.columns)
      for (int i = 0; i < block.rows; ++i) jacobian(row + i, column) = (*entry++)[0];
    row += block.rows;
  }
  return jacobian;
}

KnotDerivatives analytic_derivatives(const KnotView& knot, const Trajectory& trajectory, int k,
                                     const KnotLinearization& linearization) {
  const KnotModel& model = *knot.model;
  const System& system = model.system();
  KnotBatch<Lane> batch(model);
  for (int i = 0; i < model.nx(); ++i) batch.x[i] = Lane(trajectory.x(k)[i]);
  for (int i = 0; i < model.nu(); ++i) batch.u[i] = Lane(trajectory.u(k)[i]);
  for (int i = 0; i < model.parameter_count(); ++i) batch.parameters[i] = Lane(knot.parameters[i]);
  const bool terminal = model.integrator() == Integrator::none;
  const auto data = system.create_data(Lane{});
  const KnotInput<Lane> in = batch.input();
  if (model.step().has_control())
    system.differentiate(in.x, model.step().first_control(in.x, in.u), *data);
  else
    system.update_kinematics(in.x, *data);
  KnotDerivatives out;
  out.dynamics = terminal ? Eigen::MatrixXd(0, model.nz()) : linearization.dense_jacobian();
  for (const CostTerm& term : model.costs())
    out.residuals.push_back(residual_jacobian(model, term, batch, *data));
  out.constraints = linearization.C;
  out.gradient = linearization.gradient.transpose();
  return out;
}

/// Largest entry of a finite matrix, otherwise 0.
double largest_finite(const Eigen::MatrixXd& m) {
  return m.size() > 0 && m.allFinite() ? m.cwiseAbs().maxCoeff() : 0;
}

void compare(const Eigen::MatrixXd& analytic, const Eigen::MatrixXd& reference, double unit, int k,
             bool displaced, DerivativeComparison& out) {
  constexpr double kColumnRounding = 1e-3;
  if (out.knots.empty() || out.knots.back() != k) out.knots.push_back(k);
  const double largest = std::max({unit, largest_finite(analytic), largest_finite(reference)});
  for (Eigen::Index c = 0; c < analytic.cols(); ++c)
    for (Eigen::Index r = 0; r < analytic.rows(); ++r, ++out.entries) {
      const double a = analytic(r, c), b = reference(r, c);
      const double scale = std::max({std::abs(a), std::abs(b), kColumnRounding * largest});
      double error = std::abs(a - b) / scale;
      if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
      if (error <= out.error && out.entries > 0) continue;
      out.row = static_cast<int>(r);
      out.column = static_cast<int>(c);
      out.knot = k;
      out.displaced = displaced;
      out.analytic = a;
      out.reference = b;
      out.error = error;
    }
}

/// Size of a knot's cost gradient if its residuals and their derivatives are about 1.
double gradient_unit(const KnotView& knot) {
  double unit = 0;
  for (const CostTerm& term : knot.model->costs())
    unit += knot.cost_scale * knot.parameters[term.weight];
  return unit > 0 ? unit : 1;
}

/// Constraints with the same name, such as those of all contacts, count as one for users.
int first_of_name(const std::vector<ConstraintTerm>& constraints, std::size_t term) {
  const auto same = [&](const ConstraintTerm& c) { return c.name == constraints[term].name; };
  return static_cast<int>(std::find_if(constraints.begin(), constraints.end(), same) -
                          constraints.begin());
}

/// First and last knot of a run of n, and others evenly spaced between them.
std::vector<int> spread(int first, int n, int count) {
  std::vector<int> knots;
  for (int i = 0; i < count; ++i) {
    const int k =
        first + (count > 1 ? static_cast<int>(static_cast<long long>(n - 1) * i / (count - 1)) : 0);
    if (knots.empty() || knots.back() != k) knots.push_back(k);
  }
  return knots;
}

Trajectory displaced_trajectory(const ShootingProblem& problem, const Trajectory& trajectory,
                                const DerivativeCheckOptions& options) {
  std::mt19937_64 engine(options.seed);
  const auto random = [&] {
    return options.displacement * (2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1);
  };
  Trajectory result = trajectory;
  std::vector<double> dx(problem.ndx());
  for (int k = 0; k <= problem.knots(); ++k) {
    for (double& d : dx) d = random();
    problem.manifold().integrate(trajectory.x(k).data(), dx.data(), result.x(k).data());
    if (k == problem.knots()) break;
    for (double& u : result.u(k)) u += random() * std::max(1.0, std::abs(u));
  }
  return result;
}

/// True if a compiled function claims second derivatives; such functions have flat states.
bool claims_hessians(const ShootingProblem& problem) {
  const auto claims = [](const KnotModel& model) {
    const auto own = [](const auto& term) { return term.residual->has_claimed_hessian(); };
    return model.system().has_claimed_hessian() || std::ranges::any_of(model.costs(), own) ||
           std::ranges::any_of(model.constraints(), own);
  };
  return claims(*problem.terminal().model) ||
         std::ranges::any_of(problem.phases(),
                             [&](const Phase& phase) { return claims(*phase.model); });
}

/// True if all values of a knot are finite.
bool is_finite_at(const ShootingProblem& problem, const Evaluation& values, int k) {
  const KnotModel& model = *problem.knot(k).model;
  const auto constraints =
      values.constraint.segment(problem.constraint_offset(k), model.constraint_rows());
  return std::isfinite(values.cost[k]) && constraints.allFinite() &&
         (k == problem.knots() || values.gap.col(k).allFinite());
}

/// Hessians of a Lagrangian with random multipliers at all nodes, as solvers get them and by
/// differences. The state space is flat.
class LagrangianHessians {
 public:
  LagrangianHessians(const ShootingProblem& problem, Evaluator& evaluator, unsigned seed)
      : problem_(problem),
        evaluator_(evaluator),
        model_(problem),
        multipliers_(problem),
        costates_(problem.ndx(), problem.knots() + 1) {
    std::mt19937_64 engine(seed);
    const auto random = [&] { return 2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1; };
    for (double& costate : costates_.reshaped()) costate = random();
    for (double& multiplier : multipliers_.multiplier) multiplier = random();
  }

  std::vector<Eigen::MatrixXd> analytic(const Trajectory& at) {
    gradients(at);
    evaluator_.lagrangian_hessian(at, costates_, model_, &multipliers_);
    std::vector<Eigen::MatrixXd> hessians;
    for (const KnotLinearization& knot : model_.knots) hessians.push_back(knot.hessian());
    return hessians;
  }

  /// Keeps the claimed entries that differences do not contradict.
  std::vector<Eigen::MatrixXd> by_differences(const Trajectory& at,
                                              std::vector<Eigen::MatrixXd> claimed) {
    Eigen::Index columns = 0;
    for (const Eigen::MatrixXd& H : claimed) columns = std::max(columns, H.cols());
    for (Eigen::Index c = 0; c < columns; ++c) {
      const auto longer = column(at, static_cast<int>(c), 1),
                 shorter = column(at, static_cast<int>(c), 1.0 / 32);
      for (std::size_t k = 0; k < claimed.size(); ++k)
        if (c < claimed[k].cols()) confirm(longer[k], shorter[k], claimed[k].col(c));
    }
    return claimed;
  }

 private:
  /// A column of a Hessian by differences, and the size of the gradient divided by the step.
  struct Column {
    Eigen::VectorXd slope, noise;
  };

  std::vector<Eigen::VectorXd> gradients(const Trajectory& at) {
    evaluator_.differentiate(at, model_, &multipliers_);
    std::vector<Eigen::VectorXd> list;
    for (int k = 0; k <= problem_.knots(); ++k) {
      list.push_back(model_.knots[k].gradient);
      if (k < problem_.knots())
        list.back() += model_.knots[k].dense_jacobian().transpose() * costates_.col(k + 1);
    }
    return list;
  }

  /// Coordinate c of z at a node; null if the node has fewer.
  double* coordinate(Trajectory& at, int k, int c) const {
    if (c < problem_.ndx()) return at.x(k).data() + c;
    const int control = c - problem_.ndx();
    return k < problem_.knots() && control < at.nu(k) ? at.u(k).data() + control : nullptr;
  }

  std::vector<Column> column(const Trajectory& at, int c, double share) {
    Trajectory ahead = at, behind = at;
    std::vector<double> steps;
    for (int k = 0; k <= problem_.knots(); ++k) {
      double *a = coordinate(ahead, k, c), *b = coordinate(behind, k, c);
      if (a != nullptr) {
        const double h = share * difference_step(*a);
        *a += h;
        *b -= h;
      }
      steps.push_back(a != nullptr ? *a - *b : 1);  // as rounded
    }
    const auto after = gradients(ahead), before = gradients(behind);
    std::vector<Column> columns;
    for (std::size_t k = 0; k < steps.size(); ++k)
      columns.push_back({(after[k] - before[k]) / steps[k], after[k].cwiseAbs() / steps[k]});
    return columns;
  }

  static void confirm(const Column& longer, const Column& shorter,
                      Eigen::Ref<Eigen::VectorXd> claimed) {
    constexpr double kLoss = 1e-4, kFloor = 1e-3;
    constexpr double kNoise = 32 * std::numeric_limits<double>::epsilon();
    const double largest = std::max(1.0, claimed.allFinite() ? claimed.cwiseAbs().maxCoeff() : 0.0);
    for (Eigen::Index r = 0; r < claimed.size(); ++r) {
      const bool settled = confirms_slope(shorter.slope[r], longer.slope[r], shorter.noise[r]);
      const double slope = settled ? longer.slope[r] : shorter.slope[r];
      const double noise = kNoise * (settled ? longer.noise[r] : shorter.noise[r]);
      const double slack = kLoss * std::max(std::abs(slope), kFloor * largest) + noise;
      if (!(std::abs(claimed[r] - slope) <= slack)) claimed[r] = slope;
    }
  }

  const ShootingProblem& problem_;
  Evaluator& evaluator_;
  Linearization model_;
  Augmentation multipliers_;
  Eigen::MatrixXd costates_;
};

/// The worst entries by phase, kind and term.
class Comparisons {
 public:
  void add_hessian(int phase, int k, const Eigen::MatrixXd& analytic,
                   const Eigen::MatrixXd& reference) {
    compare(analytic, reference, 1, k, true, entry(phase, DerivativeKind::hessian, -1));
  }
  /// Adds the derivatives of one knot. The terminal node has no dynamics.
  void add(const KnotView& knot, int phase, int k, bool displaced, const KnotDerivatives& analytic,
           const KnotDerivatives& reference) {
    if (knot.model->integrator() != Integrator::none)
      compare(analytic.dynamics, reference.dynamics, 1, k, displaced,
              entry(phase, DerivativeKind::dynamics, -1));
    const int costs = static_cast<int>(knot.model->costs().size());
    for (int t = 0; t < costs; ++t)
      compare(analytic.residuals[t], reference.residuals[t], 1, k, displaced,
              entry(phase, DerivativeKind::residual, t));
    const std::vector<ConstraintTerm>& constraints = knot.model->constraints();
    for (std::size_t t = 0; t < constraints.size(); ++t)
      compare(analytic.constraints.middleRows(constraints[t].row, constraints[t].rows),
              reference.constraints.middleRows(constraints[t].row, constraints[t].rows), 1, k,
              displaced, entry(phase, DerivativeKind::constraint, first_of_name(constraints, t)));
    if (costs > 0)
      compare(analytic.gradient, reference.gradient, gradient_unit(knot), k, displaced,
              entry(phase, DerivativeKind::gradient, -1));
  }

  std::vector<DerivativeComparison> take() {
    std::vector<DerivativeComparison> result;
    for (auto& [key, comparison] : worst_) {
      std::vector<int>& knots = comparison.knots;
      std::sort(knots.begin(), knots.end());
      knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
      result.push_back(std::move(comparison));
    }
    return result;
  }

 private:
  DerivativeComparison& entry(int phase, DerivativeKind kind, int term) {
    DerivativeComparison& c = worst_[{phase, kind, term}];
    c.kind = kind;
    c.phase = phase;
    c.term = term;
    return c;
  }

  std::map<std::tuple<int, DerivativeKind, int>, DerivativeComparison> worst_;
};

}  // namespace

std::vector<DerivativeComparison> check_derivatives(const ShootingProblem& problem,
                                                    const Trajectory& trajectory,
                                                    const DerivativeCheckOptions& options) {
  Evaluator evaluator(problem);
  Linearization linearization(problem);
  Evaluation values(problem);
  Comparisons comparisons;
  const bool hessians = claims_hessians(problem);
  for (const bool displaced : {false, true}) {
    if (displaced && options.displacement == 0) break;
    const Trajectory at =
        displaced ? displaced_trajectory(problem, trajectory, options) : trajectory;
    evaluator.evaluate(at, values);
    evaluator.differentiate(at, linearization);
    std::vector<Eigen::MatrixXd> claimed, measured;
    if (displaced && hessians) {
      LagrangianHessians lagrangian(problem, evaluator, options.seed);
      claimed = lagrangian.analytic(at);
      measured = lagrangian.by_differences(at, claimed);
    }
    int first = 0;
    const int phases = static_cast<int>(problem.phases().size());
    for (int p = 0; p <= phases; ++p) {
      const int n = p < phases ? problem.phases()[p].knots() : 1;
      for (const int k : spread(first, n, options.knots_per_phase)) {
        if (displaced && !is_finite_at(problem, values, k)) continue;
        const KnotView& knot = problem.knot(k);
        comparisons.add(knot, p, k, displaced,
                        analytic_derivatives(knot, at, k, linearization.knots[k]),
                        reference_derivatives(knot, at, k));
        if (!claimed.empty()) comparisons.add_hessian(p, k, claimed[k], measured[k]);
      }
      first += n;
    }
  }
  return comparisons.take();
}

}  // namespace conddp
