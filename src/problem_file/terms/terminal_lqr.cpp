#include "problem_file/terms/terminal_lqr.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/weighted_residual.hpp"
#include "problem_file/motion/planar_motion.hpp"
#include "problem_file/motion/quasi_static.hpp"

namespace conddp {
namespace {

/// Builds the ingredients step by step.
class TerminalLqrBuilder {
 public:
  TerminalLqrBuilder(const TerminalLqrContext& context, Diagnostics& out)
      : context_(context), spec_(*context.spec.terminal_lqr), out_(out) {}

  std::shared_ptr<const TerminalLqr> build() {
    if (!is_supported() || !is_free_name()) return nullptr;
    auto x = equilibrium_of(spec_, context_.states);
    if (!x) return nullptr;
    if (!context_.plant.parts.empty())
      displace_base(context_.plant, context_.plant.parts.front(), spec_.moved, *x);
    TerminalResult found = find_terminal_ingredients(guess(*x), tangent_names_of_model());
    if (!found.ingredients) return fail(place(), found.fault, found.hint);
    auto lqr = std::make_shared<TerminalLqr>(
        TerminalLqr{*std::move(found.ingredients), {}, spec_.weight, spec_.set});
    lqr->set = largest_terminal_set(lqr->ingredients);
    if (spec_.set && !has_set(lqr->set)) return nullptr;
    return lqr;
  }

 private:
  std::nullptr_t fail(const Place& where, std::string message, std::string hint = {}) const {
    out_.error(where, std::move(message), std::move(hint));
    return nullptr;
  }

  const Place& place() const { return spec_.name ? spec_.name->place : spec_.place; }

  bool is_supported() const {
    const bool implicit = context_.plant.stepping() || context_.plant.collocation();
    if (implicit)
      fail(spec_.place,
           "'lqr' needs steps that are maps of state and control, and these have unknowns of their "
           "own",
           "contact-implicit steps and collocation have no linear map of state and control alone");
    return !implicit;
  }

  /// True if the name of its cost and constraint is free.
  bool is_free_name() const {
    const auto taken = [this](const Name& name) {
      if (name.value == kTerminalLqrName)
        fail(name.place, "this name is that of what 'terminal: {lqr: ...}' adds");
      return name.value == kTerminalLqrName;
    };
    const auto is_taken = [&](const auto& list, const auto& name_of) {
      return std::any_of(list.begin(), list.end(),
                         [&](const auto& entry) { return taken(name_of(entry)); });
    };
    const ProblemSpec& all = context_.spec;
    const auto of_cost = [](const CostSpec& cost) { return cost.name; };
    const auto of_constraint = [](const ConstraintSpec& c) { return c.function.name; };
    return !is_taken(all.costs, of_cost) && !is_taken(all.terminal_costs, of_cost) &&
           !(spec_.set && (is_taken(all.control_bounds, of_constraint) ||
                           is_taken(all.constraints, of_constraint) ||
                           is_taken(all.terminal_constraints, of_constraint)));
  }

  /// The last phase that takes time.
  const Phase& phase() const {
    std::size_t p = context_.phases.size() - 1;
    while (p > 0 && context_.spec.phases[p].takes_no_time()) --p;
    return context_.phases[p];
  }

  EquilibriumGuess guess(std::vector<double> x) const {
    const Phase& last = phase();
    const System& system = last.model->system();
    Eigen::VectorXd u = quasi_static_control(system, x.data());
    x.insert(x.end(), context_.tail_at_start.begin(), context_.tail_at_start.end());
    return {last, last.knots() - 1, std::move(x), std::move(u)};
  }

  std::vector<std::string> tangent_names_of_model() const {
    std::vector<std::string> names = tangent_names(*context_.plant.system).names;
    for (const Column& column : context_.tail) names.push_back(column.name);
    return names;
  }

  bool has_set(const TerminalSet& set) const {
    if (set.level > 0 && std::isfinite(set.level)) return true;
    if (set.bounds.empty() || set.level > 0)
      fail(spec_.set_place, "nothing bounds the terminal set",
           "bounds on the control, or constraints of the last knot that takes time, bound it");
    else if (set.bounds.front().distance > 0)
      fail(spec_.set_place,
           fmt::format("no terminal set is within '{}', which states that cost nothing move",
                       set.bounds.front().name),
           "leave 'set' out, or give these states a running cost");
    else
      fail(spec_.set_place,
           fmt::format("no terminal set is within '{}', which leaves {:.3g} at the equilibrium",
                       set.bounds.front().name, set.bounds.front().distance),
           "leave 'set' out, or move the state or the bound");
    return false;
  }

  const TerminalLqrContext& context_;
  const TerminalLqrSpec& spec_;
  Diagnostics& out_;
};

}  // namespace

std::optional<std::vector<double>> equilibrium_of(const TerminalLqrSpec& lqr,
                                                  const StateBuilder& states) {
  return lqr.name ? states.named(*lqr.name) : states.build(lqr.state);
}

std::shared_ptr<const TerminalLqr> build_terminal_lqr(const TerminalLqrContext& context,
                                                      Diagnostics& out) {
  return TerminalLqrBuilder(context, out).build();
}

void add_terminal_lqr(const TerminalLqr& lqr, KnotModel& model, std::vector<double>& parameters) {
  const TerminalIngredients& own = lqr.ingredients;
  const auto distance = weighted_residual(state_residual(model.manifold()), own.P);
  const int cost = model.add_cost(kTerminalLqrName, distance, {});
  const int constraint =
      lqr.constrained
          ? model.add_constraint(make_constraint(kTerminalLqrName, distance, ConstraintKind::norm))
          : -1;
  parameters.resize(model.parameter_count());
  std::copy(own.x.begin(), own.x.end(), parameters.begin() + cost);
  parameters[model.costs().back().weight] = lqr.weight;
  if (constraint < 0) return;
  const ConstraintTerm& term = model.constraints().back();
  std::copy(own.x.begin(), own.x.end(), parameters.begin() + constraint);
  parameters[term.lower()] = -std::numeric_limits<double>::infinity();
  parameters[term.upper()] = std::sqrt(lqr.set.level);
  parameters[term.active()] = 1;
}

}  // namespace conddp
