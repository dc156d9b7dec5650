#include "batch/results/dataset.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "batch/plan/manifest.hpp"
#include "batch/results/hdf5_file.hpp"
#include "batch/results/item_files.hpp"

namespace conddp {
namespace {

using Shape = std::vector<std::size_t>;
using Names = std::vector<std::string>;

constexpr std::size_t kLongestStatus = 24, kLongestSolver = 32;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Copies nested lists into an array of a given shape; missing entries remain unchanged.
void fill(const OrderedJson& json, std::span<const std::size_t> shape, double* out) {
  if (shape.empty()) {
    if (json.is_number()) *out = json.get<double>();
    return;
  }
  if (!json.is_array()) return;
  std::size_t stride = 1;
  for (const std::size_t size : shape.subspan(1)) stride *= size;
  for (std::size_t i = 0; i < std::min(shape[0], json.size()); ++i)
    fill(json[i], shape.subspan(1), out + i * stride);
}

/// The meaning of the first index of an item's array.
enum class Rows { kOther, kControls };

/// An array of a group, and the location of its row in a solution.
struct ArrayOfItems {
  Hdf5File::Handle handle = -1;
  Shape shape;
  OrderedJson::json_pointer place;
  Rows rows = Rows::kOther;
};

/// True if the first knot is instantaneous and without controls: its numbers are the choices of the
/// solver.
bool begins_with_choice(const OrderedJson& solution) {
  const OrderedJson& trajectory = solution.at("trajectory");
  const OrderedJson& t = trajectory.at("t");
  return trajectory.at("phases").at(0).at("knots") == 1 && t.at(1) == t.at(0);
}

/// The varied values as numbers: a column for each key, or for each number in its lists and
/// mappings.
class Parameters {
 public:
  explicit Parameters(const Manifest& manifest) : columns_(manifest.columns.size()) {
    for (const ManifestItem& item : manifest.items)
      for (std::size_t c = 0; c < columns_.size(); ++c)
        for (const ValueLeaf& leaf : leaves_of(item.values[c]))
          if (leaf.value.is_number()) columns_[c].add(leaf.path);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].paths.empty()) columns_[c].add("");  // texts only
      columns_[c].first = names_.size();
      for (const std::string& path : columns_[c].paths) {
        names_.push_back(behind(manifest.columns[c].name, path));
        keys_.push_back(behind(manifest.columns[c].key, path));
      }
    }
  }

  const Names& names() const { return names_; }
  const Names& keys() const { return keys_; }

  /// The numbers of an item. NaN for texts, and for columns that the item's values lack.
  std::vector<double> of(const ManifestItem& item) const {
    std::vector<double> numbers(names_.size(), kNone);
    for (std::size_t c = 0; c < columns_.size(); ++c)
      for (const ValueLeaf& leaf : leaves_of(item.values[c]))
        if (leaf.value.is_number())
          numbers[columns_[c].first + columns_[c].indices.at(leaf.path)] = leaf.value.get<double>();
    return numbers;
  }

 private:
  /// The numbers of one key, in order of appearance in the items.
  struct Column {
    std::size_t first = 0;  ///< index of its first name
    Names paths;
    std::map<std::string, std::size_t> indices;  ///< by path

    void add(const std::string& path) {
      if (indices.try_emplace(path, paths.size()).second) paths.push_back(path);
    }
  };

  static std::string behind(const std::string& name, const std::string& path) {
    return path.empty() ? name : name + '.' + path;
  }

  std::vector<Column> columns_;
  Names names_, keys_;
};

/// The constraints of a solution with the maximum number of rows at a node.
std::vector<std::pair<std::string, std::size_t>> constraint_rows(const OrderedJson& solution) {
  std::vector<std::pair<std::string, std::size_t>> found;
  const OrderedJson& multipliers = solution.at("multipliers");
  if (!multipliers.contains("constraints")) return found;
  std::map<std::string, std::map<std::size_t, std::size_t>> rows;  // by name and node
  for (const OrderedJson& entry : multipliers.at("constraints")) {
    const std::string name = entry.at("name");
    if (!rows.contains(name)) found.emplace_back(name, 0);
    rows[name][entry.at("node").get<std::size_t>()] += entry.at("multiplier").size();
  }
  for (auto& [name, most] : found)
    for (const auto& [node, count] : rows[name]) most = std::max(most, count);
  return found;
}

/// The width of a list of rows: the size of the longest row.
std::size_t widest(const OrderedJson& rows) {
  std::size_t width = 0;
  for (const OrderedJson& row : rows) width = std::max(width, row.size());
  return width;
}

/// The arrays of all problems with the same shape.
class ShapeGroup {
 public:
  /// `tangents`: names of the components of tangent vectors; empty if unknown.
  ShapeGroup(Hdf5File& file, const std::string& name, const Manifest& manifest,
             const Parameters& parameters, const OrderedJson& solution, const Names& tangents)
      : file_(file), group_(file.add_group(name)), manifest_(manifest), parameters_(parameters) {
    const OrderedJson& trajectory = solution.at("trajectory");
    const std::size_t nodes = trajectory.at("x").size(), knots = trajectory.at("u").size();
    const Names x = trajectory.at("columns").at("x"), u = trajectory.at("columns").at("u");
    const OrderedJson& units = trajectory.at("units");
    add_item_arrays();
    add("cost", "/cost", {}, {}, {});
    add("t", "/trajectory/t", {nodes}, {}, {"s"});
    add("x", "/trajectory/x", {nodes, x.size()}, x, units.at("x"));
    add("u", "/trajectory/u", {knots, u.size()}, u, units.at("u"), Rows::kControls);
    for (const auto& [contact, rows] : trajectory.at("contact_forces").items())
      add_force(contact, knots, widest(rows));
    const OrderedJson& costates = solution.at("multipliers").at("costates");
    const std::size_t width = widest(costates);
    const Names columns = tangents.size() == width ? tangents : Names();
    add("k", "/gains/k", {knots, u.size()}, u, units.at("u"), Rows::kControls);
    if (const auto K = add("K", "/gains/K", {knots, u.size(), width}, u, {}, Rows::kControls))
      file_.annotate(*K, "tangents", columns);
    add("costates", "/multipliers/costates", {nodes, width}, columns, {});
    for (const char* bound : {"control_lower", "control_upper"})
      if (solution.at("multipliers").contains(bound))
        add(bound, std::string("/multipliers/") + bound, {knots, u.size()}, u, {}, Rows::kControls);
    for (const auto& [constraint, rows] : constraint_rows(solution))
      multipliers_.push_back(
          {constraint,
           file_.add_array(group_, array_name("multiplier_" + constraint), {nodes, rows}), nodes,
           rows});
  }

  void append(std::size_t number, const ManifestItem& item, const OrderedJson& solution) {
    file_.append(id_, item.id);
    file_.append(status_, solution.at("status").get<std::string>());
    file_.append(solver_, solution.at("solver").get<std::string>());
    file_.append(problem_, manifest_.problems[item.problem].file);
    file_.append(item_, std::vector<double>{static_cast<double>(number)});
    if (!parameters_.names().empty()) file_.append(parameter_array_, parameters_.of(item));
    for (const ArrayOfItems& array : arrays_) {
      std::size_t count = 1;
      for (const std::size_t size : array.shape) count *= size;
      std::vector<double> row(count, kNone);
      if (solution.contains(array.place)) fill(solution.at(array.place), array.shape, row.data());
      if (array.rows == Rows::kControls && begins_with_choice(solution))
        std::fill_n(row.begin(), count / array.shape[0], kNone);
      file_.append(array.handle, row);
    }
    for (const Multipliers& array : multipliers_)
      file_.append(array.handle, multipliers_of(array, solution));
  }

 private:
  /// Multipliers of a constraint by node and row.
  struct Multipliers {
    std::string constraint;
    Hdf5File::Handle handle;
    std::size_t nodes, rows;
  };

  static std::vector<double> multipliers_of(const Multipliers& array, const OrderedJson& solution) {
    std::vector<double> numbers(array.nodes * array.rows, kNone);
    std::vector<std::size_t> filled(array.nodes, 0);
    for (const OrderedJson& entry : solution.at("multipliers").at("constraints")) {
      if (entry.at("name") != array.constraint) continue;
      const OrderedJson& rows = entry.at("multiplier");
      const auto node = entry.at("node").get<std::size_t>();
      fill(rows, std::vector{rows.size()}, &numbers[node * array.rows + filled[node]]);
      filled[node] += rows.size();
    }
    return numbers;
  }

  /// Escapes a name for a JSON pointer.
  static std::string escaped(const std::string& name) {
    std::string text;
    for (const char c : name)
      text += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
    return text;
  }

  /// A unique name for an array, without '/', which would create groups.
  std::string array_name(std::string name) {
    std::replace(name.begin(), name.end(), '/', '_');
    while (!names_.insert(name).second) name += '_';
    return name;
  }

  void add_item_arrays() {
    std::size_t longest = 1;
    for (const ManifestProblem& problem : manifest_.problems)
      longest = std::max(longest, problem.file.size());
    id_ = file_.add_texts(group_, "id", 16);
    status_ = file_.add_texts(group_, "status", kLongestStatus);
    solver_ = file_.add_texts(group_, "solver", kLongestSolver);
    problem_ = file_.add_texts(group_, "problem", longest);
    item_ = file_.add_array(group_, "item", {});
    if (parameters_.names().empty()) return;
    parameter_array_ = file_.add_array(group_, "parameters", {parameters_.names().size()});
    file_.annotate(parameter_array_, "names", parameters_.names());
    file_.annotate(parameter_array_, "keys", parameters_.keys());
  }

  /// Adds a contact force: three numbers, or six with the torque.
  void add_force(const std::string& contact, std::size_t knots, std::size_t width) {
    Names columns = {"fx", "fy", "fz", "tx", "ty", "tz"};
    Names units = {"N", "N", "N", "Nm", "Nm", "Nm"}, impulses;
    columns.resize(std::min(width, columns.size()));
    units.resize(columns.size());
    for (const std::string& unit : units) impulses.push_back(unit + "s");
    if (const auto force = add("force_" + contact, "/trajectory/contact_forces/" + escaped(contact),
                               {knots, width}, columns, units))
      file_.annotate(*force, "units_at_impulses", impulses);
  }

  /// Adds an array of numbers from the solution; nothing if it would be empty.
  std::optional<Hdf5File::Handle> add(const std::string& name, const std::string& place,
                                      const Shape& shape, const Names& columns, const Names& units,
                                      Rows rows = Rows::kOther) {
    if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) return std::nullopt;
    const Hdf5File::Handle handle = file_.add_array(group_, array_name(name), shape);
    file_.annotate(handle, "columns", columns);
    file_.annotate(handle, "units", units);
    arrays_.push_back({handle, shape, OrderedJson::json_pointer(place), rows});
    return handle;
  }

  Hdf5File& file_;
  const Hdf5File::Handle group_;
  const Manifest& manifest_;
  const Parameters& parameters_;
  Hdf5File::Handle id_ = -1, status_ = -1, solver_ = -1, problem_ = -1, item_ = -1;
  Hdf5File::Handle parameter_array_ = -1;
  std::set<std::string> names_;
  std::vector<ArrayOfItems> arrays_;
  std::vector<Multipliers> multipliers_;
};

/// A text that is equal for problems of the same shape.
std::string shape_key(const OrderedJson& solution) {
  const OrderedJson& trajectory = solution.at("trajectory");
  std::string key = fmt::format("{} {} {}", trajectory.at("x").size(),
                                trajectory.at("columns").dump(), trajectory.at("units").dump());
  for (const auto& [contact, rows] : trajectory.at("contact_forces").items())
    key += fmt::format(" {} {}", contact, widest(rows));
  for (const auto& [name, unused] : solution.at("multipliers").items()) key += " " + name;
  for (const auto& [name, rows] : constraint_rows(solution))
    key += fmt::format(" {} {}", name, rows);
  return key;
}

/// Names of the tangent vectors of an item's states; empty if its files have changed.
Names tangent_names_of(const std::filesystem::path& run, const Manifest& manifest,
                       const ManifestItem& item) {
  Diagnostics unused;
  const auto shown = load_item(run, manifest, item, nullptr, unused);
  return shown ? tangent_columns(shown->built) : Names();
}

}  // namespace

DatasetCount write_dataset(const std::filesystem::path& run, const Manifest& manifest,
                           const StoredResults& results) {
  const std::filesystem::path file = run / "dataset.h5";
  const Parameters parameters(manifest);
  std::unique_ptr<Hdf5File> data;
  std::map<std::string, std::unique_ptr<ShapeGroup>> groups;
  DatasetCount count;
  bool is_complete = true;
  const auto kept =
      std::count_if(manifest.items.begin(), manifest.items.end(), [&](const ManifestItem& item) {
        const auto stored = results.find(item.id);
        return stored != results.end() && stored->second.result.solution_bytes > 0;
      });
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {
    const auto stored = results.find(manifest.items[i].id);
    is_complete = is_complete && stored != results.end();
    if (stored == results.end() || stored->second.result.solution_bytes == 0) continue;
    const OrderedJson solution = load_document(stored->second);
    if (solution.is_null()) {  // the pack has changed
      ++count.unreadable;
      continue;
    }
    if (!data) data = std::make_unique<Hdf5File>(file, static_cast<std::size_t>(kept));
    auto& group = groups[shape_key(solution)];
    if (!group)
      group = std::make_unique<ShapeGroup>(*data, fmt::format("shape_{}", groups.size()), manifest,
                                           parameters, solution,
                                           tangent_names_of(run, manifest, manifest.items[i]));
    group->append(i + 1, manifest.items[i], solution);
    ++count.solutions;
  }
  if (data) {
    data->commit();
  } else if (is_complete && count.unreadable == 0) {
    std::error_code error;
    std::filesystem::remove(file, error);
  }
  return count;
}

}  // namespace conddp
