#include "batch/plan/manifest.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "conddp_version.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "spatial/lane.hpp"

namespace conddp {
namespace {

constexpr const char* kCommandNames[] = {"solve", "mpc"};
constexpr const char* kKeptNames[] = {"all", "converged", "none"};
constexpr const char* kWarmStartNames[] = {"none", "neighbour", "file"};
constexpr std::string_view kSolverSetting = "solver.name=";
constexpr std::size_t kIdDigits = 16;

std::string dump(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string hashes_of(const InputFiles& files) {
  std::string hashes;
  for (const InputFile& file : files.robots) hashes += file.sha256 + '\n';
  for (const InputFile& file : files.data) hashes += file.sha256 + '\n';
  return hashes;
}

/// Text of a file's loop beyond the problem of its controller. It consists of the gait cycles for
/// the whole time, commands, which do not appear in these phases, and files of the plant. Empty if
/// the file alone does not define a loop.
std::string loop_text(const ProblemFamily& family) {
  Diagnostics unused = family.texts();
  const auto task = family.build_loop({}, unused);
  if (!task) return {};
  std::string text = dump(expand_problem(task->built)) + '\n';
  for (const GaitCommand& command : task->built.facts().mpc->commands)
    text += fmt::format("{} {} {} {}\n", command.at.value, command.x, command.y, command.turn);
  return text + hashes_of(input_files(*task));
}

/// The index of a word; the last index for an unknown word.
std::size_t index_of(const std::string& word, std::span<const char* const> words) {
  const auto found = std::find(words.begin(), words.end(), word);
  return std::min(words.size() - 1, static_cast<std::size_t>(found - words.begin()));
}

ManifestFile file_of(const OrderedJson& json) { return {json.at("file"), json.at("sha256")}; }

OrderedJson json_of(const ManifestFile& file) {
  return {{"file", file.file}, {"sha256", file.sha256}};
}

/// The head of a manifest; nothing if its numbers are inconsistent. Throws nlohmann::json
/// exceptions if it is malformed.
std::optional<Manifest> parse_head(const std::string& line) {
  const OrderedJson json = OrderedJson::parse(line);
  Manifest manifest{.name = json.at("name")};
  if (json.at("command") == kCommandNames[1]) manifest.command = BatchCommand::kMpc;
  for (const OrderedJson& problem : json.at("problems"))
    manifest.problems.push_back({problem.at("file"), problem.at("identity")});
  for (const OrderedJson& column : json.at("columns"))
    manifest.columns.push_back({column.at("name"), column.at("key")});
  const OrderedJson& limits = json.at("limits");
  manifest.limits = {limits.at("max_time_s"), limits.at("max_memory_mb"), limits.at("retries")};
  manifest.keep =
      static_cast<KeptSolutions>(index_of(json.at("keep").get<std::string>(), kKeptNames));
  manifest.warm_start =
      static_cast<WarmStart>(index_of(json.at("warm_start").get<std::string>(), kWarmStartNames));
  if (manifest.warm_start == WarmStart::kFile)
    manifest.start =
        ManifestStart{file_of(json.at("start")), json.at("start").at("iterations").get<int>()};
  for (const OrderedJson& file : json.at("files")) manifest.files.push_back(file_of(file));
  manifest.solvers = json.at("solvers");
  manifest.shards = json.at("shards");
  manifest.build = json.at("build");
  const auto items = json.at("items").get<long long>();
  if (!manifest.build.is_object() || manifest.solvers < 1 || manifest.shards < 1 ||
      manifest.problems.empty() || items < 0 || items > kMostItems ||
      items % (static_cast<long long>(manifest.solvers) *
               static_cast<long long>(manifest.problems.size())) !=
          0)
    return std::nullopt;
  manifest.items.resize(static_cast<std::size_t>(items));
  return manifest;
}

}  // namespace

OrderedJson build_json() {
  const BuildInfo& info = build_info();
  return {{"version", info.version},       {"revision", info.revision},
          {"modified", info.dirty},        {"compiler", info.compiler},
          {"build_type", info.build_type}, {"instruction_set", info.instruction_set},
          {"lane_width", kLaneWidth}};
}

std::string batch_identity(const ProblemFamily& family, BatchCommand command) {
  const BuiltProblem& base = family.base();
  std::string all = dump(expand_problem(base)) + '\n' + hashes_of(input_files(base));
  if (command == BatchCommand::kMpc) all += loop_text(family);
  return sha256(all);
}

std::optional<std::string> hash_of_file(const std::filesystem::path& file) {
  const TextFile bytes = read_text_file(file, std::numeric_limits<std::size_t>::max() - 1);
  return bytes.defect.empty() ? std::optional(sha256(bytes.text)) : std::nullopt;
}

std::string item_id(const Manifest& manifest, int problem, const std::vector<Setting>& settings,
                    const InputFiles& files) {
  std::vector<std::string> lines;
  for (const Setting& setting : settings)
    lines.push_back(setting.key.value + '=' + canonical_value(setting.value) + '\n');
  std::sort(lines.begin(), lines.end());
  std::string all = manifest.problems[problem].identity + '\n';
  if (manifest.start) all += manifest.start->file.sha256 + '\n';
  for (const std::string& line : lines) all += line;
  return sha256(all + hashes_of(files)).substr(0, kIdDigits);
}

std::string solver_of(const ManifestItem& item) {
  for (const std::string& setting : item.settings)
    if (setting.starts_with(kSolverSetting)) return setting.substr(kSolverSetting.size());
  return {};
}

std::string manifest_head(const Manifest& manifest) {
  OrderedJson problems = OrderedJson::array(), columns = OrderedJson::array(),
              files = OrderedJson::array();
  for (const ManifestProblem& problem : manifest.problems)
    problems.push_back({{"file", problem.file}, {"identity", problem.identity}});
  for (const ManifestColumn& column : manifest.columns)
    columns.push_back({{"name", column.name}, {"key", column.key}});
  for (const ManifestFile& file : manifest.files) files.push_back(json_of(file));
  OrderedJson start;
  if (manifest.start) {
    start = json_of(manifest.start->file);
    start["iterations"] = manifest.start->iterations;
  }
  return dump({{"format", kManifestFormat},
               {"name", manifest.name},
               {"command", kCommandNames[static_cast<int>(manifest.command)]},
               {"items", manifest.items.size()},
               {"problems", std::move(problems)},
               {"columns", std::move(columns)},
               {"limits",
                {{"max_time_s", manifest.limits.max_time_s},
                 {"max_memory_mb", manifest.limits.max_memory_mb},
                 {"retries", manifest.limits.retries}}},
               {"keep", kKeptNames[static_cast<int>(manifest.keep)]},
               {"warm_start", kWarmStartNames[static_cast<int>(manifest.warm_start)]},
               {"start", std::move(start)},
               {"files", std::move(files)},
               {"solvers", manifest.solvers},
               {"shards", manifest.shards},
               {"build", manifest.build}});
}

std::string manifest_line(const ManifestItem& item) {
  std::string values;
  for (const std::string& value : item.values) values += (values.empty() ? "" : ",") + value;
  const std::string parent =
      item.parent.empty() ? std::string() : fmt::format(R"(,"parent":"{}")", item.parent);
  return fmt::format(R"({{"id":"{}","problem":{},"settings":{},"values":[{}]{}}})", item.id,
                     item.problem, dump(item.settings), values, parent);
}

std::optional<ManifestItem> parse_manifest_line(std::string_view line) {
  try {
    const OrderedJson json = OrderedJson::parse(line);
    ManifestItem item{
        .id = json.at("id"), .problem = json.at("problem"), .settings = json.at("settings")};
    for (const OrderedJson& value : json.at("values")) item.values.push_back(dump(value));
    item.parent = json.value("parent", std::string());
    return item;
  } catch (const OrderedJson::exception&) {
    return std::nullopt;
  }
}

namespace {

/// Parses an item from a line of a file. A line without a checksum comes from an older version or
/// was written by hand.
std::optional<ManifestItem> parse_stored_line(const std::string& line) {
  return parse_manifest_line(has_sum(line) ? without_sum(line) : line);
}

bool is_item_of(const Manifest& manifest, const ManifestItem& item) {
  return item.problem >= 0 && item.problem < static_cast<int>(manifest.problems.size()) &&
         item.values.size() == manifest.columns.size();
}

}  // namespace

std::optional<Manifest> load_manifest(const std::filesystem::path& run, bool with_items,
                                      Diagnostics& out) {
  const std::filesystem::path file = run / kManifestFile;
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  const auto fail = [&](int number, std::string message, std::string hint = {}) {
    out.add({.file = file.string(),
             .line = number,
             .column = number > 0 ? 1 : 0,
             .message = std::move(message),
             .hint = std::move(hint)});
    return std::nullopt;
  };
  if (std::error_code error; std::filesystem::is_regular_file(run, error)) {
    out.error({}, fmt::format("'{}' is a file, not the folder of a run", run.string()),
              "the run of a plan is in the folder that -o named, or in out/ and the plan's name");
    return std::nullopt;
  }
  if (!std::getline(stream, line))
    return fail(0, fmt::format("'{}' is not the folder of a batch", run.string()),
                "'conddp batch plan PLAN.yaml -o FOLDER' makes one");
  if (!line.starts_with(fmt::format(R"({{"format":"{}")", kManifestFormat)))
    return fail(1, fmt::format("this is not a manifest of the format {}", kManifestFormat),
                "make the plan again with this version");
  std::optional<Manifest> manifest;
  try {
    manifest = parse_head(line);
  } catch (const OrderedJson::exception&) {
  }
  if (!manifest) return fail(1, "the head of the manifest is damaged", "make the plan again");
  if (!with_items) return manifest;
  int number = 1;
  for (ManifestItem& item : manifest->items) {
    ++number;
    auto parsed = std::getline(stream, line) ? parse_stored_line(line) : std::nullopt;
    if (!parsed || !is_item_of(*manifest, *parsed))
      return fail(number, "the manifest is damaged: this line is not an item",
                  "make the plan again");
    item = *std::move(parsed);
  }
  return manifest;
}
namespace {

std::string behind(const std::string& path, const std::string& step) {
  return path.empty() ? step : path + '.' + step;
}

void add_leaves(const OrderedJson& value, const std::string& path, std::vector<ValueLeaf>& leaves) {
  if (!value.is_structured() || value.empty()) {
    leaves.push_back({path, value});
    return;
  }
  for (const auto& [step, part] : value.items()) add_leaves(part, behind(path, step), leaves);
}

}  // namespace

std::vector<ValueLeaf> leaves_of(const std::string& text) {
  std::vector<ValueLeaf> leaves;
  add_leaves(OrderedJson::parse(text), {}, leaves);
  return leaves;
}

}  // namespace conddp
