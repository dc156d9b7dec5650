#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "nlp/ipopt_options.hpp"
#include "problem_file/lower/homotopy_numbers.hpp"
#include "problem_file/read/problem_schema.hpp"
#include "problem_file/read/read_sections.hpp"
#include "solvers/common/option_table.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void read_option(const YamlReader& reader, const OptionInfo& info, SolverOptions& options) {
  if (!info.choices.empty()) {
    std::vector<std::string> words(info.choices.begin(), info.choices.end());
    const std::string what = fmt::format("value of '{}'", info.name);
    if (const auto index = reader.choose(words, what)) info.set(options, words[*index]);
    return;
  }
  if (reader.is_null() && info.max == kInfinity && !info.max_excluded) {
    info.set(options, kInfinity);
    return;
  }
  const auto number = reader.number();
  if (!number) return;
  if (const auto wrong = info.set(options, *number)) reader.error(*wrong);
}

std::optional<IpoptValue> read_ipopt_value(const std::string& name, const YamlReader& reader) {
  if (!reader.is_number()) {
    auto text = reader.text();
    if (!text) return std::nullopt;
    return IpoptValue(*std::move(text));
  }
  const auto number = reader.number();
  if (!number) return std::nullopt;
  const bool whole = *number == std::floor(*number) && std::abs(*number) < 2e9;
  if (whole && is_integer_option(name)) return IpoptValue(static_cast<int>(*number));
  return IpoptValue(*number);
}

std::string shown(const IpoptValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

/// The library checks names, types and ranges, and which options its build supports.
void read_ipopt_options(const YamlReader& reader, IpoptOptions& options) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  std::vector<const YamlReader*> readers;
  for (const auto& [name, value] : *entries) {
    auto read = read_ipopt_value(name.value, value);
    if (!read) continue;
    const auto fault = check_ipopt_option(name.value, *read);
    if (!fault) {
      options.emplace_back(name.value, *std::move(read));
      readers.push_back(&value);
    } else if (fault->kind == IpoptOptionFault::Kind::value) {
      value.error(fault->message);
    } else {
      reader.diagnostics().error(
          name.place, fault->message,
          fault->kind == IpoptOptionFault::Kind::unknown
              ? name_hint(name.value, ipopt_option_names(), "options of Ipopt")
              : "");
    }
  }
  if (const auto unusable = first_unusable_ipopt_option(options)) {
    const auto& [name, value] = options[*unusable];
    readers[*unusable]->error(
        fmt::format("this machine's Ipopt cannot use '{}' as '{}'", shown(value), name),
        "it was built without it, or needs more than conddp tells it");
  }
}

std::optional<OrderedJson> expand_ipopt_options(const IpoptOptions& options) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, value] : options)
    std::visit([&, &key = name](const auto& v) { json[key] = v; }, value);
  return json;
}

/// An option of solvers.
struct OptionKey final : KeyValue {
  OptionKey(const OptionInfo& its_info, SolverOptions& its_options)
      : info(its_info), options(its_options) {}
  void read(const YamlReader& reader) override { read_option(reader, info, options); }
  std::optional<OrderedJson> expand() const override {
    return std::visit(
        [](const auto& value) {
          if constexpr (std::is_same_v<decltype(value), const double&>)
            return finite_or_null(value);
          else
            return OrderedJson(value);
        },
        info.get(options));
  }
  OrderedJson schema(SchemaDefinitions& /*definitions*/) const override {
    if (!info.choices.empty()) return {{"enum", info.choices}};
    const OptionValue fallback = info.default_value();
    const double* number = std::get_if<double>(&fallback);
    OrderedJson type = number == nullptr ? "integer" : "number";
    if (number != nullptr && std::isinf(*number)) type = {"number", "null"};
    OrderedJson schema = {{"type", std::move(type)}};
    schema[info.min_excluded ? "exclusiveMinimum" : "minimum"] = info.min;
    if (std::isfinite(info.max))
      schema[info.max_excluded ? "exclusiveMaximum" : "maximum"] = info.max;
    return schema;
  }

  const OptionInfo& info;
  SolverOptions& options;
};

/// Documentation of groups of options.
struct OptionGroup {
  std::string_view name, title, says, examples;
};
constexpr OptionGroup kGroups[] = {
    {"tolerances", "Tolerances", "Converged means that all of them are met at once",
     R"([{"stationarity": 1.0e-8}])"},
    {"regularization", "Regularization", "Makes stage problems convex and steps shorter",
     R"([{"initial": 0.001}])"},
    {"augmented_lagrangian", "Augmented Lagrangian",
     "How constraints are enforced, of altro and proxddp; the penalty is 1/mu of the latter's "
     "literature",
     R"([{"initial_penalty": 1}])"},
    {"complementarity", "Complementary pairs",
     "How the pairs of contact-implicit problems are relaxed and tightened, of ipopt",
     R"([{"relaxation": "fischer_burmeister"}])"},
    {"restarts", "Random restarts", "Further guesses", R"([{"count": 8, "seed": 1}])"}};

/// An option, or a group of options, of former versions.
struct RemovedOption {
  std::string_view group, name;
  std::string_view hint = "leave it out: conddp chooses it";
};
constexpr std::string_view kByWeight = "leave it out: conddp adapts the weight, from 'initial' on";
constexpr std::string_view kBySteps = "leave it out: 'threads' share the knots of each evaluation";
constexpr std::string_view kByEpsilon = "leave it out: 'initial' sets the first epsilon";
constexpr RemovedOption kRemoved[] = {
    {"", "legs", kBySteps},
    {"", "segments", kBySteps},
    {"", "line_search"},
    {"", "box_qp"},
    {"regularization", "kind", kByWeight},
    {"regularization", "min", kByWeight},
    {"regularization", "max", kByWeight},
    {"regularization", "factor", kByWeight},
    {"regularization", "decrease_step", kByWeight},
    {"regularization", "increase_step", kByWeight},
    {"complementarity", "factor", kByEpsilon},
    {"complementarity", "final", kByEpsilon},
    {"complementarity", "fallback",
     "leave it out: the other relaxations follow if one finds no answer"}};

/// Options of former versions in a group, or outside of the groups.
void visit_removed(Keys& keys, std::string_view group) {
  for (const RemovedOption& option : kRemoved)
    if (option.group == group) keys.removed(option.name, option.hint);
}

std::string_view group_of(const OptionInfo& info) {
  const std::size_t dot = info.name.find('.');
  return dot == std::string_view::npos ? "" : info.name.substr(0, dot);
}

void visit_option(Keys& keys, const OptionInfo& info, SolverOptions& options) {
  OptionKey value(info, options);
  keys.visit({.name = info.name.substr(info.name.find('.') + 1), .says = info.doc}, value);
}

/// Visits the options of a group.
void visit_group(Keys& keys, const OptionGroup& group, SolverOptions& options) {
  keys.about({.title = group.title, .examples = group.examples});
  for (const OptionInfo& info : option_table())
    if (group_of(info) == group.name) visit_option(keys, info, options);
  visit_removed(keys, group.name);
}

/// "auto: ...; ilqr: ...".
const std::string& meaning_of_solvers() {
  static const std::string meaning = [] {
    std::string text = fmt::format("{}: {}", kAutoSolver, kAutoMeaning);
    for (const SolverInfo& info : solvers())
      text += fmt::format("; {}: {}", info.name, info.description);
    return text;
  }();
  return meaning;
}

/// The name of a solver; an unknown one is reported when the problem is built.
struct SolverNameForm : NameForm {
  OrderedJson schema() const {
    OrderedJson names = {kAutoSolver};
    for (const SolverInfo& info : solvers()) names.push_back(info.name);
    return {{"enum", std::move(names)}};
  }
};

}  // namespace

void describe(Keys& keys, SolverOptions& options) {
  std::string_view former;
  for (const OptionInfo& info : option_table()) {
    const std::string_view name = group_of(info);
    if (name.empty()) visit_option(keys, info, options);
    if (!name.empty() && name != former) {
      const OptionGroup& group = *std::ranges::find(kGroups, name, &OptionGroup::name);
      keys({name, group.says},
           GroupValue([&](Keys& inner) { visit_group(inner, group, options); }));
    }
    former = name;
  }
  visit_removed(keys, "");
  keys(
      {.name = "options",
       .says = "Options of the library Ipopt by its own names and in its own units, of ipopt: "
               "numbers and words, checked against the library",
       .examples = R"([{"mu_strategy": "adaptive"}])",
       .fallback = "{}"},
      CustomValue{[&](const YamlReader& reader) { read_ipopt_options(reader, options.ipopt); },
                  [&] { return expand_ipopt_options(options.ipopt); },
                  R"({"type": "object", "additionalProperties": {"type": ["number", "string"]}})"});
}

void describe(Keys& keys, SolverSpec& solver) {
  keys.about({.definition = "solver",
              .title = "Solver and its options",
              .says = "Which method solves the problem, and its options",
              .examples = R"([{"name": "box_fddp", "max_iterations": 300},
                              {"name": "ddp", "tolerances": {"stationarity": 1.0e-8}},
                              {"name": "ipopt", "options": {"mu_strategy": "adaptive"}}])"});
  keys({"name", meaning_of_solvers()}, solver.name, SolverNameForm{});
  describe(keys, solver.options);
  keys({.name = "homotopy",
        .says = "Numbers of the problem that move together, from those of an easier problem to its "
                "own; each problem in between is solved starting from the previous answer",
        .examples = R"([[{"key": "constraints.torque.scale", "from": 3, "to": 1}]])",
        .fallback = "[]"},
       solver.homotopy, HomotopyForm{});
  YamlMap* map = keys.reading();
  if (map == nullptr || map->reader().diagnostics().has_errors()) return;
  for (const std::string& message : solver.options.validate()) map->reader().error(message);
}

}  // namespace conddp
