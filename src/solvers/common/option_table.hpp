#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "solvers/common/options.hpp"

namespace conddp {

/// A value of an option: whole number, number, or one of the option's choices.
using OptionValue = std::variant<int, double, std::string>;

/// One option of SolverOptions, described for readers, printers and schemas.
struct OptionInfo {
  std::string_view name;  ///< dotted path: "tolerances.stationarity"
  std::string_view doc;   ///< one sentence, with the unit
  double min = 0;         ///< smallest allowed value (numbers)
  double max = 0;         ///< largest allowed value; if infinite, infinity itself is allowed
  bool min_excluded = false;
  bool max_excluded = false;
  std::span<const std::string_view> choices;  ///< names in the enum's order; empty for numbers

  using Reference = std::variant<int*, double*, HessianChoice*, PairRelaxation*>;
  Reference (*access)(SolverOptions& options);

  OptionValue get(const SolverOptions& options) const;
  OptionValue default_value() const { return get(SolverOptions()); }
  /// Sets the option; an integer option accepts a double with a whole value. Returns the reason
  /// instead of setting an invalid value.
  std::optional<std::string> set(SolverOptions& options, const OptionValue& value) const;
  /// Reason why the option's value in `options` is invalid, if it is.
  std::optional<std::string> check(const SolverOptions& options) const;
};

/// All options in the order of the documentation.
std::span<const OptionInfo> option_table();
/// Option with this dotted name, or null.
const OptionInfo* find_option(std::string_view name);

}  // namespace conddp
