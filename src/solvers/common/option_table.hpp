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

/// One option of SolverOptions: everything that a reader, a printer or a schema needs to know.
struct OptionInfo {
  std::string_view name;           ///< dotted path: "tolerances.stationarity"
  std::string_view doc;            ///< one sentence, with the unit
  std::string_view formerly = {};  ///< an earlier name that files may still have
  double min = 0;                  ///< smallest value allowed (numbers)
  double max = 0;  ///< largest value allowed; infinity itself is allowed where this is
  bool min_excluded = false;
  bool max_excluded = false;
  std::span<const std::string_view> choices;  ///< names in the enum's order, empty for numbers

  using Reference = std::variant<int*, double*, RegularizationKind*, HessianChoice*,
                                 PairRelaxation*, RelaxationFallback*>;
  Reference (*access)(SolverOptions& options);

  OptionValue get(const SolverOptions& options) const;
  OptionValue default_value() const { return get(SolverOptions()); }
  /// Sets the option; a double with a whole value serves an integer option. Returns what is wrong
  /// with the value instead of setting it, if anything is.
  std::optional<std::string> set(SolverOptions& options, const OptionValue& value) const;
  /// What is wrong with the value that `options` has, if anything.
  std::optional<std::string> check(const SolverOptions& options) const;
};

/// All options in the order in which documents list them.
std::span<const OptionInfo> option_table();
/// The option with this dotted name, or null.
const OptionInfo* find_option(std::string_view name);

}  // namespace conddp
