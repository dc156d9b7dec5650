#include "solvers/globalization/affine_probe.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

/// What the linearisation may be off, as a share of the largest number involved: rounding.
constexpr double kOff = 1e-9;
/// Multiples of the golden section spread evenly: no entry of the move is a multiple of another.
constexpr double kGoldenSection = 0.6180339887498949;

/// The moves of states and controls, −1 to 1, by the place of their entry in the trajectory.
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
  const int N = problem_.knots(), ndx = problem_.ndx();
  moved_ = trajectory;
  const auto fill = [&](int k, auto z) {
    for (int i = 0; i < z.size(); ++i) z[i] = k == 0 && i < ndx ? 0 : move(k * z_.size() + i);
  };
  for (int k = 0; k <= N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    auto z = z_.head(ndx + knot.nu());
    fill(k, z);
    double* x = moved_.x(k).data();
    problem_.manifold().integrate(x, z.data(), x);
    if (k < N) moved_.u(k) += z.tail(knot.nu());
    const int first = problem_.constraint_offset(k), rows = static_cast<int>(knot.C.rows());
    constraint_.segment(first, rows) = linearization.constraint.segment(first, rows);
    constraint_.segment(first, rows).noalias() += knot.C * z;
  }
  evaluator.evaluate(moved_, evaluation_);
  double off = 0, largest = 1;
  const auto compare = [&](double foretold, double found) {
    const double here = std::abs(foretold - found);
    if (!(here <= off)) off = here;  // NaN stays
    largest = std::max({largest, std::abs(foretold), std::abs(found)});
  };
  for (int i = 0; i < constraint_.size(); ++i) compare(constraint_[i], evaluation_.constraint[i]);
  if (!(off <= kOff * largest)) return false;
  for (int k = 0; k < N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    auto z = z_.head(ndx + knot.nu());
    fill(k, z);
    knot.apply(z, next_);
    largest = std::max(largest, trajectory.x(k + 1).template lpNorm<Eigen::Infinity>());
    for (int i = 0; i < ndx; ++i)
      compare(linearization.gap(i, k) + next_[i] - move((k + 1) * z_.size() + i),
              evaluation_.gap(i, k));
  }
  return off <= kOff * largest;
}

}  // namespace conddp
