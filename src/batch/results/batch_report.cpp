#include "batch/results/batch_report.hpp"

#include <algorithm>
#include <functional>
#include <span>

#include "base/json/ordered_json.hpp"
#include "batch/plan/spread.hpp"

namespace conddp {
namespace {

/// Drawing limits of a page: rows of items, trajectories, and numbers in trajectories.
constexpr std::size_t kMostRows = 20'000, kMostTrajectories = 60, kMostNumbers = 150'000;
/// Number of nodes drawn per trajectory.
constexpr std::size_t kMostNodes = 100;

std::size_t step_of(std::size_t count, std::size_t most) {
  return std::max<std::size_t>(1, (count + most - 1) / most);
}

/// Reads the manifest entries and results of items.
class Items {
 public:
  Items(const Manifest& manifest, const StoredResults& results)
      : manifest_(manifest), results_(results) {}

  std::size_t count() const { return manifest_.items.size(); }
  const StoredResult* stored(std::size_t item) const {
    return find_result(results_, manifest_.items[item]);
  }
  bool is_solved(std::size_t item) const {
    const StoredResult* result = stored(item);
    return result != nullptr && result->result.success;
  }
  std::string status(std::size_t item) const {
    const StoredResult* result = stored(item);
    return result == nullptr ? kUnfinished : result->result.status;
  }
  /// Null if unknown.
  OrderedJson figure(std::size_t item, const char* key) const {
    const StoredResult* result = stored(item);
    return result == nullptr || !result->result.answer.is_object()
               ? OrderedJson()
               : result->result.answer.value(key, OrderedJson());
  }
  OrderedJson time(std::size_t item) const {
    const StoredResult* result = stored(item);
    return result == nullptr ? OrderedJson() : result->result.times.value("all", OrderedJson());
  }

  /// Names of the properties that distinguish items: the columns of the plan, problems and solvers.
  OrderedJson columns() const {
    OrderedJson list = OrderedJson::array();
    for (const ManifestColumn& column : manifest_.columns)
      list.push_back({{"name", column.name}, {"key", column.key}});
    if (has_problems()) list.push_back({{"name", "problem"}, {"key", nullptr}});
    if (has_solvers()) list.push_back({{"name", "solver"}, {"key", "solver.name"}});
    return list;
  }
  /// Values of these properties: numbers and texts.
  OrderedJson values(std::size_t item) const {
    const ManifestItem& of = manifest_.items[item];
    OrderedJson list = OrderedJson::array();
    for (const std::string& text : of.values) {
      OrderedJson value = OrderedJson::parse(text);
      list.push_back(value.is_number() || value.is_string() ? std::move(value) : OrderedJson(text));
    }
    if (has_problems()) list.push_back(manifest_.problems[of.problem].file);
    if (has_solvers()) list.push_back(solver_of(of));
    return list;
  }

 private:
  bool has_problems() const { return manifest_.problems.size() > 1; }
  bool has_solvers() const { return manifest_.solvers > 1; }

  const Manifest& manifest_;
  const StoredResults& results_;
};

/// The first of some items, sorted by a figure; items without it are omitted.
template <class Figure, class Before>
std::vector<std::size_t> foremost(const std::vector<std::size_t>& items, Figure figure,
                                  Before before, std::size_t most) {
  std::vector<std::pair<double, std::size_t>> known;
  for (const std::size_t item : items)
    if (const OrderedJson value = figure(item); value.is_number())
      known.emplace_back(value.template get<double>(), item);
  std::stable_sort(known.begin(), known.end(),
                   [&](const auto& a, const auto& b) { return before(a.first, b.first); });
  known.resize(std::min(most, known.size()));
  std::vector<std::size_t> list;
  for (const auto& [value, item] : known) list.push_back(item);
  return list;
}

OrderedJson counts_json(const Items& items) {
  std::map<std::string, std::size_t> counts;
  for (std::size_t i = 0; i < items.count(); ++i) ++counts[items.status(i)];
  OrderedJson list = OrderedJson::array();
  for (const auto& [status, count] : counts) list.push_back({{"status", status}, {"count", count}});
  return list;
}

/// A figure of items on the page.
struct Figure {
  const char* key;  ///< key in the answer; "wall_s": the item's wall time
  const char* title;
  const char* unit;
};
constexpr Figure kWallTime{"wall_s", "time", "s"};
constexpr Figure kSolveFigures[] = {
    {"cost", "cost", ""}, {"iterations", "iterations", ""}, kWallTime};
constexpr Figure kLoopFigures[] = {{"time_s", "time until the end", "s"},
                                   {"planned", "share of ticks planned", ""},
                                   {"fallback", "share of ticks under the fallback", ""},
                                   {"cost", "cost", ""},
                                   {"violation", "violation", ""},
                                   kWallTime};

std::span<const Figure> figures_of(const Manifest& manifest) {
  return manifest.command == BatchCommand::kMpc ? std::span<const Figure>(kLoopFigures)
                                                : std::span<const Figure>(kSolveFigures);
}

OrderedJson figure_of(const Items& items, std::size_t item, const Figure& figure) {
  return figure.key == std::string_view(kWallTime.key) ? items.time(item)
                                                       : items.figure(item, figure.key);
}

OrderedJson figures_json(const Manifest& manifest) {
  OrderedJson list = OrderedJson::array();
  for (const Figure& figure : figures_of(manifest))
    list.push_back({{"key", figure.key}, {"title", figure.title}, {"unit", figure.unit}});
  return list;
}

/// `solved` is 1 or 0; null without a result.
OrderedJson rows_json(const Items& items, const Manifest& manifest, std::size_t every) {
  OrderedJson rows = {{"item", OrderedJson::array()},
                      {"solved", OrderedJson::array()},
                      {"values", OrderedJson::array()}};
  for (std::size_t c = 0; c < items.columns().size(); ++c)
    rows["values"].push_back(OrderedJson::array());
  for (const std::size_t i : spread_over(items.count(), (items.count() + every - 1) / every)) {
    rows["item"].push_back(i + 1);
    rows["solved"].push_back(items.stored(i) == nullptr ? OrderedJson()
                                                        : OrderedJson(items.is_solved(i) ? 1 : 0));
    for (const Figure& figure : figures_of(manifest))
      rows[figure.key].push_back(figure_of(items, i, figure));
    const OrderedJson values = items.values(i);
    for (std::size_t c = 0; c < values.size(); ++c) rows["values"][c].push_back(values[c]);
  }
  return rows;
}

OrderedJson lists_json(const Items& items, const Manifest& manifest,
                       const std::vector<StandOut>& stand_out, const ItemLinks& links) {
  OrderedJson lists = OrderedJson::array();
  for (const StandOut& list : stand_out) {
    OrderedJson rows = OrderedJson::array();
    for (const std::size_t i : list.items) {
      const auto files = links.find(i);
      OrderedJson figures = OrderedJson::array();
      for (const Figure& figure : figures_of(manifest))
        figures.push_back(figure_of(items, i, figure));
      rows.push_back(
          {{"item", i + 1},
           {"id", manifest.items[i].id},
           {"status", items.status(i)},
           {"figures", std::move(figures)},
           {"message", items.is_solved(i) ? OrderedJson() : items.figure(i, "message")},
           {"values", items.values(i)},
           {"files", files == links.end() ? std::vector<std::string>() : files->second}});
    }
    lists.push_back({{"title", list.title}, {"items", std::move(rows)}});
  }
  return lists;
}

/// The columns of a trajectory at a subset of its nodes, including the last.
OrderedJson line_json(const Items& items, std::size_t item, const OrderedJson& trajectory) {
  const OrderedJson& x = trajectory.at("x");
  const std::size_t step = step_of(x.size(), kMostNodes), columns = x.at(0).size();
  OrderedJson line = {{"item", item + 1},
                      {"cost", items.figure(item, "cost")},
                      {"t", OrderedJson::array()},
                      {"values", OrderedJson::array()}};
  for (std::size_t c = 0; c < columns; ++c) line["values"].push_back(OrderedJson::array());
  for (std::size_t next = 0; next < x.size() - 1 + step; next += step) {
    const std::size_t k = std::min(next, x.size() - 1);
    line["t"].push_back(trajectory.at("t").at(k));
    for (std::size_t c = 0; c < columns; ++c) {
      const OrderedJson& number = x.at(k).at(c);
      line["values"][c].push_back(number.is_number() ? eight_digits(number.get<double>())
                                                     : OrderedJson());
    }
  }
  return line;
}

/// Trajectories of items with a stored solution, spread over all, if their columns match those of
/// the first one.
OrderedJson trajectories_json(const Items& items) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < items.count(); ++i)
    if (const StoredResult* stored = items.stored(i); stored && stored->result.solution_bytes > 0)
      kept.push_back(i);
  OrderedJson json;
  std::vector<std::size_t> chosen = spread_over(kept.size(), kMostTrajectories);
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    const std::size_t item = kept[chosen[n]];
    const OrderedJson document = load_document(*items.stored(item));
    if (document.is_null()) continue;
    const OrderedJson& trajectory = document.at("trajectory");
    const OrderedJson& columns = trajectory.at("columns").at("x");
    if (json.is_null()) {
      const std::size_t numbers =
          columns.size() * std::min(trajectory.at("x").size(), kMostNodes + 1);
      chosen = spread_over(
          kept.size(), std::clamp<std::size_t>(kMostNumbers / std::max<std::size_t>(1, numbers), 1,
                                               kMostTrajectories));
      json = {{"columns", columns},
              {"units", trajectory.at("units").at("x")},
              {"lines", OrderedJson::array()}};
    }
    if (columns == json["columns"]) json["lines"].push_back(line_json(items, item, trajectory));
  }
  return json;
}

}  // namespace

std::vector<StandOut> items_that_stand_out(const Manifest& manifest, const StoredResults& results,
                                           std::size_t most) {
  const Items items(manifest, results);
  std::vector<std::size_t> finished, solved, failed;
  for (std::size_t i = 0; i < items.count(); ++i) {
    if (items.stored(i) == nullptr) continue;
    finished.push_back(i);
    (items.is_solved(i) ? solved : failed).push_back(i);
  }
  failed.resize(std::min(most, failed.size()));
  const auto cost = [&](std::size_t i) { return items.figure(i, "cost"); };
  const auto time = [&](std::size_t i) { return items.time(i); };
  const bool loops = manifest.command == BatchCommand::kMpc;
  return {{loops ? "Did not survive" : "Not solved", failed},
          {"Slowest", foremost(finished, time, std::greater<>(), most)},
          {"Least cost", foremost(solved, cost, std::less<>(), most)},
          {"Greatest cost", foremost(solved, cost, std::greater<>(), most)}};
}

OrderedJson batch_report(const Manifest& manifest, const StoredResults& results,
                         const std::vector<StandOut>& stand_out, const ItemLinks& links) {
  const Items items(manifest, results);
  const std::size_t every = step_of(items.count(), kMostRows);
  return {{"name", manifest.name},
          {"items", items.count()},
          {"success_word", success_word(manifest.command)},
          {"figures", figures_json(manifest)},
          {"solved", batch_status(manifest, results).solved},
          {"by_status", counts_json(items)},
          {"columns", items.columns()},
          {"every", every},
          {"rows", rows_json(items, manifest, every)},
          {"lists", lists_json(items, manifest, stand_out, links)},
          {"trajectories", trajectories_json(items)}};
}

}  // namespace conddp
