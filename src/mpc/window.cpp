#include "mpc/window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/linalg/exchange.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// Numbers of a knot of the time line, or of the part of it in a window.
KnotNumbers numbers_of(const WindowContext& context, const TimedKnot& part) {
  KnotNumbers numbers = context.line.numbers(part.knot);
  numbers.cost_scale *= context.cost_scale;
  const double length = part.end - part.begin;
  if (context.line.problem().takes_no_time(part.knot) || std::abs(length - numbers.dt) < kSameTime)
    return numbers;
  return {length, numbers.cost_scale * (length / numbers.dt), numbers.parameters};
}

/// True if a constraint is active at node `node` of a window, with the time line's numbers.
bool is_active(const ConstraintTerm& term, int node, int ndx, const double* parameters) {
  return parameters[term.active()] != 0 && (node > 0 || term.depends_on_control(ndx));
}

/// True if a node has no costs and no constraints.
bool is_free(const Phase& node) {
  return node.model->costs().empty() && node.model->constraints().empty();
}

const Phase& end_of(const WindowContext& context, bool has_terminal) {
  const bool own = has_terminal || context.open_end == nullptr;
  return own ? context.line.problem().terminal() : *context.open_end;
}

KnotNumbers end_numbers(const WindowContext& context, bool has_terminal) {
  const Phase* end = has_terminal ? nullptr : context.open_end;
  KnotNumbers numbers = end == nullptr
                            ? context.line.numbers(context.line.problem().knots())
                            : KnotNumbers{end->dt[0], end->cost_scale[0], end->parameters.data()};
  numbers.cost_scale *= context.cost_scale;
  return numbers;
}

/// Writes the parameters of a node of a window.
void write_parameters(const KnotModel& model, int node, const double* given,
                      std::vector<double>& parameters) {
  parameters.assign(given, given + model.parameter_count());
  for (const ConstraintTerm& term : model.constraints())
    parameters[term.active()] = is_active(term, node, model.ndx(), given) ? 1 : 0;
}

/// True if both places agree on the finite bounds of the rows and on the rows that are equalities.
bool same_rows(const ConstraintTerm& term, const double* own, const double* other) {
  if (!term.has_bounds()) return true;
  for (int i = 0; i < term.rows; ++i) {
    const int lower = term.lower() + i, upper = term.upper() + i;
    if (std::isfinite(own[lower]) != std::isfinite(other[lower]) ||
        std::isfinite(own[upper]) != std::isfinite(other[upper]) ||
        (own[lower] == own[upper]) != (other[lower] == other[upper]))
      return false;
  }
  return true;
}

/// True if a weight is zero in both places or in neither.
bool same_zero(const KnotView& own, const KnotNumbers& other, int weight) {
  return (own.cost_scale * own.parameters[weight] == 0) ==
         (other.cost_scale * other.parameters[weight] == 0);
}

/// True if two nodes have the same constraints and costs, as far as solvers depend on them.
bool same_terms(const KnotModel& model, const KnotView& own, int node, const KnotNumbers& other) {
  for (const ConstraintTerm& term : model.constraints()) {
    const bool active = own.parameters[term.active()] != 0;
    if (active != is_active(term, node, model.ndx(), other.parameters)) return false;
    if (active && !same_rows(term, own.parameters, other.parameters)) return false;
    if (active && term.softness != Softness::hard && !same_zero(own, other, term.weight()))
      return false;
  }
  return std::ranges::all_of(
      model.costs(), [&](const CostTerm& cost) { return same_zero(own, other, cost.weight); });
}

ShootingProblem problem_of(const WindowContext& context, const WindowCut& cut) {
  const ShootingProblem& whole = context.line.problem();
  std::vector<Phase> phases;
  std::vector<double> parameters;
  for (int i = 0; i < static_cast<int>(cut.knots.size()); ++i) {
    const TimedKnot& part = cut.knots[i];
    const Phase& phase = whole.phases()[whole.knot(part.knot).phase];
    if (phases.empty() || phases.back().name != phase.name || phases.back().model != phase.model ||
        phases.back().instant != phase.instant)
      phases.push_back({.name = phase.name, .model = phase.model, .instant = phase.instant});
    const KnotNumbers numbers = numbers_of(context, part);
    write_parameters(*phase.model, i, numbers.parameters, parameters);
    Phase& to = phases.back();
    to.dt.push_back(numbers.dt);
    to.cost_scale.push_back(numbers.cost_scale);
    to.parameters.insert(to.parameters.end(), parameters.begin(), parameters.end());
  }
  return ShootingProblem(whole.initial_state(), std::move(phases),
                         end_of(context, cut.has_terminal));
}

SolverOptions with_multipliers(SolverOptions options,
                               std::shared_ptr<const DualGuess> multipliers) {
  options.multipliers = std::move(multipliers);
  return options;
}

std::shared_ptr<DualGuess> no_multipliers(const ShootingProblem& problem) {
  auto guess = std::make_shared<DualGuess>();
  guess->constraints = Eigen::VectorXd::Zero(problem.constraint_rows());
  return guess;
}

/// Node of a plan whose constraint multipliers a node of this model takes at a time; −1 if none
/// exists.
int node_at(const Plan& plan, double time, const KnotModel* model) {
  const auto found = std::upper_bound(plan.times.begin(), plan.times.end(), time + kSameTime);
  for (int k = static_cast<int>(found - plan.times.begin()) - 1; k >= 0; --k) {
    if (plan.problem->knot(k).model == model) return k;
    if (is_before(plan.times[k], time)) return -1;
  }
  return -1;
}

constexpr int kPlans = 2;  ///< the plan in force, and the next one

}  // namespace

void cut_window(const WindowContext& context, double begin, WindowCut& cut) {
  const TimeLine& line = context.line;
  cut.begin = begin;
  cut.end = begin + context.horizon;
  const bool beyond = !is_before(cut.end, line.end());
  if (beyond && !line.is_held()) cut.end = line.end();
  cut.has_terminal = beyond && !(line.is_held() && is_free(line.problem().terminal()));
  line.cut(cut.begin, cut.end, cut.knots);
}

Window::Window(const WindowContext& context, const WindowCut& cut)
    : problem_(problem_of(context, cut)),
      times_(problem_.knots() + 1),
      numbers_(problem_.knots() + 1),
      parameters_(problem_.knots() + 1),
      multipliers_(no_multipliers(problem_)),
      solver_(problem_, context.solver, with_multipliers(context.options, multipliers_),
              context.memory),
      guess_(problem_.create_trajectory()),
      plans_(kPlans, Plan(problem_)) {
  load(context, cut);
}

bool Window::fits(const WindowContext& context, const WindowCut& cut) const {
  const ShootingProblem& whole = context.line.problem();
  const int N = problem_.knots();
  const Phase& end = end_of(context, cut.has_terminal);
  if (static_cast<int>(cut.knots.size()) != N || problem_.terminal().model != end.model ||
      !same_terms(*end.model, problem_.knot(N), N, end_numbers(context, cut.has_terminal)))
    return false;
  for (int i = 0; i < N; ++i) {
    const KnotView& own = problem_.knot(i);
    const TimedKnot& part = cut.knots[i];
    if (own.model != whole.knot(part.knot).model ||
        problem_.takes_no_time(i) != whole.takes_no_time(part.knot) ||
        !same_terms(*own.model, own, i, numbers_of(context, part)))
      return false;
  }
  return true;
}

void Window::load(const WindowContext& context, const WindowCut& cut) {
  const int N = problem_.knots();
  for (int i = 0; i < N; ++i) {
    times_[i] = cut.knots[i].begin;
    numbers_[i] = numbers_of(context, cut.knots[i]);
    write_parameters(*problem_.knot(i).model, i, numbers_[i].parameters, parameters_[i]);
    if (context.swings != nullptr)
      context.swings->displace(cut.knots[i].knot, parameters_[i].data());
    numbers_[i].parameters = parameters_[i].data();
  }
  times_[N] = cut.end;
  numbers_[N] = end_numbers(context, cut.has_terminal);
  problem_.set_numbers(numbers_);
}

void Window::guess_from(const Plan& plan, PolicyScratch& scratch) {
  for (int i = 0; i <= problem_.knots(); ++i) {
    guess_node(i, plan, scratch);
    guess_multipliers(i, plan);
  }
  guess_.x(0) = Eigen::Map<const Eigen::VectorXd>(problem_.initial_state().data(), problem_.nx());
}

void Window::guess_node(int node, const Plan& plan, PolicyScratch& scratch) {
  const bool running = node < problem_.knots();
  plan.state_at(times_[node], running && problem_.takes_no_time(node), scratch.tangent.data(),
                scratch.x.data());
  std::copy(scratch.x.begin(), scratch.x.end(), guess_.x(node).data());
  if (!running) return;
  const int k = plan.knot_at(times_[node]);
  if (plan.trajectory.nu(k) == problem_.nu(node))
    guess_.u(node) = plan.trajectory.u(k);
  else
    guess_.u(node).setZero();
}

void Window::guess_multipliers(int node, const Plan& plan) {
  const KnotModel* model = problem_.knot(node).model;
  const int rows = model->constraint_rows(), from = node_at(plan, times_[node], model);
  auto own = multipliers_->constraints.segment(problem_.constraint_offset(node), rows);
  if (from < 0)
    own.setZero();
  else
    own = plan.multipliers.segment(plan.problem->constraint_offset(from), rows);
}

const SolveResult& Window::solve() { return solver_.solve(guess_); }

const SolveResult& Window::solve(std::string_view solver, const SolverOptions& options) {
  other_ = conddp::solve(problem_, *find_solver(solver), with_multipliers(options, multipliers_),
                         guess_);
  return *other_;
}

bool Window::is_improved_by(const SolveResult& answer, const Plan& plan, double tolerance) {
  Trajectory former = guess_;
  std::vector<double> tangent(problem_.ndx());
  plan.state_at(times_[0], false, tangent.data(), former.x(0).data());
  const Feedback gains = gains_of(plan);
  if (!trial_) trial_ = std::make_unique<PlanTrial>(problem_);
  return is_better(trial_->follow(answer.trajectory, answer.feedback),
                   trial_->follow(former, gains), tolerance);
}

/// Gains of a plan at the knots of the window; zero where their controls differ.
Feedback Window::gains_of(const Plan& plan) const {
  Feedback gains(problem_);
  for (int k = 0; k < problem_.knots(); ++k)
    if (const int from = plan.knot_at(times_[k]); plan.trajectory.nu(from) == problem_.nu(k))
      gains.K[k] = plan.feedback.K[from];
  return gains;
}

Plan& Window::keep(const SolveResult& answer, const Plan* used, Plan* spare) {
  Plan& plan = plans_[&plans_[0] == used ? 1 : 0];
  if (spare != nullptr && spare != &plan) exchange(plan.feedback.K, spare->feedback.K);
  plan.times = times_;
  plan.trajectory = answer.trajectory;
  if (other_ && &answer == &*other_)
    std::swap(plan.feedback, other_->feedback);
  else
    solver_.take_feedback(plan.feedback);
  plan.multipliers = answer.constraint_multipliers;
  return plan;
}

}  // namespace conddp
