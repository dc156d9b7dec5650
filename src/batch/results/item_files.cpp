#include "batch/results/item_files.hpp"

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/json_text.hpp"
#include "base/json/relative_paths.hpp"
#include "batch/plan/run_folder.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/stored_trajectory.hpp"
#include "problem_file/build/build_problem.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "problem_file/yaml/yaml_text.hpp"

namespace conddp {
namespace {

/// Whether this is the item that was solved; the files that its settings name have a part in it.
bool is_item(const ManifestItem& item, const Manifest& manifest, const ProblemInstance& instance,
             Diagnostics& out) {
  std::vector<Setting> settings;
  for (const std::string& text : item.settings)
    if (auto setting = parse_setting(text, out)) settings.push_back(*std::move(setting));
  if (item_id(manifest.problems[item.problem].identity, settings, instance) == item.id) return true;
  out.error({},
            fmt::format("a file that item {} reads has changed since the plan was made", item.id),
            "make the plan again, in another folder");
  return false;
}

}  // namespace

std::optional<ShownItem> load_item(const std::filesystem::path& run, const Manifest& manifest,
                                   const ManifestItem& item, const StoredResult* stored,
                                   Diagnostics& out) {
  if (!is_as_planned(manifest, item.problem, run, out)) return std::nullopt;
  ShownItem shown{.file = problem_of_run(manifest, item.problem, run)};
  auto spec = read_problem(shown.file, item.settings, out);
  if (!spec) return std::nullopt;
  ProblemInstance instance{std::make_unique<const ProblemSpec>(*std::move(spec)), {}};
  auto built = build_problem(*instance.spec, {}, out);
  if (!built) return std::nullopt;
  instance.built = *std::move(built);
  if (!is_item(item, manifest, instance, out)) return std::nullopt;
  shown.spec = std::move(instance.spec);
  shown.built = std::move(instance.built);
  if (stored == nullptr || stored->result.solution_bytes == 0) return shown;
  shown.document = load_document(*stored);
  if (shown.document.is_null()) {
    out.error({}, fmt::format("the solution of {} is damaged", item.id),
              "'conddp batch retry RUN failed' solves it again");
    return std::nullopt;
  }
  shown.document["problem"]["file"] = shown.file.string();
  return shown;
}

std::vector<std::filesystem::path> write_item(const ShownItem& item,
                                              const std::filesystem::path& folder) {
  OrderedJson problem = expand_problem(*item.spec, item.built);
  make_paths_relative(problem, item.file.parent_path(), folder);
  std::vector<std::pair<std::filesystem::path, std::string>> texts = {
      {folder / "problem.yaml", yaml_text(problem)}};
  if (!item.document.is_null()) {
    const Trajectory trajectory = stored_trajectory(item.document, *item.built.problem);
    const ContactForces forces = contact_forces(*item.spec, *item.built.problem, trajectory);
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
