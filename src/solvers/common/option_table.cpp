#include "solvers/common/option_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kHessianChoices[] = {"automatic", "gauss_newton", "exact"};

constexpr std::string_view kPairRelaxations[] = {"elementwise", "inner_product",
                                                 "fischer_burmeister", "penalty"};

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
    OptionInfo{.name = "threads",
               .doc = "Threads that evaluate and differentiate knots; results do not depend on it.",
               .min = 1,
               .max = 1024,
               .access = CONDDP_ACCESS(threads)},
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
    OptionInfo{.name = "regularization.initial",
               .doc = "Weight of half the squares of the step in the first sweep's model; it rises "
                      "where steps fail and falls where they succeed. 0 is none.",
               .min = 0,
               .max = SolverOptions::Regularization::kLargest,
               .access = CONDDP_ACCESS(regularization.initial)},
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
    OptionInfo{
        .name = "complementarity.relaxation",
        .doc = "For ipopt: relaxation of complementary pairs z, s: z s <= epsilon each, their sum "
               "over a knot, smoothed Fischer-Burmeister equations, or an exact penalty 1/epsilon.",
        .choices = kPairRelaxations,
        .access = CONDDP_ACCESS(complementarity.relaxation)},
    OptionInfo{.name = "complementarity.initial",
               .doc =
                   "First epsilon, in the product of the pairs' units; for ipddp 3 at least. The "
                   "ticks of a closed loop keep it.",
               .min = SolverOptions::Complementarity::kLast,
               .max = kInfinity,
               .max_excluded = true,
               .access = CONDDP_ACCESS(complementarity.initial)},
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

/// The first penalty must not exceed the largest one.
void check_penalties(const SolverOptions::AugmentedLagrangian& penalties,
                     std::vector<std::string>& messages) {
  if (penalties.initial_penalty > penalties.max_penalty)
    messages.push_back(
        fmt::format("augmented_lagrangian.initial_penalty ({}) must be at most "
                    "augmented_lagrangian.max_penalty ({})",
                    penalties.initial_penalty, penalties.max_penalty));
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
  check_penalties(augmented_lagrangian, messages);
  return messages;
}

}  // namespace conddp
