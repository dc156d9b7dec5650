#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/json_document.hpp"
#include "base/json/relative_paths.hpp"
#include "batch/results/batch_report.hpp"
#include "batch/results/item_files.hpp"
#include "commands/batch_actions.hpp"
#include "output/report/report.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Maximum number of items in each list of the page.
constexpr std::size_t kMostInList = 8;

int report_errors(const Diagnostics& diagnostics) {
  print_messages(diagnostics, Verbosity::kVerbose);
  return kExitBadInput;
}

fs::path folder_of_item(const fs::path& run, const std::string& id) { return run / "items" / id; }

/// Empty with an error if the solution no longer belongs to the item's problem.
std::optional<std::vector<fs::path>> write_item_files(const ShownItem& item, const fs::path& folder,
                                                      Diagnostics& out) {
  try {
    return write_item(item, folder);
  } catch (const MalformedSolution& malformed) {
    out.error({},
              fmt::format("the solution does not fit the problem '{}': {}",
                          item.built.facts().file.string(), malformed.what()),
              "that file has changed since the plan was made");
    return std::nullopt;
  }
}

/// Files of one item, and its status.
struct Written {
  std::string status;
  std::vector<fs::path> files;
};

/// The end of a loop that was simulated again, without a time limit. It may differ from the end in
/// the run, which is then added.
std::string status_of(LoopEnd end, const std::string& stored) {
  const std::string status(to_string(end));
  return stored == status ? status : fmt::format("{}; in the run: {}", status, stored);
}

/// Writes the files of one item; a closed loop is simulated for this.
std::optional<Written> write_shown(const fs::path& run, const Manifest& manifest,
                                   const ManifestItem& item, const StoredResult* stored,
                                   const fs::path& folder, Diagnostics& out) {
  const std::string status = stored == nullptr ? std::string(kUnfinished) : stored->result.status;
  if (manifest.command == BatchCommand::kMpc) {
    auto loop = write_loop_item(run, manifest, item, folder, out);
    if (!loop) return std::nullopt;
    return Written{status_of(loop->end, status), std::move(loop->paths)};
  }
  const auto shown = load_item(run, manifest, item, stored, out);
  auto files = shown ? write_item_files(*shown, folder, out) : std::nullopt;
  if (!files) return std::nullopt;
  return Written{status, *std::move(files)};
}

/// The items on a run's page, with their files.
class ShownItems {
 public:
  ShownItems(const fs::path& run, const Manifest& manifest, const StoredResults& results)
      : run_(run), manifest_(manifest), results_(results) {}

  /// Omits items without files and warns about the reason.
  void write(const std::vector<StandOut>& lists, const fs::path& page, Diagnostics& out) {
    const fs::path from = fs::absolute(page).parent_path();
    for (const StandOut& list : lists)
      for (const std::size_t i : list.items) {
        if (links_.contains(i)) continue;
        const ManifestItem& item = manifest_.items[i];
        Diagnostics own;
        auto shown = load_item(run_, manifest_, item, find_result(results_, item), own);
        const auto files =
            shown ? write_item_files(*shown, folder_of_item(run_, item.id), own) : std::nullopt;
        if (!files) {
          warn(own, out);
          continue;
        }
        for (const fs::path& file : *files)
          links_[i].push_back(relative_path(fs::absolute(file), from));
        shown_.emplace(i, *std::move(shown));
      }
  }

  /// The first item with a solution from each list, without duplicates.
  std::vector<ReportEntry> entries(const std::vector<StandOut>& lists) const {
    std::map<std::size_t, std::string> labels;
    for (const StandOut& list : lists)
      for (const std::size_t i : list.items) {
        if (!shown_.contains(i) || shown_.at(i).document.is_null()) continue;
        std::string& label = labels[i];
        label += (label.empty() ? "" : ", ") + list.title;
        break;
      }
    std::vector<ReportEntry> entries;
    for (const auto& [i, label] : labels)
      entries.push_back({.label = fmt::format("{} ({})", label, i + 1),
                         .document = shown_.at(i).document,
                         .built = &shown_.at(i).built});
    return entries;
  }
  const ItemLinks& links() const { return links_; }

 private:
  /// Warns once per reason why the page lacks the files of some items.
  void warn(const Diagnostics& reasons, Diagnostics& out) {
    for (const Diagnostic& d : reasons.list())
      if (d.severity == Severity::kError) {
        if (said_.insert(d.message).second)
          out.warning({}, d.message, "the page has no files of the items concerned");
        return;
      }
  }

  const fs::path& run_;
  const Manifest& manifest_;
  const StoredResults& results_;
  std::set<std::string> said_;
  std::map<std::size_t, ShownItem> shown_;
  ItemLinks links_;
};

/// The item whose id begins with a word; null with an error if it is not unique.
const ManifestItem* find_item(const Manifest& manifest, const fs::path& run,
                              const std::string& word) {
  const auto begins = [&](const ManifestItem& item) { return item.id.starts_with(word); };
  const auto& items = manifest.items;
  const auto count = std::count_if(items.begin(), items.end(), begins);
  if (count == 1) return &*std::find_if(items.begin(), items.end(), begins);
  if (count == 0)
    print_error(fmt::format("'{}' has no item '{}'", run.string(), word),
                "the ids are in its results.csv and manifest.jsonl");
  else
    print_error(fmt::format("the ids of {} items begin with '{}'", count, word),
                "write more of its digits");
  return nullptr;
}

}  // namespace

int show_item(const BatchArguments& arguments) {
  const fs::path run = arguments.path;
  Diagnostics diagnostics;
  const auto manifest = load_manifest(run, true, diagnostics);
  if (!manifest) return report_errors(diagnostics);
  const ManifestItem* item = find_item(*manifest, run, arguments.word);
  if (item == nullptr) return kExitBadInput;
  const auto results = load_results(run);
  const StoredResult* stored = find_result(results, *item);
  const fs::path folder =
      arguments.folder.empty() ? folder_of_item(run, item->id) : fs::path(arguments.folder);
  const auto written = write_shown(run, *manifest, *item, stored, folder, diagnostics);
  if (!written) return report_errors(diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  std::string text = fmt::format("{}: {}\n", item->id, written->status);
  for (const fs::path& file : written->files) text += file.string() + '\n';
  print_result(text);
  return kExitConverged;
}

int report_batch(const BatchArguments& arguments) {
  if (!reports_can_be_made()) return kExitBadInput;
  const fs::path run = arguments.path;
  Diagnostics diagnostics;
  const auto manifest = load_manifest(run, true, diagnostics);
  if (!manifest) return report_errors(diagnostics);
  const auto results = load_results(run);
  const std::vector<StandOut> lists = items_that_stand_out(*manifest, results, kMostInList);
  const fs::path page = arguments.folder.empty() ? run / "report.html" : fs::path(arguments.folder);
  create_folder(fs::absolute(page).parent_path());
  ShownItems shown(run, *manifest, results);
  // A page of closed loops does not show motions: 'show' simulates them individually.
  if (manifest->command == BatchCommand::kSolve) shown.write(lists, page, diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  OrderedJson data = report_data(shown.entries(lists));
  data["batch"] = batch_report(*manifest, results, lists, shown.links());
  AtomicFiles files;
  files.add(page, report_text(data));
  files.commit();
  print_result(page.string() + '\n');
  return kExitConverged;
}

}  // namespace conddp
