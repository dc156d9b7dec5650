#include "batch/results/dataset.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "batch/results/hdf5_file.hpp"

namespace conddp {
namespace {

using Shape = std::vector<std::size_t>;
using Names = std::vector<std::string>;

constexpr std::size_t kLongestStatus = 24;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Puts nested lists into an array of a shape; what is short of it stays as it is.
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

/// An array of a group, and where a solution has its row.
struct ArrayOfItems {
  Hdf5File::Handle handle = -1;
  Shape shape;
  OrderedJson::json_pointer place;
};

/// The columns of a list of rows: as many as the longest one has.
std::size_t widest(const OrderedJson& rows) {
  std::size_t width = 0;
  for (const OrderedJson& row : rows) width = std::max(width, row.size());
  return width;
}

/// Problems of one shape.
class ShapeGroup {
 public:
  ShapeGroup(Hdf5File& file, const std::string& name, const Manifest& manifest,
             const OrderedJson& solution)
      : file_(file), group_(file.add_group(name)) {
    const OrderedJson& trajectory = solution.at("trajectory");
    const std::size_t nodes = trajectory.at("x").size(), knots = trajectory.at("u").size();
    const Names x = trajectory.at("columns").at("x"), u = trajectory.at("columns").at("u");
    const OrderedJson& units = trajectory.at("units");
    id_ = file.add_texts(group_, "id", 16);
    status_ = file.add_texts(group_, "status", kLongestStatus);
    item_ = file.add_array(group_, "item", {});
    add_parameters(manifest.columns);
    add("cost", "/cost", {}, {}, {});
    add("t", "/trajectory/t", {nodes}, {}, {"s"});
    add("x", "/trajectory/x", {nodes, x.size()}, x, units.at("x"));
    add("u", "/trajectory/u", {knots, u.size()}, u, units.at("u"));
    for (const auto& [contact, rows] : trajectory.at("contact_forces").items())
      add("force_" + contact, "/trajectory/contact_forces/" + escaped(contact),
          {knots, widest(rows)}, {}, {"N"});
    const OrderedJson& costates = solution.at("multipliers").at("costates");
    const std::size_t tangents = widest(costates);
    add("k", "/gains/k", {knots, u.size()}, u, units.at("u"));
    add("K", "/gains/K", {knots, u.size(), tangents}, u, {});
    add("costates", "/multipliers/costates", {nodes, tangents}, {}, {});
    for (const char* bound : {"control_lower", "control_upper"})
      if (solution.at("multipliers").contains(bound))
        add(bound, std::string("/multipliers/") + bound, {knots, u.size()}, u, {});
  }

  void append(std::size_t number, const ManifestItem& item, const OrderedJson& solution) {
    file_.append(id_, item.id);
    file_.append(status_, solution.at("status").get<std::string>());
    file_.append(item_, std::vector<double>{static_cast<double>(number)});
    std::vector<double> parameters(item.values.size(), kNone);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      fill(OrderedJson::parse(item.values[i]), {}, &parameters[i]);
    if (!parameters.empty()) file_.append(parameters_, parameters);
    for (const ArrayOfItems& array : arrays_) {
      std::size_t count = 1;
      for (const std::size_t size : array.shape) count *= size;
      std::vector<double> row(count, kNone);
      if (solution.contains(array.place)) fill(solution.at(array.place), array.shape, row.data());
      file_.append(array.handle, row);
    }
  }

 private:
  /// A name within a JSON pointer.
  static std::string escaped(const std::string& name) {
    std::string text;
    for (const char c : name)
      text += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
    return text;
  }

  void add_parameters(const std::vector<ManifestColumn>& columns) {
    if (columns.empty()) return;
    parameters_ = file_.add_array(group_, "parameters", {columns.size()});
    Names names, keys;
    for (const ManifestColumn& column : columns) {
      names.push_back(column.name);
      keys.push_back(column.key);
    }
    file_.annotate(parameters_, "names", names);
    file_.annotate(parameters_, "keys", keys);
  }

  void add(const std::string& name, const std::string& place, const Shape& shape,
           const Names& columns, const Names& units) {
    if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) return;
    std::string valid = name;  // '/' leads into groups
    std::replace(valid.begin(), valid.end(), '/', '_');
    const Hdf5File::Handle handle = file_.add_array(group_, valid, shape);
    file_.annotate(handle, "columns", columns);
    file_.annotate(handle, "units", units);
    arrays_.push_back({handle, shape, OrderedJson::json_pointer(place)});
  }

  Hdf5File& file_;
  const Hdf5File::Handle group_;
  Hdf5File::Handle id_ = -1, status_ = -1, item_ = -1, parameters_ = -1;
  std::vector<ArrayOfItems> arrays_;
};

/// What problems of one shape have in common.
std::string shape_key(const OrderedJson& solution) {
  const OrderedJson& trajectory = solution.at("trajectory");
  std::string key = fmt::format("{} {} {}", trajectory.at("x").size(),
                                trajectory.at("columns").dump(), trajectory.at("units").dump());
  for (const auto& [contact, rows] : trajectory.at("contact_forces").items())
    key += fmt::format(" {} {}", contact, widest(rows));
  for (const auto& [name, unused] : solution.at("multipliers").items()) key += " " + name;
  return key;
}

}  // namespace

DatasetCount write_dataset(const Manifest& manifest, const StoredResults& results,
                           const std::filesystem::path& file) {
  std::unique_ptr<Hdf5File> data;
  std::map<std::string, std::unique_ptr<ShapeGroup>> groups;
  DatasetCount count;
  bool is_complete = true;
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {
    const auto stored = results.find(manifest.items[i].id);
    is_complete = is_complete && stored != results.end();
    if (stored == results.end() || stored->second.result.solution_bytes == 0) continue;
    const OrderedJson solution = load_document(stored->second);
    if (solution.is_null()) {  // the pack is not what it was
      ++count.unreadable;
      continue;
    }
    if (!data) data = std::make_unique<Hdf5File>(file);
    auto& group = groups[shape_key(solution)];
    if (!group)
      group = std::make_unique<ShapeGroup>(*data, fmt::format("shape_{}", groups.size()), manifest,
                                           solution);
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
