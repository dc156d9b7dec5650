#include "solvers/globalization/affine_probe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Multiples of the golden section spread evenly, so that no entry of the move is a multiple of
/// another.
constexpr double kGoldenSection = std::numbers::phi;

/// Moves of states and controls, −1 to 1, by the index of their entry in the trajectory.
double move(int i) {
  const double turns = kGoldenSection * (i + 1);
  return 2 * (turns - std::floor(turns)) - 1;
}

}  // namespace

AffineProbe::AffineProbe(const ShootingProblem& problem)
    : problem_(problem),
      moved_(problem.create_trajectory()),
      evaluation_(problem),
      next_(problem.ndx()),
      constraint_(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  int largest = 0;
  for (int k = 0; k <= problem.knots(); ++k)
    largest = std::max(largest, problem.knot(k).model->nz());
  z_.resize(largest);
}

bool AffineProbe::holds(Evaluator& evaluator, const Trajectory& trajectory,
                        const Linearization& linearization) {
  move_all(trajectory, linearization);
  evaluator.evaluate(moved_, evaluation_);
  Comparison comparison;
  for (int i = 0; i < constraint_.size(); ++i)
    comparison.add(constraint_[i], evaluation_.constraint[i]);
  if (!comparison.agrees()) return false;
  for (int k = 0; k < problem_.knots(); ++k) compare_gap(k, trajectory, linearization, comparison);
  return comparison.agrees();
}

/// The move of a knot's state and control. The given initial state does not move.
Eigen::VectorBlock<Eigen::VectorXd> AffineProbe::move_of(int knot, int nu) {
  const int ndx = problem_.ndx();
  auto z = z_.head(ndx + nu);
  for (int i = 0; i < z.size(); ++i)
    z[i] = knot == 0 && i < ndx ? 0 : move(static_cast<int>(knot * z_.size() + i));
  return z;
}

/// moved_ ← the trajectory with all of its moves, constraint_ ← the values predicted there.
void AffineProbe::move_all(const Trajectory& trajectory, const Linearization& linearization) {
  moved_ = trajectory;
  for (int k = 0; k <= problem_.knots(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    const auto z = move_of(k, knot.nu());
    double* x = moved_.x(k).data();
    problem_.manifold().integrate(x, z.data(), x);
    if (k < problem_.knots()) moved_.u(k) += z.tail(knot.nu());
    const int first = problem_.constraint_offset(k), rows = static_cast<int>(knot.C.rows());
    constraint_.segment(first, rows) = linearization.constraint.segment(first, rows);
    constraint_.segment(first, rows).noalias() += knot.C * z;
  }
}

void AffineProbe::compare_gap(int knot, const Trajectory& trajectory,
                              const Linearization& linearization, Comparison& comparison) {
  const KnotLinearization& here = linearization.knots[knot];
  here.apply(move_of(knot, here.nu()), next_);
  comparison.largest =
      std::max(comparison.largest, trajectory.x(knot + 1).lpNorm<Eigen::Infinity>());
  for (int i = 0; i < problem_.ndx(); ++i) {
    const double moved = move(static_cast<int>((knot + 1) * z_.size() + i));
    comparison.add(linearization.gap(i, knot) + next_[i] - moved, evaluation_.gap(i, knot));
  }
}

void AffineProbe::Comparison::add(double foretold, double found) {
  const double here = std::abs(foretold - found);
  if (!std::isnan(off) && !(here <= off)) off = here;  // keeps NaN
  largest = std::max({largest, std::abs(foretold), std::abs(found)});
}

bool AffineProbe::Comparison::agrees() const { return off <= tuning::kExact * largest; }

}  // namespace conddp
