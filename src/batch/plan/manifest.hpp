#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "batch/plan/batch_plan.hpp"
#include "batch/plan/problem_family.hpp"
#include "output/solution/input_files.hpp"

namespace conddp {

/// The name and format of the list of items in a run's folder.
inline constexpr const char* kManifestFile = "manifest.jsonl";
inline constexpr std::string_view kManifestFormat = "conddp.batch_manifest/4";

/// A problem file of a run.
struct ManifestProblem {
  std::string file;      ///< relative to the run's folder
  std::string identity;  ///< batch_identity() at the time of planning
};

/// A file that items read in addition to those read by the problem files.
struct ManifestFile {
  std::string file;    ///< relative to the run's folder
  std::string sha256;  ///< of its bytes at the time of planning
};

/// The common starting solution of all items.
struct ManifestStart {
  ManifestFile file;
  int iterations = -1;  ///< iterations of that solve; −1: unknown
};

/// A varied key.
struct ManifestColumn {
  std::string name;  ///< in result tables
  std::string key;
};

/// A problem to solve.
struct ManifestItem {
  std::string id;  ///< 16 hexadecimal digits
  int problem = 0;
  std::vector<std::string> settings;  ///< in `--set` syntax
  std::vector<std::string> values;    ///< of the columns, as JSON
  std::string parent;  ///< the item whose answer this one starts from; empty without one
};

/// The items of a run and the settings of its plan.
struct Manifest {
  std::string name;
  BatchCommand command = BatchCommand::kSolve;
  std::vector<ManifestProblem> problems;
  std::vector<ManifestColumn> columns;
  BatchLimits limits;
  KeptSolutions keep = KeptSolutions::kConverged;
  WarmStart warm_start = WarmStart::kNone;
  std::optional<ManifestStart> start;  ///< for WarmStart::kFile
  std::vector<ManifestFile> files;     ///< named by settings of items
  int solvers = 1;                     ///< items that differ only in the solver are consecutive
  int shards = 1;     ///< number of processes that divide the items, unless specified otherwise
  OrderedJson build;  ///< build_json() of the planning tool
  std::vector<ManifestItem> items;
};

/// Build properties that affect the bits of answers: version, revision, instruction set, lanes.
OrderedJson build_json();

/// A hash of a file's own problem, with every default, and of the files that it reads. For closed
/// loops, also of the gait commands and the files of the plant.
std::string batch_identity(const ProblemFamily& family, BatchCommand command);

/// The SHA-256 of a file's bytes; nothing if the file cannot be read.
std::optional<std::string> hash_of_file(const std::filesystem::path& file);

/// The id of an item. It depends only on the problem file, the settings, and the files that the
/// item reads or starts from. The notation and order of settings do not matter.
std::string item_id(const Manifest& manifest, int problem, const std::vector<Setting>& settings,
                    const InputFiles& files);

/// The solver that the plan sets for an item; empty without one.
std::string solver_of(const ManifestItem& item);

/// A line of a manifest, without its line end: the head, or an item.
std::string manifest_head(const Manifest& manifest);
std::string manifest_line(const ManifestItem& item);

/// Reads the manifest of a run; reports errors with their line. `with_items`: true to read more
/// than the head.
std::optional<Manifest> load_manifest(const std::filesystem::path& run, bool with_items,
                                      Diagnostics& out);

/// An item from its line; nothing if the line is invalid.
std::optional<ManifestItem> parse_manifest_line(std::string_view line);

/// A number, word or empty list inside a varied value.
struct ValueLeaf {
  std::string
      path;  ///< steps through lists and mappings, joined by dots; empty for the value itself
  OrderedJson value;
};

/// The leaves of a value in the manifest, in order. `text` is the value as JSON.
std::vector<ValueLeaf> leaves_of(const std::string& text);

}  // namespace conddp
