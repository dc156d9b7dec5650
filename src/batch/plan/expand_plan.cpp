#include "batch/plan/expand_plan.hpp"

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "base/json/relative_paths.hpp"
#include "base/text/strict_number.hpp"
#include "batch/plan/neighbours.hpp"
#include "problem_file/yaml/canonical_definition.hpp"

namespace conddp {
namespace {

/// Items that are built before errors among them are looked for.
constexpr std::size_t kAtOnce = 1024;

/// A value as JSON. Whole numbers have no decimal point.
std::string value_json(const YamlNode& value) {
  const auto number = value.quoted ? std::nullopt : parse_number(value.text).value;
  if (value.kind != YamlNode::Kind::kScalar || !number) return canonical_value(value);
  return fmt::format("{}", *number);
}

/// Counts through all items in their order.
class Expansion {
 public:
  Expansion(const BatchPlan& plan, const std::filesystem::path& run, Diagnostics& out)
      : plan_(plan), run_(std::filesystem::absolute(run)), out_(out) {}

  std::optional<Manifest> run() {
    Manifest manifest{.name = plan_.name.value,
                      .command = plan_.command,
                      .limits = plan_.limits,
                      .keep = plan_.keep,
                      .warm_start = plan_.warm_start,
                      .solvers = static_cast<int>(solvers()),
                      .build = build_json()};
    for (const Axis& axis : plan_.axes)
      for (const AxisColumn& column : axis.columns)
        manifest.columns.push_back({column.name, column.key.value});
    for (const auto& problem : plan_.problems) {
      const auto family = ProblemFamily::load(problem.value, problem.place, out_);
      if (!family) continue;
      families_.push_back(family);
      manifest.problems.push_back({relative_path(std::filesystem::absolute(problem.value), run_),
                                   batch_identity(*family, plan_.command)});
    }
    if (out_.has_errors()) return std::nullopt;
    manifest.items.resize(static_cast<std::size_t>(plan_.items()));
    for (std::size_t first = 0; first < manifest.items.size(); first += kAtOnce)
      if (!build(first, std::min(first + kAtOnce, manifest.items.size()), manifest))
        return std::nullopt;
    if (!all_differ(manifest.items)) return std::nullopt;
    if (plan_.warm_start == WarmStart::kNeighbour) find_parents(manifest);
    return manifest;
  }

 private:
  /// What makes up an item.
  struct Parts {
    int problem = 0;
    std::vector<std::size_t> rows;  ///< of the axes
    std::size_t solver = 0;
  };

  std::size_t solvers() const { return std::max<std::size_t>(1, plan_.solvers.size()); }

  Parts parts(std::size_t item) const {
    Parts parts{.rows = std::vector<std::size_t>(plan_.axes.size())};
    parts.solver = item % solvers();
    item /= solvers();
    for (std::size_t a = plan_.axes.size(); a-- > 0; item /= plan_.axes[a].rows.size())
      parts.rows[a] = item % plan_.axes[a].rows.size();
    parts.problem = static_cast<int>(item);
    return parts;
  }

  std::vector<Setting> settings(const Parts& parts) const {
    std::vector<Setting> list;
    const auto scalar = [](const Place& place, std::string text, bool quoted) {
      return YamlNode{.kind = YamlNode::Kind::kScalar,
                      .mark = place.mark,
                      .text = std::move(text),
                      .quoted = quoted};
    };
    // The clock of a loop is simulated: a limit is the worker's.
    if (const auto& limit = plan_.max_time; limit && plan_.command == BatchCommand::kSolve)
      list.push_back(make_setting({"solver.max_time_s", limit->place},
                                  scalar(limit->place, fmt::format("{}", limit->value), false)));
    for (std::size_t a = 0; a < plan_.axes.size(); ++a)
      for (std::size_t c = 0; c < plan_.axes[a].columns.size(); ++c)
        list.push_back(
            make_setting(plan_.axes[a].columns[c].key, plan_.axes[a].rows[parts.rows[a]][c]));
    if (plan_.start_file) list.push_back(start_setting(parts.problem));
    if (!plan_.solvers.empty()) {
      const Name& solver = plan_.solvers[parts.solver];
      list.push_back(
          make_setting({"solver.name", solver.place}, scalar(solver.place, solver.value, false)));
    }
    return list;
  }

  /// That a problem starts from the file of the plan, seen from its own folder.
  Setting start_setting(int problem) const {
    const std::filesystem::path folder =
        std::filesystem::absolute(plan_.problems[problem].value).parent_path();
    const OrderedJson file =
        relative_path(std::filesystem::absolute(plan_.start_file->value), folder);
    Diagnostics unused;
    return *parse_setting("initial_guess={file: " + file.dump() + "}", unused);
  }

  /// The files that an item reads; nothing with errors where it cannot be built.
  std::optional<InputFiles> try_item(int problem, const std::vector<Setting>& list,
                                     Diagnostics& out) const {
    const ProblemFamily& family = *families_[problem];
    if (plan_.command == BatchCommand::kMpc) {
      const auto loop = family.build_loop(list, out);
      return loop ? std::optional(input_files(*loop)) : std::nullopt;
    }
    const auto instance = family.build(list, out);
    if (!instance || usable_solvers(*instance->spec, *instance->built.problem, out).empty())
      return std::nullopt;
    return input_files(instance->built);
  }

  bool build(std::size_t first, std::size_t last, Manifest& manifest) {
    std::vector<Diagnostics> errors(last - first);
    tbb::parallel_for(first, last, [&](std::size_t i) {
      Diagnostics own = out_;
      const Parts p = parts(i);
      const std::vector<Setting> list = settings(p);
      const auto files = try_item(p.problem, list, own);
      if (!files) {
        errors[i - first] = std::move(own);
        return;
      }
      ManifestItem& item = manifest.items[i];
      item = {.id = item_id(manifest.problems[p.problem].identity, list, *files),
              .problem = p.problem};
      for (const Setting& setting : list) item.settings.push_back(setting.text);
      for (std::size_t a = 0; a < plan_.axes.size(); ++a)
        for (const YamlNode& value : plan_.axes[a].rows[p.rows[a]])
          item.values.push_back(value_json(value));
    });
    for (std::size_t i = first; i < last; ++i)
      if (errors[i - first].has_errors()) {
        report(i, errors[i - first]);
        return false;
      }
    return true;
  }

  void report(std::size_t item, const Diagnostics& own) {
    const Parts p = parts(item);
    std::string words;
    for (const Setting& setting : settings(p)) words += (words.empty() ? "" : ", ") + setting.text;
    out_ = own;
    out_.note({}, fmt::format("this is item {} of {}, of '{}'{}", item + 1, plan_.items(),
                              plan_.problems[p.problem].value.string(),
                              words.empty() ? "" : " with " + words));
  }

  /// The files of two items, where they are not one.
  std::string files_of(const Parts& a, const Parts& b) const {
    if (a.problem == b.problem) return {};
    return fmt::format(": '{}' and '{}'", plan_.problems[a.problem].value.string(),
                       plan_.problems[b.problem].value.string());
  }

  bool all_differ(const std::vector<ManifestItem>& items) {
    std::unordered_map<std::string, std::size_t> first;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto [other, fresh] = first.try_emplace(items[i].id, i);
      if (fresh) continue;
      const Parts a = parts(other->second), b = parts(i);
      Place place = plan_.problems[b.problem].place;
      for (std::size_t axis = 0; axis < a.rows.size(); ++axis)
        if (a.rows[axis] != b.rows[axis])
          place = {plan_.axes[axis].rows[b.rows[axis]][0].mark, plan_.axes[axis].name.place.path};
      out_.error(place, fmt::format("items {} and {} are the same problem with the same settings{}",
                                    other->second + 1, i + 1, files_of(a, b)));
      return false;
    }
    return true;
  }

  const BatchPlan& plan_;
  const std::filesystem::path run_;
  Diagnostics& out_;
  std::vector<std::shared_ptr<const ProblemFamily>> families_;
};

}  // namespace

std::optional<Manifest> expand_plan(const BatchPlan& plan, const std::filesystem::path& run,
                                    Diagnostics& out) {
  return Expansion(plan, run, out).run();
}

}  // namespace conddp
