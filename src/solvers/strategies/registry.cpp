#include "solvers/strategies/registry.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/ipopt/ipopt_solver.hpp"

namespace conddp {
namespace {

/// What a member of the family supports follows from its recipe.
SolverInfo info_of(const DdpMember& member) {
  const DdpRecipe& recipe = member.recipe;
  SolverInfo info{.name = member.name, .description = member.description};
  if (recipe.clamp_controls)
    info.control_bounds = recipe.box_stage ? BoundSupport::exact : BoundSupport::clipped;
  if (recipe.constraints)
    info.constraints = recipe.multipliers == MultiplierSchedule::by_the_sweep
                           ? ConstraintSupport::equalities
                           : ConstraintSupport::all;
  info.open_gaps = recipe.open_gaps;
  info.gauss_newton_hessian = recipe.hessian != HessianUse::exact;
  info.exact_hessian = recipe.hessian != HessianUse::gauss_newton;
  info.segments = recipe.segments;
  info.run = [&recipe](const ShootingProblem& problem, const SolverOptions& options,
                       const Trajectory& guess) {
    DdpSolver solver(problem, recipe, options);
    solver.solve(guess);
    return solver.take();
  };
  return info;
}

/// Direct transcription by multiple shooting for the interior-point method Ipopt (Wächter, Biegler
/// 2006). MUMPS, which factors its matrices, must not run twice in one process.
SolverInfo ipopt_info() {
  return {
      .name = "ipopt",
      .description = "direct transcription to a sparse nonlinear program; all constraints",
      .control_bounds = BoundSupport::exact,
      .constraints = ConstraintSupport::all,
      .complementarity = true,
      .open_gaps = true,
      .exact_hessian = true,
      .concurrent = false,
      .run = [](const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) { return IpoptSolver(problem, options).solve(guess); }};
}

/// The first bound of a problem in words: "-3 <= u (phase 'swing')".
std::string describe_bound(const ShootingProblem& problem) {
  for (const Phase& phase : problem.phases()) {
    const KnotModel& model = *phase.model;
    for (int i = 0; i < model.nu(); ++i) {
      const double lower = model.control_lower()[i], upper = model.control_upper()[i];
      if (!std::isfinite(lower) && !std::isfinite(upper)) continue;
      const auto& columns = model.system().control_columns();
      const std::string name =
          i < static_cast<int>(columns.size()) ? columns[i].name : fmt::format("control {}", i);
      std::string text = name;
      if (std::isfinite(lower)) text = fmt::format("{} <= {}", lower, text);
      if (std::isfinite(upper)) text += fmt::format(" <= {}", upper);
      return fmt::format("{} in phase '{}'", text, phase.name);
    }
  }
  return "none";
}

template <class Predicate>
std::string list_solvers(Predicate can) {
  std::string list;
  for (const SolverInfo& info : solvers()) {
    if (!can(info)) continue;
    if (!list.empty()) list += ", ";
    list += info.name;
  }
  return list;
}

std::string list_solvers(BoundSupport support) {
  return list_solvers([support](const SolverInfo& info) { return info.control_bounds == support; });
}

/// Rows may be free, too: those that `equals` does not name.
bool is_equality(const NodeConstraint& c) {
  if (!c.term->has_bounds() || c.is_soft()) return false;
  for (int i = 0; i < c.term->rows; ++i)
    if (c.lower[i] != c.upper[i] && (std::isfinite(c.lower[i]) || std::isfinite(c.upper[i])))
      return false;
  return true;
}

bool supports(const SolverInfo& solver, const NodeConstraint& constraint) {
  if (constraint.term->has_pairs()) return solver.complementarity;
  return solver.constraints == ConstraintSupport::all ||
         (solver.constraints == ConstraintSupport::equalities && is_equality(constraint));
}

bool supports_all(const SolverInfo& solver, const ShootingProblem& problem) {
  if (problem.has_control_bounds() && solver.control_bounds != BoundSupport::exact) return false;
  return std::all_of(problem.constraints().begin(), problem.constraints().end(),
                     [&](const NodeConstraint& c) { return supports(solver, c); });
}

/// Why the solver cannot take the problem because of its constraints, if so. What is advised are
/// the solvers that keep all of them.
std::optional<std::string> unsupported_constraint(const SolverInfo& solver,
                                                  const ShootingProblem& problem) {
  for (const NodeConstraint& c : problem.constraints()) {
    if (supports(solver, c)) continue;
    const int phase = problem.knot(c.node).phase;
    const std::string can =
        list_solvers([&](const SolverInfo& info) { return supports_all(info, problem); });
    return fmt::format("{} does not support the {} '{}' ({}); {}", solver.name,
                       c.is_soft()                                           ? "soft constraint"
                       : solver.constraints == ConstraintSupport::equalities ? "inequality"
                                                                             : "constraint",
                       c.term->name,
                       c.node == problem.knots()
                           ? "terminal node"
                           : fmt::format("phase '{}'", problem.phases()[phase].name),
                       can.empty() ? "no solver supports all of them" : "supported by " + can);
  }
  return std::nullopt;
}

}  // namespace

std::span<const SolverInfo> solvers() {
  static const std::vector<SolverInfo> all = [] {
    std::vector<SolverInfo> list;
    for (const DdpMember& member : ddp_family()) list.push_back(info_of(member));
    list.push_back(ipopt_info());
    return list;
  }();
  return all;
}

const SolverInfo* find_solver(std::string_view name) {
  for (const SolverInfo& info : solvers()) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

bool supports_constraints(const SolverInfo& solver, const ShootingProblem& problem) {
  return !unsupported_constraint(solver, problem);
}

std::optional<std::string> unsupported(const SolverInfo& solver, const ShootingProblem& problem) {
  if (auto reason = unsupported_constraint(solver, problem)) return reason;
  if (solver.control_bounds != BoundSupport::none || !problem.has_control_bounds()) {
    return std::nullopt;
  }
  return fmt::format("{} does not support the control bounds ({}); supported by {}, clipped by {}",
                     solver.name, describe_bound(problem), list_solvers(BoundSupport::exact),
                     list_solvers(BoundSupport::clipped));
}

std::optional<std::string> unsupported_segments(const SolverInfo& solver,
                                                const ShootingProblem& problem, int segments) {
  if (segments > 1 && !solver.segments)
    return fmt::format("segments: {} does not support several; supported by {}", solver.name,
                       list_solvers([](const SolverInfo& info) { return info.segments; }));
  if (segments > problem.knots())
    return fmt::format("segments: {} of them need as many knots, and the horizon has {}", segments,
                       problem.knots());
  return std::nullopt;
}

std::vector<const SolverInfo*> auto_solvers(const ShootingProblem& problem,
                                            const SolverOptions& options) {
  std::vector<std::string_view> names = {"box_fddp", "ipopt"};
  if (!problem.constraints().empty()) names = {"altro", "proxddp", "ipopt"};
  std::vector<const SolverInfo*> list;
  for (const std::string_view name : names) {
    const SolverInfo* info = find_solver(name);
    const bool takes_hessian =
        options.hessian == HessianChoice::automatic ||
        (options.hessian == HessianChoice::exact ? info->exact_hessian
                                                 : info->gauss_newton_hessian);
    if (takes_hessian && !unsupported(*info, problem) &&
        !unsupported_segments(*info, problem, options.segments))
      list.push_back(info);
  }
  return list;
}

}  // namespace conddp
