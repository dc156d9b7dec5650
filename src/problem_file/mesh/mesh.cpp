#include "problem_file/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/certificate/replay.hpp"
#include "problem_file/lower/grid.hpp"

namespace conddp {
namespace {

/// Bounds on the growth of a grid. Error orders are known only for the finer grids.
constexpr double kLeastGrowth = 1.25, kMostGrowth = 4;
/// Growth after the first grid, before an order can be estimated.
constexpr double kFirstGrowth = 2;
constexpr int kMostKnots = 10'000;
/// Aims below the tolerance rather than at it.
constexpr double kMargin = 1.5;

/// Reports costs at single knots: they are multiplied by the time steps of these.
void check_cost(const CostSpec& cost, Diagnostics& out) {
  if (cost.knots)
    out.error(cost.name.place,
              "a cost at single knots is multiplied by their time steps, which 'mesh' changes",
              "let it hold in a phase, or make it a hard constraint");
}

/// The state at the fraction s of the path from one state to another.
void between(const StateManifold& manifold, const double* a, const double* b, double s,
             double* out) {
  std::vector<double> step(manifold.ndx());
  manifold.difference(a, b, step.data());
  for (double& d : step) d *= s;
  manifold.integrate(a, step.data(), out);
}

}  // namespace

bool MeshRefinement::reached() const {
  return !rounds_.empty() && is_success(rounds_.back().status) &&
         rounds_.back().error <= mesh_.error;
}

bool MeshRefinement::grew(std::size_t round) const {
  return round > 0 && round < rounds_.size() && rounds_[round].error >= rounds_[round - 1].error;
}

bool MeshRefinement::keeps_growing() const {
  const std::size_t last = rounds_.size() - 1;
  return !rounds_.empty() && grew(last) && grew(last - 1);
}

/// Growth from the error order of the last two grids. A coarse grid can have a smaller error than
/// the next one by chance.
double MeshRefinement::growth() const {
  const MeshRound& last = rounds_.back();
  if (rounds_.size() < 2 || !std::isfinite(last.error)) return kFirstGrowth;
  const MeshRound& before = rounds_[rounds_.size() - 2];
  if (!(last.error < before.error) || !std::isfinite(before.error)) return kFirstGrowth;
  const double order = std::log(before.error / last.error) /
                       std::log(static_cast<double>(last.factor) / before.factor);
  const double wanted = std::pow(kMargin * last.error / mesh_.error, 1 / order);
  return std::clamp(wanted, kLeastGrowth, kMostGrowth);
}

std::optional<int> MeshRefinement::next(const ShootingProblem& problem, const SolveResult& result) {
  rounds_.push_back({.factor = factor_,
                     .knots = problem.knots(),
                     .error = replay_error(problem, result.trajectory),
                     .status = result.status,
                     .iterations = result.iterations,
                     .cost = result.cost});
  if (!is_success(result.status) || reached() || keeps_growing()) return std::nullopt;
  int instants = 0;
  for (const Phase& phase : problem.phases())
    if (phase.instant || phase.dt.front() == 0) instants += phase.knots();
  const int of_one = (problem.knots() - instants) / factor_;
  if (of_one == 0) return std::nullopt;  // without time the grid cannot be refined
  const int most = (kMostKnots - instants) / of_one;
  const int finer = std::min(most, static_cast<int>(std::ceil(factor_ * growth())));
  if (finer <= factor_) return std::nullopt;
  factor_ = finer;
  return factor_;
}

bool coarsen(ProblemSpec& spec, int least) {
  for (const PhaseSpec& phase : spec.phases)
    if (!phase.takes_no_time() && phase.knots.value / 2 < least) return false;
  set_knots(spec, [](int knots) { return knots / 2; });
  return true;
}

namespace {

/// Sets the end of linear controls to their value at the beginning of the next node.
void join_controls(const ShootingProblem& problem, Trajectory& trajectory) {
  for (int k = 0; k < problem.knots(); ++k) {
    const Step& step = problem.knot(k).model->step();
    if (!step.has_linear_controls()) continue;
    const Eigen::VectorXd next = trajectory.x(k + 1);
    const auto begin = step.first_control(next, trajectory.u(k));
    trajectory.u(k).head(begin.size()) = begin;
  }
}

}  // namespace

Trajectory on_grid(const ShootingProblem& from, const Trajectory& trajectory,
                   const ShootingProblem& to) {
  Trajectory result = to.create_trajectory();
  int first_from = 0, first_to = 0;
  for (std::size_t p = 0; p < to.phases().size(); ++p) {
    const int coarse = from.phases()[p].knots(), fine = to.phases()[p].knots();
    for (int j = 0; j < fine; ++j) {
      const double at = static_cast<double>(j) * coarse / fine;
      const int k = std::min(static_cast<int>(at), coarse - 1);
      between(from.manifold(), trajectory.x(first_from + k).data(),
              trajectory.x(first_from + k + 1).data(), at - k, result.x(first_to + j).data());
      result.u(first_to + j) = trajectory.u(first_from + k);
    }
    first_from += coarse;
    first_to += fine;
  }
  result.x(to.knots()) = trajectory.x(from.knots());
  join_controls(to, result);
  return result;
}

void check_mesh(const ProblemSpec& spec, const System& system, Diagnostics& out) {
  if (!spec.mesh) return;
  const Place& place = spec.mesh->place;
  if (spec.stepping)
    out.error(place, "the grid of a contact-implicit problem cannot be refined by its error",
              "choose 'knots' yourself");
  else if (system.kind() == SystemKind::discrete)
    out.error(place, "a system that gives the next state itself has no finer grid");
  if (!spec.costs_are_rates())
    out.error(place, "costs that are added up as they are change with the grid",
              "write 'running_costs: rate'");
  if (const CostSpec* rate = spec.first_use(&ResidualNeeds::previous_control))
    out.error(rate->name.place,
              "the change of a control from knot to knot depends on the grid, which 'mesh' refines",
              "make the control a state, and its rate the control");
  for (const CostSpec* cost : spec.all_costs()) check_cost(*cost, out);
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (constraint->softness != Softness::hard) check_cost(constraint->function, out);
  for (const PhaseSpec& phase : spec.phases)
    if (phase.refine)
      out.error(phase.name.place, "'refine' and 'mesh' exclude each other",
                "write the grid with 'refine', or leave it to 'mesh'");
}

}  // namespace conddp
