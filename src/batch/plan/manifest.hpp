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

/// The name and the format of the list of items in the folder of a run.
inline constexpr const char* kManifestFile = "manifest.jsonl";
inline constexpr std::string_view kManifestFormat = "conddp.batch_manifest/4";

/// A problem file of a run.
struct ManifestProblem {
  std::string file;      ///< seen from the folder of the run
  std::string identity;  ///< batch_identity() when the plan was made
};

/// A file that items read besides what the problem files read by themselves.
struct ManifestFile {
  std::string file;    ///< seen from the folder of the run
  std::string sha256;  ///< of its bytes when the plan was made
};

/// The solution from which all items of a plan start.
struct ManifestStart {
  ManifestFile file;
  int iterations = -1;  ///< that it took; −1: unknown
};

/// What was varied.
struct ManifestColumn {
  std::string name;  ///< in tables of results
  std::string key;
};

/// One problem to solve.
struct ManifestItem {
  std::string id;  ///< 16 hexadecimal digits
  int problem = 0;
  std::vector<std::string> settings;  ///< as --set takes them
  std::vector<std::string> values;    ///< of the columns, as JSON
  std::string parent;                 ///< the item from whose answer it starts; empty: none
};

/// Which items a run has, and what else the plan says about them.
struct Manifest {
  std::string name;
  BatchCommand command = BatchCommand::kSolve;
  std::vector<ManifestProblem> problems;
  std::vector<ManifestColumn> columns;
  BatchLimits limits;
  KeptSolutions keep = KeptSolutions::kConverged;
  WarmStart warm_start = WarmStart::kNone;
  std::optional<ManifestStart> start;  ///< of WarmStart::kFile
  std::vector<ManifestFile> files;     ///< that settings of items name
  int solvers = 1;    ///< items that differ in nothing but the solver follow one another
  int shards = 1;     ///< into how many processes divide the items that are not told otherwise
  OrderedJson build;  ///< build_json() of the tool that made the plan
  std::vector<ManifestItem> items;
};

/// On what the bits of answers depend besides their problem: version, revision, instruction set,
/// lanes.
OrderedJson build_json();

/// A hash of a file's own problem with every default, and of the files that it reads; of closed
/// loops also of the commands of its gait and of the files of its plant.
std::string batch_identity(const ProblemFamily& family, BatchCommand command);

/// The SHA-256 of a file's bytes; nothing where it cannot be read.
std::optional<std::string> hash_of_file(const std::filesystem::path& file);

/// The name of an item: the same for the same problem file, settings, and files that it reads or
/// starts from, however they are written and in whatever order.
std::string item_id(const Manifest& manifest, int problem, const std::vector<Setting>& settings,
                    const InputFiles& files);

/// The solver that an item is set to by the plan, or nothing.
std::string solver_of(const ManifestItem& item);

/// One line of a manifest, without its end: the head, or an item.
std::string manifest_head(const Manifest& manifest);
std::string manifest_line(const ManifestItem& item);

/// Reads the manifest of a run; what is wrong with it is reported with its line. `with_items`:
/// whether more than the head is wanted.
std::optional<Manifest> load_manifest(const std::filesystem::path& run, bool with_items,
                                      Diagnostics& out);

/// An item from its line; nothing where it is none.
std::optional<ManifestItem> parse_manifest_line(std::string_view line);

}  // namespace conddp
