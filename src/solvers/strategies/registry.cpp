#include "solvers/strategies/registry.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/interior/interior_solver.hpp"
#include "solvers/ipopt/ipopt_solver.hpp"

namespace conddp {
namespace {

bool costates_fit(const ShootingProblem& problem, const Eigen::MatrixXd& costates) {
  return costates.size() == 0 ||
         (costates.rows() == problem.ndx() && costates.cols() == problem.knots() + 1);
}

bool control_gradient_fits(const ShootingProblem& problem,
                           const std::vector<Eigen::VectorXd>& gradient) {
  if (gradient.empty()) return true;
  if (static_cast<int>(gradient.size()) != problem.knots()) return false;
  for (int k = 0; k < problem.knots(); ++k)
    if (gradient[k].size() != problem.nu(k)) return false;
  return true;
}

/// Reason why multipliers do not have the shape of the problem, if any.
std::optional<std::string> misfit(const ShootingProblem& problem, const DualGuess& guess) {
  if (guess.constraints.size() == problem.constraint_rows() &&
      costates_fit(problem, guess.costates) &&
      control_gradient_fits(problem, guess.control_gradient))
    return std::nullopt;
  return "the multipliers to start from do not have the shape of the problem";
}

/// Reason why the solver does not support the problem with these options, if any.
std::optional<std::string> unsupported_options(const SolverInfo& solver,
                                               const ShootingProblem& problem,
                                               const SolverOptions& options) {
  if (const std::vector<std::string> wrong = options.validate(); !wrong.empty())
    return fmt::format("{}", fmt::join(wrong, "; "));
  if (auto reason = unsupported(solver, problem)) return reason;
  if (auto reason = unsupported_hessian(solver, options.hessian)) return reason;
  if (options.multipliers) return misfit(problem, *options.multipliers);
  return std::nullopt;
}

/// Derives the capabilities of a member from its recipe.
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
  info.run = [&recipe](const ShootingProblem& problem, const SolverOptions& options,
                       const Trajectory& guess) {
    DdpSolver solver(problem, recipe, options);
    solver.solve(guess);
    return solver.take();
  };
  return info;
}

/// Direct transcription by multiple shooting for the interior-point method Ipopt (Wächter, Biegler
/// 2006). MUMPS, which factorizes its matrices, must not run twice in one process.
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
      .real_time = false,
      .run = [](const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) { return IpoptSolver(problem, options).solve(guess); }};
}

/// Interior points whose linear algebra is a Riccati sweep (Wächter, Biegler 2006; Pavlov,
/// Shames, Manzie 2021).
SolverInfo ipddp_info() {
  return {
      .name = "ipddp",
      .description = "primal-dual interior points in the sweep; all constraints",
      .control_bounds = BoundSupport::exact,
      .constraints = ConstraintSupport::all,
      .complementarity = true,
      .open_gaps = true,
      .gauss_newton_hessian = true,
      .exact_hessian = true,
      .run = [](const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) { return InteriorSolver(problem, options).solve(guess); }};
}

/// Bounds of a control in words: "-3 <= u"; empty if there are no bounds.
std::string describe_bounds(const KnotModel& model, int control) {
  const double lower = model.control_lower()[control], upper = model.control_upper()[control];
  if (!std::isfinite(lower) && !std::isfinite(upper)) return "";
  const auto& columns = model.system().control_columns();
  std::string text = control < static_cast<int>(columns.size())
                         ? columns[control].name
                         : fmt::format("control {}", control);
  if (std::isfinite(lower)) text = fmt::format("{} <= {}", lower, text);
  if (std::isfinite(upper)) text += fmt::format(" <= {}", upper);
  return text;
}

/// First bound of a problem in words: "-3 <= u in phase 'swing'".
std::string describe_first_bound(const ShootingProblem& problem) {
  for (const Phase& phase : problem.phases()) {
    for (int i = 0; i < phase.model->nu(); ++i) {
      const std::string text = describe_bounds(*phase.model, i);
      if (!text.empty()) return fmt::format("{} in phase '{}'", text, phase.name);
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

bool has_pairs(const ShootingProblem& problem) {
  return std::ranges::any_of(problem.constraints(),
                             [](const NodeConstraint& c) { return c.term->has_pairs(); });
}

/// Bounded but not fixed.
bool is_interval(double lower, double upper) {
  return lower != upper && (std::isfinite(lower) || std::isfinite(upper));
}

/// Rows without bounds are allowed, too: those that `equals` does not name.
bool is_equality(const NodeConstraint& c) {
  if (!c.term->has_bounds() || c.is_soft()) return false;
  for (int i = 0; i < c.term->rows; ++i)
    if (is_interval(c.lower[i], c.upper[i])) return false;
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

/// Kind of a constraint that the solver does not support.
std::string_view kind_of(const NodeConstraint& c, const SolverInfo& solver) {
  if (c.is_soft()) return "soft constraint";
  return solver.constraints == ConstraintSupport::equalities ? "inequality" : "constraint";
}

std::string place_of(const NodeConstraint& c, const ShootingProblem& problem) {
  if (c.node == problem.knots()) return "terminal node";
  return fmt::format("phase '{}'", problem.phases()[problem.knot(c.node).phase].name);
}

/// Reason why the solver does not support the problem's constraints, if any. It recommends solvers
/// that support all of them.
std::optional<std::string> unsupported_constraint(const SolverInfo& solver,
                                                  const ShootingProblem& problem) {
  const auto& all = problem.constraints();
  const auto c = std::find_if_not(all.begin(), all.end(), [&](const NodeConstraint& constraint) {
    return supports(solver, constraint);
  });
  if (c == all.end()) return std::nullopt;
  const std::string can =
      list_solvers([&](const SolverInfo& info) { return supports_all(info, problem); });
  return fmt::format("{} does not support the {} '{}' ({}); {}", solver.name, kind_of(*c, solver),
                     c->term->name, place_of(*c, problem),
                     can.empty() ? "no solver supports all of them" : "supported by " + can);
}

}  // namespace

std::span<const SolverInfo> solvers() {
  static const std::vector<SolverInfo> all = [] {
    std::vector<SolverInfo> list;
    for (const DdpMember& member : ddp_family()) list.push_back(info_of(member));
    list.push_back(ipddp_info());
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

std::vector<std::string> unsupported_constraints(const SolverInfo& solver,
                                                 const ShootingProblem& problem) {
  std::vector<std::string> names;
  for (const NodeConstraint& c : problem.constraints())
    if (!supports(solver, c) && std::ranges::find(names, c.term->name) == names.end())
      names.push_back(c.term->name);
  return names;
}

std::optional<std::string> unsupported(const SolverInfo& solver, const ShootingProblem& problem) {
  if (auto reason = unsupported_constraint(solver, problem)) return reason;
  if (solver.control_bounds != BoundSupport::none || !problem.has_control_bounds()) {
    return std::nullopt;
  }
  return fmt::format("{} does not support the control bounds ({}); supported by {}, clipped by {}",
                     solver.name, describe_first_bound(problem), list_solvers(BoundSupport::exact),
                     list_solvers(BoundSupport::clipped));
}

std::optional<std::string> unsupported_hessian(const SolverInfo& solver, HessianChoice choice) {
  if (choice == HessianChoice::exact && !solver.exact_hessian)
    return fmt::format("hessian: {} has no exact Hessian", solver.name);
  if (choice == HessianChoice::gauss_newton && !solver.gauss_newton_hessian)
    return fmt::format("hessian: {} always uses the exact one", solver.name);
  return std::nullopt;
}

std::vector<const SolverInfo*> auto_solvers(const ShootingProblem& problem,
                                            const SolverOptions& options) {
  std::vector<std::string_view> names = {"box_fddp", "ipopt"};
  if (!problem.constraints().empty()) names = {"altro", "proxddp", "ipopt"};
  if (has_pairs(problem)) names = {"ipddp", "ipopt"};
  std::vector<const SolverInfo*> list;
  for (const std::string_view name : names) {
    const SolverInfo* info = find_solver(name);
    if (!unsupported_hessian(*info, options.hessian) && !unsupported(*info, problem))
      list.push_back(info);
  }
  return list;
}

std::string describe_auto(const ShootingProblem& problem, SolverList list) {
  const auto& constraints = problem.constraints();
  std::string text =
      fmt::format("{}, since there are {}", list.front()->name,
                  has_pairs(problem)    ? "complementary pairs"
                  : constraints.empty() ? "no constraints besides bounds on the control"
                                        : "constraints besides bounds on the control");
  for (std::size_t i = 1; i < list.size(); ++i)
    text += fmt::format("{}{}", i == 1 ? "; then " : ", ", list[i]->name);
  return text;
}

void check_options(const SolverInfo& solver, const ShootingProblem& problem,
                   const SolverOptions& options) {
  if (const auto reason = unsupported_options(solver, problem, options))
    throw std::invalid_argument(*reason);
}

}  // namespace conddp
