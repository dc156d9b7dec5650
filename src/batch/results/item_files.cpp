#include "batch/results/item_files.hpp"

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/ordered_json.hpp"
#include "base/json/relative_paths.hpp"
#include "batch/plan/run_folder.hpp"
#include "output/mpc/loop_files.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/yaml/yaml_text.hpp"

namespace conddp {
namespace {

/// True if the item is unchanged since the plan was made, including the files that its settings
/// name.
bool is_item(const ManifestItem& item, const Manifest& manifest, const InputFiles& inputs,
             Diagnostics& out) {
  const std::vector<Setting> settings = parse_settings(item.settings, out);
  if (item_id(manifest, item.problem, settings, inputs) == item.id) return true;
  out.error({},
            fmt::format("a file that item {} reads has changed since the plan was made", item.id),
            "make the plan again, in another folder");
  return false;
}

/// The problem.yaml of an item in a folder.
std::string problem_yaml(const BuiltProblem& built, const std::filesystem::path& folder) {
  OrderedJson problem = expand_problem(built);
  make_paths_relative(problem, built.facts().file.parent_path(), folder);
  return yaml_text(problem);
}

}  // namespace

std::optional<ShownItem> load_item(const std::filesystem::path& run, const Manifest& manifest,
                                   const ManifestItem& item, const StoredResult* stored,
                                   Diagnostics& out) {
  if (!is_as_planned(manifest, item.problem, run, out)) return std::nullopt;
  ShownItem shown;
  const bool has_solution = stored != nullptr && stored->result.solution_bytes > 0;
  if (has_solution) shown.document = load_document(*stored);
  // The answer of a file with `mesh` belongs to a finer grid.
  const bool is_refined = shown.document.contains("mesh");
  const auto settings =
      is_refined ? shown.document.at("problem").at("overrides").get<std::vector<std::string>>()
                 : item.settings;
  auto built = build_problem(
      read_problem(problem_of_run(manifest, item.problem, run), settings, out), {}, out);
  if (!built) return std::nullopt;
  shown.built = *std::move(built);
  if (!is_item(item, manifest, input_files(shown.built), out)) return std::nullopt;
  if (!has_solution) return shown;
  if (shown.document.is_null()) {
    out.error({}, fmt::format("the solution of {} is damaged", item.id),
              "'conddp batch retry RUN failed' solves it again");
    return std::nullopt;
  }
  shown.document["problem"]["file"] = shown.built.facts().file.string();
  return shown;
}

std::optional<WrittenLoop> write_loop_item(const std::filesystem::path& run,
                                           const Manifest& manifest, const ManifestItem& item,
                                           const std::filesystem::path& folder, Diagnostics& out) {
  if (!is_as_planned(manifest, item.problem, run, out)) return std::nullopt;
  const std::filesystem::path file = problem_of_run(manifest, item.problem, run);
  const auto task = build_loop(read_problem(file, item.settings, out), {}, out);
  if (!task || !is_item(item, manifest, input_files(*task), out)) return std::nullopt;
  warn_of_lost_gait(task->built, out);
  const ClosedLoopResult result = run_loop(*task);
  create_folder(folder);
  WrittenLoop written{.end = result.end, .paths = {folder / "problem.yaml"}};
  AtomicFiles files;
  files.add(written.paths.front(), problem_yaml(task->built, folder));
  for (std::filesystem::path& path : add_loop({*task, result, item.settings}, folder, files))
    written.paths.push_back(std::move(path));
  files.commit();
  return written;
}

std::vector<std::filesystem::path> write_item(const ShownItem& item,
                                              const std::filesystem::path& folder) {
  std::vector<std::pair<std::filesystem::path, std::string>> texts = {
      {folder / "problem.yaml", problem_yaml(item.built, folder)}};
  if (!item.document.is_null()) {
    const Trajectory trajectory = stored_trajectory(item.document, *item.built.problem);
    const ContactForces forces =
        contact_forces(item.built, NodeValues(*item.built.problem, trajectory));
    texts.emplace_back(folder / "solution.json", json_text(item.document));
    texts.emplace_back(folder / "trajectory.csv", trajectory_csv(item.built, trajectory, forces));
    texts.emplace_back(folder / "iterations.csv", iterations_csv(item.document.at("log")));
  }
  create_folder(folder);
  AtomicFiles files;
  std::vector<std::filesystem::path> paths;
  for (const auto& [path, text] : texts) {
    files.add(path, text);
    paths.push_back(path);
  }
  files.commit();
  return paths;
}

}  // namespace conddp
