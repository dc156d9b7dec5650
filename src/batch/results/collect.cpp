#include "batch/results/collect.hpp"

#include <algorithm>

#include "base/text/csv_line.hpp"
#include "mpc/closed_loop.hpp"
#include "solvers/common/status.hpp"

namespace conddp {
namespace {

/// A text as a CSV cell, protected from evaluation as a formula and quoted if necessary.
std::string cell(std::string text) {
  if (begins_formula(text)) text.insert(0, 1, '_');
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

/// A number or text of a document; empty if null or missing.
std::string cell(const OrderedJson& json) {
  if (json.is_null()) return {};
  if (json.is_number()) return json.dump();
  return json.is_string() ? cell(json.get<std::string>()) : cell(json.dump());
}

std::string cell_of(const OrderedJson& json, const char* key) {
  const auto found = json.is_object() ? json.find(key) : json.end();
  return json.is_object() && found != json.end() ? cell(*found) : std::string();
}

void add_row(const std::vector<std::string>& cells, std::string& text) {
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i > 0 ? "," : "") + cells[i];
  text += '\n';
}

/// The names of all constraints, in order of appearance in the items.
std::vector<std::string> constraint_columns(const Manifest& manifest,
                                            const StoredResults& results) {
  std::vector<std::string> names;
  for (const ManifestItem& item : manifest.items) {
    const StoredResult* stored = find_result(results, item);
    if (stored == nullptr || !stored->result.answer.contains("constraints")) continue;
    for (const OrderedJson& constraint : stored->result.answer["constraints"])
      if (const std::string name = constraint.at("name");
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
  }
  return names;
}

constexpr const char* kResiduals[] = {"stationarity", "gap", "constraint", "complementarity"};

std::vector<std::string> answer_cells(const OrderedJson& answer,
                                      const std::vector<std::string>& constraints) {
  std::vector<std::string> cells = {cell_of(answer, "cost"), cell_of(answer, "iterations")};
  const OrderedJson residuals = answer.value("residuals", OrderedJson::object());
  for (const char* key : kResiduals) cells.push_back(cell_of(residuals, key));
  const OrderedJson violations = answer.value("constraints", OrderedJson::array());
  for (const std::string& name : constraints) {
    std::string& value = cells.emplace_back();
    for (const OrderedJson& violation : violations)
      if (violation.at("name") == name) value = cell_of(violation, "violation");
  }
  cells.push_back(cell_of(answer, "certificate"));
  cells.push_back(cell_of(answer, "message"));
  return cells;
}

/// True if a closed loop ended on its own.
bool is_end_of_loop(const ItemResult& result) {
  return result.status == to_string(LoopEnd::stopped) ||
         result.status == to_string(LoopEnd::diverged);
}

bool has_failed(const StoredResult& stored, FailureKind kind, BatchCommand command) {
  const ItemResult& result = stored.result;
  if (command == BatchCommand::kMpc && is_end_of_loop(result)) return false;
  if (kind == FailureKind::kAny) return !result.success || is_damaged(stored);
  return !result.success &&
         (result.status == to_string(SolveStatus::time_limit) || result.status == kKilled);
}

}  // namespace

const StoredResult* find_result(const StoredResults& results, const ManifestItem& item) {
  const auto found = results.find(item.id);
  return found == results.end() ? nullptr : &found->second;
}

std::vector<std::size_t> failed_items(const Manifest& manifest, const StoredResults& results,
                                      FailureKind kind) {
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {
    const StoredResult* stored = find_result(results, manifest.items[i]);
    if (stored != nullptr && has_failed(*stored, kind, manifest.command)) items.push_back(i);
  }
  return items;
}

const char* success_word(BatchCommand command) {
  return command == BatchCommand::kMpc ? "survived" : "solved";
}

BatchStatus batch_status(const Manifest& manifest, const StoredResults& results) {
  BatchStatus status{.items = manifest.items.size()};
  for (const ManifestItem& item : manifest.items) {
    const StoredResult* stored = find_result(results, item);
    if (stored == nullptr) {
      ++status.unfinished;
      continue;
    }
    status.solved += stored->result.success;
    ++status.by_status[stored->result.status];
    status.solve_s += stored->result.times.value("all", 0.0);
  }
  return status;
}

namespace {

std::vector<std::string> results_header(const Manifest& manifest,
                                        const std::vector<std::string>& constraints) {
  std::vector<std::string> header = {"item", "id", "problem"};
  for (const ManifestColumn& column : manifest.columns) header.push_back(cell(column.name));
  for (const char* name : {"solver", "status", success_word(manifest.command)})
    header.emplace_back(name);
  if (manifest.command == BatchCommand::kMpc) {
    header.insert(header.end(), std::begin(kLoopColumns), std::end(kLoopColumns));
    return header;
  }
  if (manifest.warm_start != WarmStart::kNone) header.emplace_back("warm_start");
  for (const char* name : {"cost", "iterations"}) header.emplace_back(name);
  for (const char* name : kResiduals) header.emplace_back(name);
  for (const std::string& name : constraints) header.push_back(cell("violation/" + name));
  header.insert(header.end(), {"certificate", "message"});
  return header;
}

/// The cells of an answer, in the order of the header.
std::vector<std::string> cells_of(const Manifest& manifest, const OrderedJson& answer,
                                  const std::vector<std::string>& constraints) {
  if (manifest.command == BatchCommand::kSolve) return answer_cells(answer, constraints);
  std::vector<std::string> cells;
  for (const std::string_view column : kLoopColumns)
    cells.push_back(cell_of(answer, std::string(column).c_str()));
  return cells;
}

/// The cells that describe an item and its variation, with or without an answer.
std::vector<std::string> item_cells(const Manifest& manifest, std::size_t index) {
  const ManifestItem& item = manifest.items[index];
  std::vector<std::string> cells = {std::to_string(index + 1), item.id,
                                    cell(manifest.problems[item.problem].file)};
  for (const std::string& value : item.values) cells.push_back(cell(OrderedJson::parse(value)));
  return cells;
}

}  // namespace

std::string results_csv(const Manifest& manifest, const StoredResults& results) {
  const std::vector<std::string> constraints = constraint_columns(manifest, results);
  const std::vector<std::string> header = results_header(manifest, constraints);
  std::string text;
  add_row(header, text);
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {
    std::vector<std::string> row = item_cells(manifest, i);
    const std::string planned_solver = cell(solver_of(manifest.items[i]));
    if (const StoredResult* stored = find_result(results, manifest.items[i])) {
      const ItemResult& result = stored->result;
      const std::string solver = cell_of(result.answer, "solver");
      row.insert(row.end(), {solver.empty() ? planned_solver : solver, result.status,
                             result.success ? "1" : "0"});
      if (manifest.warm_start != WarmStart::kNone)
        row.push_back(cell_of(result.answer, "warm_start"));
      for (std::string& value : cells_of(manifest, result.answer, constraints))
        row.push_back(std::move(value));
    } else {
      row.insert(row.end(), {planned_solver, kUnfinished});
      row.resize(header.size());
    }
    add_row(row, text);
  }
  return text;
}

std::string times_csv(const Manifest& manifest, const StoredResults& results) {
  std::string text = "item,id,attempt,build [s],solve [s],certificate [s],all [s]\n";
  for (std::size_t i = 0; i < manifest.items.size(); ++i)
    if (const StoredResult* stored = find_result(results, manifest.items[i])) {
      const OrderedJson& times = stored->result.times;
      add_row({std::to_string(i + 1), manifest.items[i].id, std::to_string(stored->result.attempt),
               cell_of(times, "build"), cell_of(times, "solve"), cell_of(times, "certificate"),
               cell_of(times, "all")},
              text);
    }
  return text;
}

}  // namespace conddp
