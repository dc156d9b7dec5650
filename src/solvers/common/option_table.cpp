#include "solvers/common/option_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kRegularizationKinds[] = {"proximal", "state", "control"};
constexpr std::string_view kHessianChoices[] = {"automatic", "gauss_newton", "exact"};

constexpr std::string_view kPairRelaxations[] = {"elementwise", "inner_product",
                                                 "fischer_burmeister", "penalty"};
constexpr std::string_view kRelaxationFallbacks[] = {"automatic", "none"};

#define CONDDP_ACCESS(member) [](SolverOptions& o) -> OptionInfo::Reference { return &o.member; }

constexpr std::array kTable = {
    OptionInfo{.name = "max_iterations",
               .doc = "Maximum number of accepted steps.",
               .min = 0,
               .max = 1e9,
               .access = CONDDP_ACCESS(max_iterations)},
    OptionInfo{.name = "max_time_s",
               .doc = "Limit on the wall-clock time, s.",
               .min = 0,
               .max = kInfinity,
               .access = CONDDP_ACCESS(max_time_s)},
    OptionInfo{
        .name = "threads",
        .doc = "Threads that evaluate and differentiate knots and sweep segments; results do not "
               "depend on it.",
        .min = 1,
        .max = 1024,
        .access = CONDDP_ACCESS(threads)},
    OptionInfo{.name = "segments",
               .doc = "For proxddp: horizon segments swept in parallel, as far as there are "
                      "threads; at most as many as knots.",
               .formerly = "legs",
               .min = 1,
               .max = 1024,
               .access = CONDDP_ACCESS(segments)},
    OptionInfo{.name = "hessian",
               .doc = "Second derivatives of the dynamics: the solver's own choice, left out, or "
                      "exact. Where a cost is linear in its residual, automatic means exact for "
                      "solvers that have exact Hessians.",
               .choices = kHessianChoices,
               .access = CONDDP_ACCESS(hessian)},
    OptionInfo{.name = "tolerances.stationarity",
               .doc = "Largest gradient entry of the Lagrangian in the controls, projected on "
                      "their bounds, at convergence; cost per control unit.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(tolerances.stationarity)},
    OptionInfo{.name = "tolerances.gap",
               .doc = "Largest dynamics gap at convergence, in the state's units.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(tolerances.gap)},
    OptionInfo{.name = "tolerances.constraint",
               .doc = "Largest constraint violation at convergence, in the constraint's units.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(tolerances.constraint)},
    OptionInfo{.name = "tolerances.complementarity",
               .doc = "Largest product of a multiplier and the distance from its bound at "
                      "convergence, in the cost's unit.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(tolerances.complementarity)},
    OptionInfo{.name = "tolerances.cost_decrease",
               .doc = "Stop if three feasible iterations in a row change the cost by at most this "
                      "share, at the rate of a full step, without unit; 0 is never.",
               .min = 0,
               .max = 1,
               .max_excluded = true,
               .access = CONDDP_ACCESS(tolerances.cost_decrease)},
    OptionInfo{
        .name = "regularization.kind",
        .doc = "Regularized quantity: half the squares of the whole step, in the model (proximal), "
               "or, only in the gains, V_xx through the dynamics (state) or Q_uu (control).",
        .choices = kRegularizationKinds,
        .access = CONDDP_ACCESS(regularization.kind)},
    OptionInfo{.name = "regularization.initial",
               .doc = "Regularization of the first sweep; 0 is none.",
               .min = 0,
               .max = kInfinity,
               .max_excluded = true,
               .access = CONDDP_ACCESS(regularization.initial)},
    OptionInfo{.name = "regularization.min",
               .doc = "Smallest nonzero regularization, the first one after 0; lower if the "
                      "curvature of the costs in the controls is lower.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(regularization.min)},
    OptionInfo{.name = "regularization.max",
               .doc = "Regularization beyond which the solver gives up.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(regularization.max)},
    OptionInfo{.name = "regularization.factor",
               .doc = "Factor by which the rate of its change grows with each change in the same "
                      "direction.",
               .min = 1,
               .max = 1e6,
               .min_excluded = true,
               .access = CONDDP_ACCESS(regularization.factor)},
    OptionInfo{.name = "regularization.decrease_step",
               .doc = "Decrease it after a step at least this long.",
               .min = 0,
               .max = 1,
               .access = CONDDP_ACCESS(regularization.decrease_step)},
    OptionInfo{.name = "regularization.increase_step",
               .doc = "Increase it after a step at most this long.",
               .min = 0,
               .max = 1,
               .max_excluded = true,
               .access = CONDDP_ACCESS(regularization.increase_step)},
    OptionInfo{.name = "line_search.min_step",
               .doc = "Shortest step length that is tried; each is half the one before.",
               .min = 0,
               .max = 1,
               .min_excluded = true,
               .access = CONDDP_ACCESS(line_search.min_step)},
    OptionInfo{.name = "line_search.armijo",
               .doc = "Share of the first-order decrease that a step has to reach.",
               .min = 0,
               .max = 0.5,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(line_search.armijo)},
    OptionInfo{.name = "line_search.merit_margin",
               .doc = "Weight in the merit of gaps that a step opens, as a multiple of the largest "
                      "multiplier.",
               .min = 1,
               .max = 1e6,
               .min_excluded = true,
               .access = CONDDP_ACCESS(line_search.merit_margin)},
    OptionInfo{.name = "augmented_lagrangian.initial_penalty",
               .doc = "Initial penalty of every constraint; cost per squared constraint unit. "
                      "Lower for constraints on controls in which the curvature of the costs is "
                      "below a ten-thousandth of it.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(augmented_lagrangian.initial_penalty)},
    OptionInfo{.name = "augmented_lagrangian.penalty_factor",
               .doc = "Factor by which the penalty of a constraint grows.",
               .min = 1,
               .max = 1e6,
               .min_excluded = true,
               .access = CONDDP_ACCESS(augmented_lagrangian.penalty_factor)},
    OptionInfo{.name = "augmented_lagrangian.max_penalty",
               .doc = "Largest penalty.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(augmented_lagrangian.max_penalty)},
    OptionInfo{.name = "augmented_lagrangian.sufficient_decrease",
               .doc = "For altro: a penalty grows if the violation exceeds this share of its value "
                      "at the last update.",
               .min = 0,
               .max = 1,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(augmented_lagrangian.sufficient_decrease)},
    OptionInfo{.name = "box_qp.max_iterations",
               .doc = "Projected Newton steps of one stage problem.",
               .min = 1,
               .max = 1e6,
               .access = CONDDP_ACCESS(box_qp.max_iterations)},
    OptionInfo{
        .name = "box_qp.armijo",
        .doc = "Share of the first-order decrease that a projected Newton step has to reach.",
        .min = 0,
        .max = 0.5,
        .min_excluded = true,
        .max_excluded = true,
        .access = CONDDP_ACCESS(box_qp.armijo)},
    OptionInfo{.name = "box_qp.horizon_sweeps",
               .doc = "Sweeps per iteration that look for the active set of the whole horizon; 0: "
                      "only the active set of each stage alone.",
               .min = 0,
               .max = 1e6,
               .access = CONDDP_ACCESS(box_qp.horizon_sweeps)},
    OptionInfo{
        .name = "complementarity.relaxation",
        .doc = "For ipopt: relaxation of complementary pairs z, s: z s <= epsilon each, their sum "
               "over a knot, smoothed Fischer-Burmeister equations, or an exact penalty 1/epsilon.",
        .choices = kPairRelaxations,
        .access = CONDDP_ACCESS(complementarity.relaxation)},
    OptionInfo{.name = "complementarity.fallback",
               .doc = "Where that finds no answer: try the other relaxations, or none.",
               .choices = kRelaxationFallbacks,
               .access = CONDDP_ACCESS(complementarity.fallback)},
    OptionInfo{.name = "complementarity.initial",
               .doc = "First epsilon, in the product of the pairs' units.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(complementarity.initial)},
    OptionInfo{.name = "complementarity.factor",
               .doc = "Factor by which epsilon shrinks from one solve to the next, without unit.",
               .min = 0,
               .max = 1,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(complementarity.factor)},
    OptionInfo{.name = "complementarity.final",
               .doc = "Last epsilon, unless the pairs are complementary to tolerance earlier, in "
                      "the product of the pairs' units.",
               .min = 0,
               .max = kInfinity,
               .min_excluded = true,
               .max_excluded = true,
               .access = CONDDP_ACCESS(complementarity.final)},
    OptionInfo{
        .name = "look_further",
        .doc = "For auto in conddp solve: the work up to which other solvers and guesses are tried "
               "after an answer. Work is iterations times knots times states and controls times "
               "these and the rows of constraints; 0: the first answer counts.",
        .min = 0,
        .max = 1e9,
        .access = CONDDP_ACCESS(look_further)},
    OptionInfo{.name = "restarts.count",
               .doc = "Further solves from random perturbations of the guess; the best answer "
                      "counts.",
               .min = 0,
               .max = 1000,
               .access = CONDDP_ACCESS(restarts.count)},
    OptionInfo{.name = "restarts.seed",
               .doc = "Seed of their random numbers.",
               .min = 0,
               .max = 1e9,
               .access = CONDDP_ACCESS(restarts.seed)},
    OptionInfo{.name = "restarts.spread",
               .doc = "Standard deviation of the perturbations of the guess's states and controls, "
                      "in their units.",
               .min = 0,
               .max = kInfinity,
               .max_excluded = true,
               .access = CONDDP_ACCESS(restarts.spread)},
};
#undef CONDDP_ACCESS

template <class T>
concept Choice = std::is_enum_v<T>;

/// Upper end of an option's range in words, after its lower end; empty if unlimited.
std::string describe_max(const OptionInfo& info) {
  if (info.max == kInfinity) return info.max_excluded ? " and finite" : "";
  return fmt::format(" and {} {}", info.max_excluded ? "<" : "at most", info.max);
}

std::optional<std::string> check_number(const OptionInfo& info, double value) {
  const bool above = info.min_excluded ? value > info.min : value >= info.min;
  const bool below = info.max_excluded ? value < info.max : value <= info.max;
  if (above && below) return std::nullopt;
  return fmt::format("{} must be {} {}{}, not {}", info.name, info.min_excluded ? ">" : "at least",
                     info.min, describe_max(info), value);
}

std::string list_choices(const OptionInfo& info) {
  std::string list;
  for (std::string_view choice : info.choices) {
    if (!list.empty()) list += ", ";
    list += choice;
  }
  return list;
}

/// Sets a choice by its name. Returns the reason if it cannot.
template <Choice T>
std::optional<std::string> set_value(const OptionInfo& info, const OptionValue& value, T& target) {
  const std::string* text = std::get_if<std::string>(&value);
  const auto end = info.choices.end();
  const auto found = text == nullptr ? end : std::find(info.choices.begin(), end, *text);
  if (found == end) return fmt::format("{} must be one of {}", info.name, list_choices(info));
  target = static_cast<T>(found - info.choices.begin());
  return std::nullopt;
}

/// Sets a number. Returns the reason if it cannot.
template <class T>
std::optional<std::string> set_value(const OptionInfo& info, const OptionValue& value, T& target) {
  const std::optional<double> number = number_in(value);
  if (!number) return fmt::format("{} must be a number", info.name);
  if (auto wrong = check_number(info, *number)) return wrong;
  if (std::is_same_v<T, int> && *number != std::floor(*number))
    return fmt::format("{} must be a whole number, not {}", info.name, *number);
  target = static_cast<T>(*number);
  return std::nullopt;
}

void check_ipopt_options(const SolverOptions& options, std::vector<std::string>& messages) {
  for (const auto& [name, value] : options.ipopt) {
    if (auto fault = check_ipopt_option(name, value)) messages.push_back(std::move(fault->message));
    if (name == "hessian_approximation" && value != IpoptValue("exact") &&
        options.hessian != HessianChoice::automatic)
      messages.emplace_back(
          "hessian must be automatic where Ipopt's option 'hessian_approximation' is not exact");
  }
}

/// Checks pairs of options where the first must not exceed the second.
void check_order(const SolverOptions& options, std::vector<std::string>& messages) {
  const auto at_most = [&](std::string_view name, double value, std::string_view limit_name,
                           double limit) {
    if (value > limit)
      messages.push_back(
          fmt::format("{} ({}) must be at most {} ({})", name, value, limit_name, limit));
  };
  const SolverOptions::Regularization& regularization = options.regularization;
  at_most("regularization.min", regularization.min, "regularization.max", regularization.max);
  at_most("augmented_lagrangian.initial_penalty", options.augmented_lagrangian.initial_penalty,
          "augmented_lagrangian.max_penalty", options.augmented_lagrangian.max_penalty);
  at_most("complementarity.final", options.complementarity.final, "complementarity.initial",
          options.complementarity.initial);
  at_most("regularization.initial", regularization.initial, "regularization.max",
          regularization.max);
  if (regularization.increase_step >= regularization.decrease_step)
    messages.push_back(
        fmt::format("regularization.increase_step ({}) must be < regularization.decrease_step ({})",
                    regularization.increase_step, regularization.decrease_step));
}

}  // namespace

OptionValue OptionInfo::get(const SolverOptions& options) const {
  SolverOptions copy = options;
  return std::visit(
      [&](auto* value) -> OptionValue {
        if constexpr (Choice<std::remove_pointer_t<decltype(value)>>) {
          return std::string(choices[static_cast<int>(*value)]);
        } else {
          return *value;
        }
      },
      access(copy));
}

std::optional<std::string> OptionInfo::set(SolverOptions& options, const OptionValue& value) const {
  return std::visit([&](auto* target) { return set_value(*this, value, *target); },
                    access(options));
}

std::optional<std::string> OptionInfo::check(const SolverOptions& options) const {
  SolverOptions copy = options;
  return std::visit(
      [&](auto* value) -> std::optional<std::string> {
        if constexpr (Choice<std::remove_pointer_t<decltype(value)>>) {
          const int index = static_cast<int>(*value);
          if (index >= 0 && index < static_cast<int>(choices.size())) return std::nullopt;
          return fmt::format("{} must be one of {}", name, list_choices(*this));
        } else {
          return check_number(*this, *value);
        }
      },
      access(copy));
}

std::span<const OptionInfo> option_table() { return kTable; }

const OptionInfo* find_option(std::string_view name) {
  for (const OptionInfo& info : kTable) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

std::vector<std::string> SolverOptions::validate() const {
  std::vector<std::string> messages;
  for (const OptionInfo& info : kTable) {
    if (auto wrong = info.check(*this)) messages.push_back(*std::move(wrong));
  }
  check_ipopt_options(*this, messages);
  check_order(*this, messages);
  return messages;
}

}  // namespace conddp
