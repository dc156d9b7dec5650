#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

bool is_word(const YamlReader& reader) { return reader.is_scalar() && !reader.is_number(); }

bool has_key(const YamlReader& reader, std::string_view key) {
  return reader.is_map() && reader.node().find(key) != nullptr;
}

std::optional<ReferenceValueSpec> read_value(const YamlReader& reader, const CostSpec& cost) {
  const ReferenceForm& form = *cost.definition->reference;
  if (!is_word(reader) || !form.of_state) return form.read(reader, cost);
  ReferenceValueSpec value{.place = reader.place()};
  value.name = reader.name();
  if (!value.name) return std::nullopt;
  return value;
}

/// The increasing numbers under a key, each read by `read`.
template <class T, class Read>
std::vector<Located<T>> read_increasing(YamlMap& map, std::string_view key, Read read) {
  std::vector<Located<T>> values;
  for_each_item(map, key, [&](const YamlReader& item) {
    const T value = read(item);
    if (!values.empty() && value <= values.back().value)
      item.error(fmt::format("the {} must increase", key));
    values.push_back({value, item.place()});
  });
  return values;
}

void read_way_points(const YamlReader& reader, const CostSpec& cost, ReferenceSpec& spec) {
  YamlMap map(reader);
  map.exclusive({"times", "knots"});
  spec.times = read_increasing<double>(
      map, "times", [](const YamlReader& item) { return item.number(kNotNegative).value_or(0); });
  spec.knots = read_increasing<int>(map, "knots", [](const YamlReader& item) {
    return static_cast<int>(item.integer(0, 1'000'000).value_or(0));
  });
  const auto values = map.require("values");
  if (!values) return;
  const auto items = values->items();
  if (!items) return;
  for (const YamlReader& item : *items)
    if (auto value = read_value(item, cost)) spec.values.push_back(std::move(*value));
  const std::size_t places = spec.times.size() + spec.knots.size();
  if (items->size() != places)
    values->error(fmt::format("there are {} values for {} {}", items->size(), places,
                              spec.knots.empty() ? "times" : "knots"));
  else if (items->empty())
    values->error("there is no way-point");
}

}  // namespace

std::optional<DataFileSpec> read_data_file(YamlMap& map, const std::filesystem::path& folder) {
  const auto file = map.require("file");
  const auto columns = map.find("columns");
  if (!file) return std::nullopt;
  const auto name = file->name();
  if (!name) return std::nullopt;
  DataFileSpec spec{.file = *name, .path = folder / name->value};
  if (columns) spec.columns = columns->names().value_or(std::vector<Name>{});
  return spec;
}

std::optional<ReferenceSpec> read_reference(const YamlReader& reader, const CostSpec& cost,
                                            const std::filesystem::path& folder) {
  ReferenceSpec spec{.place = reader.place()};
  if (has_key(reader, "file")) {
    YamlMap map(reader);
    spec.file = read_data_file(map, folder);
  } else if (has_key(reader, "times") || has_key(reader, "knots")) {
    read_way_points(reader, cost, spec);
  } else if (auto value = read_value(reader, cost)) {
    spec.values.push_back(std::move(*value));
  } else {
    return std::nullopt;
  }
  return spec;
}

}  // namespace conddp
