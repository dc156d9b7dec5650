#include "nlp/ipopt/registered_options.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <IpIpoptApplication.hpp>
#include <IpRegOptions.hpp>
#include <fmt/format.h>

namespace conddp {
namespace {

using Ipopt::RegisteredOption;
using Ipopt::RegisteredOptions;

/// An option that the tool sets itself, or that would make a library write to a terminal or to
/// files.
struct Reserved {
  std::string_view name, reason;
};
constexpr std::array kReserved = {
    Reserved{"max_iter", "solver.max_iterations sets it"},
    Reserved{"bound_relax_factor", "bounds are kept as they are"},
    Reserved{"honor_original_bounds", "bounds are kept as they are"},
    Reserved{"print_level", "the log has every iteration"},
    Reserved{"print_frequency_iter", "the log has every iteration"},
    Reserved{"print_frequency_time", "the log has every iteration"},
    Reserved{"print_info_string", "the log has every iteration"},
    Reserved{"print_timing_statistics", "solution.json has the times"},
    Reserved{"print_user_options", "'check --expand' lists the options"},
    Reserved{"print_options_documentation", "Ipopt's own manual lists them"},
    Reserved{"print_options_latex_mode", "Ipopt's own manual lists them"},
    Reserved{"output_file", "solution.json has the log"},
    Reserved{"file_print_level", "solution.json has the log"},
    Reserved{"option_file_name", "options stand in the problem file"},
    Reserved{"replace_bounds", "bounds are kept as they are"},
    Reserved{"hsllib", "the linker finds the library, and files cannot name one"},
    Reserved{"pardisolib", "the linker finds the library, and files cannot name one"},
    Reserved{"skip_finalize_solution_call", "conddp receives the answer through this call"},
    Reserved{"warm_start_init_point", "the solver sets it when it restarts"},
    Reserved{"warm_start_entire_iterate", "the solver sets it when it restarts"},
    Reserved{"warm_start_same_structure", "the solver sets it when it restarts"},
    Reserved{"jac_c_constant", "the dynamics are not known to be linear"},
    Reserved{"jac_d_constant", "constraints are not known to be linear"},
    Reserved{"hessian_constant", "the Hessian is not known to be constant"},
    Reserved{"nlp_lower_bound_inf", "infinite bounds are known as such"},
    Reserved{"nlp_upper_bound_inf", "infinite bounds are known as such"},
};

const RegisteredOptions::RegOptionsList& registered() {
  static const Ipopt::SmartPtr<Ipopt::IpoptApplication> application =
      new Ipopt::IpoptApplication(false, false);
  static const RegisteredOptions::RegOptionsList list =
      application->RegOptions()->RegisteredOptionsList();
  return list;
}

const Reserved* find_reserved(std::string_view name) {
  for (const Reserved& entry : kReserved)
    if (entry.name == name) return &entry;
  return nullptr;
}

std::string choices(const RegisteredOption& option) {
  std::string list;
  for (const auto& entry : option.GetValidStrings()) {
    if (entry.value_ == "*") return {};
    list += fmt::format("{}{}", list.empty() ? "" : ", ", entry.value_);
  }
  return list;
}

std::string lower_limit(const RegisteredOption& option) {
  if (option.Type() == Ipopt::OT_Integer) return fmt::format("at least {}", option.LowerInteger());
  return fmt::format("{} {}", option.LowerStrict() ? "more than" : "at least",
                     option.LowerNumber());
}

std::string upper_limit(const RegisteredOption& option) {
  if (option.Type() == Ipopt::OT_Integer) return fmt::format("at most {}", option.UpperInteger());
  return fmt::format("{} {}", option.UpperStrict() ? "less than" : "at most", option.UpperNumber());
}

/// A range in words: "at least 0 and less than 1".
std::string range(const RegisteredOption& option) {
  std::vector<std::string> limits;
  if (option.HasLower()) limits.push_back(lower_limit(option));
  if (option.HasUpper()) limits.push_back(upper_limit(option));
  return fmt::format("{}", fmt::join(limits, " and "));
}

std::string text_fault(const RegisteredOption& option, const IpoptValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text != nullptr && option.IsValidStringSetting(*text)) return {};
  const std::string list = choices(option);
  return list.empty() ? "must be a text" : "must be one of " + list;
}

bool is_in_range(const RegisteredOption& option, double number) {
  if (option.Type() == Ipopt::OT_Integer)
    return std::abs(number) < 2e9 && option.IsValidIntegerSetting(static_cast<int>(number));
  return std::isfinite(number) && option.IsValidNumberSetting(number);
}

std::string number_fault(const RegisteredOption& option, const IpoptValue& value) {
  const std::optional<double> number = number_in(value);
  if (!number) return "must be a number";
  if (option.Type() == Ipopt::OT_Integer && *number != std::floor(*number))
    return fmt::format("must be a whole number, not {}", *number);
  if (is_in_range(option, *number)) return {};
  return fmt::format("must be {}, not {}", range(option), *number);
}

/// Reason why a value is invalid; empty if it is valid.
std::string value_fault(const RegisteredOption& option, const IpoptValue& value) {
  return option.Type() == Ipopt::OT_String ? text_fault(option, value)
                                           : number_fault(option, value);
}

}  // namespace

const std::vector<std::string>& registered_option_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& [name, option] : registered())
      if (find_reserved(name) == nullptr) list.push_back(name);
    return list;
  }();
  return names;
}

bool is_registered_integer(std::string_view name) {
  const auto found = registered().find(std::string(name));
  return found != registered().end() && found->second->Type() == Ipopt::OT_Integer;
}

std::optional<IpoptOptionFault> check_registered_option(std::string_view name,
                                                        const IpoptValue& value) {
  using Kind = IpoptOptionFault::Kind;
  if (const Reserved* entry = find_reserved(name))
    return IpoptOptionFault{
        Kind::reserved, fmt::format("Ipopt's option '{}' cannot be set: {}", name, entry->reason)};
  const auto found = registered().find(std::string(name));
  if (found == registered().end())
    return IpoptOptionFault{Kind::unknown, fmt::format("Ipopt has no option '{}'", name)};
  const std::string fault = value_fault(*found->second, value);
  if (fault.empty()) return std::nullopt;
  return IpoptOptionFault{Kind::value, fmt::format("Ipopt's option '{}' {}", name, fault)};
}

}  // namespace conddp
