#include "batch/plan/expand_plan.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include "base/json/json_document.hpp"
#include "base/json/relative_paths.hpp"
#include "base/text/strict_number.hpp"
#include "batch/plan/neighbours.hpp"
#include "batch/plan/varied_keys.hpp"
#include "problem_file/read/settled_settings.hpp"

namespace conddp {
namespace {

/// Number of items built before their errors are checked.
constexpr std::size_t kAtOnce = 1024;

/// Converts a scalar to a number, without a decimal point if it is whole; a boolean; or a text.
OrderedJson scalar_json(const YamlNode& value) {
  constexpr double kMostWhole = 1e15;
  const auto number = value.quoted ? std::nullopt : parse_number(value.text).value;
  if (number && std::abs(*number) < kMostWhole && std::round(*number) == *number)
    return static_cast<long long>(*number);
  if (number && std::isfinite(*number)) return *number;
  if (!value.quoted && (value.text == "true" || value.text == "false")) return value.text == "true";
  return value.text;
}

/// A value of the plan in the form of result tables and data sets.
OrderedJson value_json(const YamlNode& value) {
  OrderedJson json;
  switch (value.kind) {
    case YamlNode::Kind::kNull:
      break;
    case YamlNode::Kind::kScalar:
      return scalar_json(value);
    case YamlNode::Kind::kSequence:
      json = OrderedJson::array();
      for (const YamlNode& item : value.items) json.push_back(value_json(item));
      break;
    case YamlNode::Kind::kMap:
      json = OrderedJson::object();
      for (const YamlNode::Entry& entry : value.entries) json[entry.key] = value_json(entry.value);
  }
  return json;
}

std::string value_text(const YamlNode& value) {
  return value_json(value).dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

/// Collects the warnings of items. Warnings that differ only in numbers count as one.
class ItemWarnings {
 public:
  /// Suppresses warnings that have already been reported.
  void leave_out(const std::vector<Diagnostic>& list) {
    for (const Diagnostic& d : list) known_.try_emplace(without_numbers(d.message), kTold);
  }

  /// Adds the warnings of an item: those after the first `before` diagnostics of its list.
  void add(std::size_t item, const Diagnostics& texts, std::size_t before) {
    std::set<std::size_t> own;
    for (std::size_t i = before; i < texts.list().size(); ++i) {
      const Diagnostic& d = texts.list()[i];
      if (d.severity != Severity::kWarning) continue;
      const std::size_t number =
          known_.try_emplace(without_numbers(d.message), warnings_.size()).first->second;
      if (number == kTold || !own.insert(number).second) continue;
      if (number == warnings_.size()) warnings_.push_back({d, item});
      ++warnings_[number].count;
    }
  }

  /// Reports each warning with the first item that has it and the number of further ones.
  void report(Diagnostics& out) {
    for (Warning& warning : warnings_) {
      Diagnostic& d = warning.text;
      d.source = -1;  // only that item may know the text
      d.message += fmt::format(" (item {}", warning.first + 1);
      if (warning.count > 1) d.message += fmt::format(" and {} more", warning.count - 1);
      d.message += ')';
      out.add(std::move(d));
    }
  }

 private:
  static constexpr std::size_t kTold = std::numeric_limits<std::size_t>::max();
  struct Warning {
    Diagnostic text;
    std::size_t first;      ///< first item with the warning
    std::size_t count = 0;  ///< number of items with the warning
  };

  static std::string without_numbers(const std::string& message) {
    std::string text;
    for (const char c : message) {
      const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
      if (text.ends_with('0') && (is_digit || c == '.')) continue;
      text += is_digit ? '0' : c;
    }
    return text;
  }

  std::vector<Warning> warnings_;
  std::unordered_map<std::string, std::size_t> known_;  ///< indices, or kTold
};

/// Enumerates all items in order.
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
    const Diagnostics texts = out_;
    for (const auto& problem : plan_.problems) {
      // Each problem has its own texts, as in a worker, so items cannot share data.
      Diagnostics own = texts;
      const auto family = ProblemFamily::load(problem.value, problem.place, own);
      adopt(own, texts.list().size());
      if (!family) continue;
      families_.push_back(family);
      manifest.problems.push_back({relative_path(std::filesystem::absolute(problem.value), run_),
                                   batch_identity(*family, plan_.command)});
    }
    for (const auto& family : families_)
      if (!out_.has_errors()) check_varied_keys(plan_, *family, out_);
    if (plan_.start_file) manifest.start = start();
    if (out_.has_errors()) return std::nullopt;
    warnings_.leave_out(out_.list());
    manifest.items.resize(static_cast<std::size_t>(plan_.items()));
    for (std::size_t first = 0; first < manifest.items.size(); first += kAtOnce)
      if (!build(first, std::min(first + kAtOnce, manifest.items.size()), manifest))
        return std::nullopt;
    if (!all_differ()) return std::nullopt;
    if (plan_.warm_start == WarmStart::kNeighbour) find_parents(manifest, shapes_);
    for (const auto& [path, sha256] : files_)
      manifest.files.push_back({relative_path(path, run_), sha256});
    warnings_.report(out_);
    return manifest;
  }

 private:
  /// Copies the diagnostics after the first `before` ones; their texts may be unknown here.
  void adopt(const Diagnostics& own, std::size_t before) {
    for (std::size_t i = before; i < own.list().size(); ++i) {
      Diagnostic d = own.list()[i];
      d.source = -1;
      // A plan does not have --solver or --drop.
      if (d.hint.starts_with("choose one of them with --solver"))
        d.hint = "choose one of them under 'solvers'; 'auto' does so by the problem";
      out_.add(std::move(d));
    }
  }

  /// The parts that define an item.
  struct Parts {
    int problem = 0;
    std::vector<std::size_t> rows;  ///< indices into the axes
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
    // A loop's clock is simulated, so its time limit is that of the worker.
    if (const auto& limit = plan_.max_time; limit && plan_.command == BatchCommand::kSolve)
      list.push_back(make_setting({"solver.max_time_s", limit->place},
                                  scalar(limit->place, fmt::format("{}", limit->value), false)));
    for (std::size_t a = 0; a < plan_.axes.size(); ++a)
      for (std::size_t c = 0; c < plan_.axes[a].columns.size(); ++c)
        list.push_back(
            make_setting(plan_.axes[a].columns[c].key, plan_.axes[a].rows[parts.rows[a]][c]));
    if (!plan_.solvers.empty()) {
      const Name& solver = plan_.solvers[parts.solver];
      list.push_back(
          make_setting({"solver.name", solver.place}, scalar(solver.place, solver.value, false)));
    }
    return list;
  }

  /// The common starting solution of all items. Nothing, with an error, if it is invalid.
  std::optional<ManifestStart> start() {
    const std::filesystem::path& file = plan_.start_file->value;
    constexpr std::string_view kKeys[] = {"iterations"};
    ManifestStart start;
    if (file.extension() == ".json") {
      const auto document =
          load_document(file, kSolutionDocument, kKeys, plan_.start_file->place, out_);
      if (!document) return std::nullopt;
      if (const auto found = document->find("iterations");
          found != document->end() && found->is_number_integer())
        start.iterations = found->get<int>();
    }
    start.file = {relative_path(std::filesystem::absolute(file), run_),
                  hash_of_file(file).value_or("")};
    return start;
  }

  /// The findings from building an item.
  struct Tried {
    InputFiles files;
    std::string shape;         ///< of the solved problem
    std::string settled = {};  ///< its id with formulas evaluated to numbers
  };

  /// Nothing, with errors, if the item cannot be built.
  std::optional<Tried> try_item(int problem, const std::vector<Setting>& list,
                                Diagnostics& out) const {
    const ProblemFamily& family = *families_[problem];
    if (plan_.command == BatchCommand::kMpc) {
      const auto loop = family.build_loop(list, out);
      if (!loop) return std::nullopt;
      if (const MpcSpec& mpc = *loop->built.facts().mpc; mpc.stop_when.empty())
        out.warning(mpc.place, kNothingStopsALoop, kHowToStopALoop);
      return Tried{input_files(*loop), {}};
    }
    const auto instance = family.build(list, out);
    if (!instance || usable_solvers(*instance, out).empty()) return std::nullopt;
    if (plan_.start_file && !family.build(list, out, plan_.start_file)) return std::nullopt;
    return Tried{input_files(*instance), shape_of(*instance->problem)};
  }

  bool build(std::size_t first, std::size_t last, Manifest& manifest) {
    std::vector<Diagnostics> texts(last - first);
    std::vector<Tried> tried(last - first);
    tbb::parallel_for(first, last, [&](std::size_t i) {
      const Parts p = parts(i);
      Diagnostics own = families_[p.problem]->texts();
      const std::size_t before = own.list().size();
      const std::vector<Setting> list = settings(p);
      auto result = try_item(p.problem, list, own);
      if (own.list().size() > before) texts[i - first] = std::move(own);
      if (!result) return;
      ManifestItem& item = manifest.items[i];
      item = {.id = item_id(manifest, p.problem, list, result->files), .problem = p.problem};
      for (const Setting& setting : list) item.settings.push_back(setting.text);
      const auto settled = settled_settings(families_[p.problem]->document(), list);
      result->settled = item_id(manifest, p.problem, settled, result->files);
      // The values of the axes are followed by the solver, if the plan names any.
      auto value = settled.end() - (plan_.solvers.empty() ? 0 : 1) -
                   static_cast<std::ptrdiff_t>(manifest.columns.size());
      for (std::size_t c = 0; c < manifest.columns.size(); ++c)
        item.values.push_back(value_text((value++)->value));
      tried[i - first] = *std::move(result);
    });
    for (std::size_t i = first; i < last; ++i) {
      if (texts[i - first].has_errors()) {
        report(i, texts[i - first]);
        return false;
      }
      warnings_.add(i, texts[i - first], known(i));
      remember(manifest.items[i].problem, tried[i - first]);
    }
    return true;
  }

  /// Number of diagnostics before an item was built.
  std::size_t known(std::size_t item) const {
    return families_[parts(item).problem]->texts().list().size();
  }

  /// Stores the properties of an item for later items and the manifest.
  void remember(int problem, const Tried& item) {
    settled_.push_back(item.settled);
    shapes_.push_back(
        numbers_.try_emplace(item.shape, static_cast<int>(numbers_.size())).first->second);
    const InputFiles base = input_files(families_[problem]->base());
    for (const auto* list : {&item.files.robots, &item.files.data})
      for (const InputFile& file : *list)
        if (!has(base, file.file))
          files_.try_emplace(std::filesystem::absolute(file.file).string(), file.sha256);
  }

  static bool has(const InputFiles& files, const std::string& name) {
    const auto is_named = [&](const InputFile& file) { return file.file == name; };
    return std::any_of(files.robots.begin(), files.robots.end(), is_named) ||
           std::any_of(files.data.begin(), files.data.end(), is_named);
  }

  /// Place of an item's values in a table; empty if no axis uses a table.
  Place row_of_table(const Parts& parts) const {
    for (std::size_t a = 0; a < plan_.axes.size(); ++a) {
      const Axis& axis = plan_.axes[a];
      const Mark& mark = axis.rows[parts.rows[a]].front().mark;
      if (mark.source != axis.name.place.mark.source) return {mark, axis.name.place.path};
    }
    return {};
  }

  void report(std::size_t item, const Diagnostics& own) {
    const Parts p = parts(item);
    std::string words;
    for (const Setting& setting : settings(p)) words += (words.empty() ? "" : ", ") + setting.text;
    adopt(own, known(item));
    out_.note(row_of_table(p), fmt::format("this is item {} of {}, of '{}'{}", item + 1,
                                           plan_.items(), plan_.problems[p.problem].value.string(),
                                           words.empty() ? "" : " with " + words));
  }

  /// Names the files of two items, if they differ.
  std::string files_of(const Parts& a, const Parts& b) const {
    if (a.problem == b.problem) return {};
    return fmt::format(": '{}' and '{}'", plan_.problems[a.problem].value.string(),
                       plan_.problems[b.problem].value.string());
  }

  bool all_differ() {
    std::unordered_map<std::string, std::size_t> first;
    for (std::size_t i = 0; i < settled_.size(); ++i) {
      const auto [other, fresh] = first.try_emplace(settled_[i], i);
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
  ItemWarnings warnings_;
  std::unordered_map<std::string, int> numbers_;  ///< indices of shapes
  std::vector<int> shapes_;                       ///< by item
  std::vector<std::string> settled_;              ///< Tried::settled by item
  std::map<std::string, std::string> files_;      ///< files named by settings, with their hashes
};

}  // namespace

std::optional<Manifest> expand_plan(const BatchPlan& plan, const std::filesystem::path& run,
                                    Diagnostics& out) {
  return Expansion(plan, run, out).run();
}

}  // namespace conddp
