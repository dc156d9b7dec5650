#include "batch/plan/run_folder.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/check_sums.hpp"
#include "problem_file/read/read_problem.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPlanFile = "plan.yaml";

std::string manifest_text(const Manifest& manifest) {
  std::string text = manifest_head(manifest) + '\n';
  for (const ManifestItem& item : manifest.items) text += with_sum(manifest_line(item)) + '\n';
  return text;
}

bool has_text(const fs::path& file, const std::string& text) {
  std::ifstream stream(file, std::ios::binary);
  return stream && std::string{std::istreambuf_iterator<char>(stream), {}} == text;
}

/// The items of a plan and their solve settings, as text independent of the build and of the number
/// of shards.
std::string plan_text(Manifest manifest) {
  manifest.shards = 1;
  manifest.build = nullptr;
  return manifest_text(manifest);
}

std::string build_words(const OrderedJson& build) {
  const auto word = [&](const char* key) {
    const auto found = build.find(key);
    return found != build.end() && found->is_string() ? found->get<std::string>() : "?";
  };
  return fmt::format("{}, revision {}, {}, {}", word("version"), word("revision"),
                     word("build_type"), word("instruction_set"));
}

}  // namespace

void write_run_folder(const BatchPlan& plan, const Manifest& manifest, const fs::path& run,
                      Diagnostics& out) {
  const std::string text = manifest_text(manifest);
  if (has_text(run / kManifestFile, text)) return;
  std::error_code error;
  Diagnostics unused;
  const auto former = load_manifest(run, true, unused);
  if (fs::exists(run / "shards", error)) {
    if (!former || plan_text(*former) != plan_text(manifest))
      return out.error({}, fmt::format("'{}' has results of another plan", run.string()),
                       "choose another folder with -o, or remove that one");
    if (former->build != manifest.build)
      return out.error(
          {},
          fmt::format("'{}' has results of this plan by another build of conddp ({}; "
                      "this is {})",
                      run.string(), build_words(former->build), build_words(manifest.build)),
          "choose another folder with -o; 'conddp batch run RUN --any-build' mixes "
          "them");
  }
  // An edited plan keeps its name.
  if (former && former->name != manifest.name)
    return out.error(
        {}, fmt::format("'{}' is the run of another plan, '{}'", run.string(), former->name),
        "choose another folder with -o, or remove that one");
  if (!fs::exists(run / kManifestFile, error) && fs::exists(run / kPlanFile, error) &&
      !has_text(run / kPlanFile, plan.text))
    return out.error({}, fmt::format("'{}' has a plan.yaml that is not this plan", run.string()),
                     "choose another folder with -o: a copy of the plan goes into it");
  create_folder(run);
  AtomicFiles files;
  files.add(run / kManifestFile, text);
  files.add(run / kPlanFile, plan.text);
  files.commit();
}

bool is_as_planned(const Manifest& manifest, int problem, const fs::path& run, Diagnostics& out) {
  const fs::path file = problem_of_run(manifest, problem, run);
  Diagnostics own;  // the warnings were already reported with the plan
  const auto family = ProblemFamily::load(file, {}, own);
  if (!family) {
    std::error_code error;
    const bool is_lost = !fs::exists(file, error);
    for (Diagnostic d : own.list()) {
      d.source = -1;  // only known here
      if (is_lost && d.hint.empty())
        d.hint = "a run has the paths of its problems relative to its folder: move them together";
      out.add(std::move(d));
    }
    return false;
  }
  if (batch_identity(*family, manifest.command) == manifest.problems[problem].identity) return true;
  out.error({},
            fmt::format("'{}', or a file that it reads, has changed since the plan was made",
                        file.string()),
            "make the plan again, in another folder");
  return false;
}

namespace {

/// Reports the first file read by items that has changed.
void check_files(const Manifest& manifest, const fs::path& run, Diagnostics& out) {
  std::vector<ManifestFile> files = manifest.files;
  if (manifest.start) files.push_back(manifest.start->file);
  for (const ManifestFile& file : files) {
    const fs::path path = file_of_run(file, run);
    if (hash_of_file(path) == file.sha256) continue;
    return out.error(
        {},
        fmt::format("'{}', which items read, has changed since the plan was made", path.string()),
        "make the plan again, in another folder");
  }
}

}  // namespace

bool fits_run_folder(const Manifest& manifest, const fs::path& run, bool any_build,
                     Diagnostics& out) {
  if (!any_build && manifest.build != build_json())
    out.error({},
              fmt::format("'{}' was planned by another build of conddp ({}; this is {})",
                          run.string(), build_words(manifest.build), build_words(build_json())),
              "answers may differ in their last digits; --any-build mixes them");
  for (std::size_t i = 0; i < manifest.problems.size() && !out.has_errors(); ++i)
    is_as_planned(manifest, static_cast<int>(i), run, out);
  if (!out.has_errors()) check_files(manifest, run, out);
  return !out.has_errors();
}

namespace {

/// True if the file of a problem, with the settings of its first item, limits the solve time.
bool file_limits_time(const Manifest& manifest, int problem, const fs::path& run) {
  Diagnostics unused;
  const auto item = std::find_if(manifest.items.begin(), manifest.items.end(),
                                 [=](const ManifestItem& i) { return i.problem == problem; });
  if (item == manifest.items.end()) return true;
  const auto spec = read_problem(problem_of_run(manifest, problem, run), item->settings, unused);
  return !spec || std::isfinite(spec->solver.options.max_time_s);
}

}  // namespace

void warn_without_time_limit(const Manifest& manifest, const fs::path& run, Diagnostics& out) {
  if (manifest.limits.max_time_s > 0) return;
  const bool solves = manifest.command == BatchCommand::kSolve;  // the clock of loops is simulated
  for (std::size_t i = 0; i < manifest.problems.size(); ++i) {
    const int problem = static_cast<int>(i);
    if (solves && file_limits_time(manifest, problem, run)) continue;
    return out.warning({},
                       fmt::format("neither the plan nor '{}' limits the time of an item: an item "
                                   "that does not end blocks its worker forever",
                                   problem_of_run(manifest, problem, run).string()),
                       "write 'limits: {max_time_s: 600}' into the plan");
  }
}

fs::path file_of_run(const ManifestFile& file, const fs::path& run) {
  return (run / file.file).lexically_normal();
}

fs::path problem_of_run(const Manifest& manifest, int problem, const fs::path& run) {
  return (run / manifest.problems[problem].file).lexically_normal();
}

}  // namespace conddp
