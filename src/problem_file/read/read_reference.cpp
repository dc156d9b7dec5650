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

void read_way_points(const YamlReader& reader, const CostSpec& cost, ReferenceSpec& spec) {
  YamlMap map(reader);
  map.exclusive({"times", "knots"});
  std::size_t places = 0;
  if (const auto times = map.find("times"))
    if (const auto items = times->items())
      for (const YamlReader& item : *items) {
        const double time = item.number(kNotNegative).value_or(0);
        if (!spec.times.empty() && time <= spec.times.back().value)
          item.error("the times must increase");
        spec.times.push_back({time, item.place()});
        ++places;
      }
  if (const auto knots = map.find("knots"))
    if (const auto items = knots->items())
      for (const YamlReader& item : *items) {
        const int knot = static_cast<int>(item.integer(0, 1'000'000).value_or(0));
        if (!spec.knots.empty() && knot <= spec.knots.back().value)
          item.error("the knots must increase");
        spec.knots.push_back({knot, item.place()});
        ++places;
      }
  const auto values = map.require("values");
  if (!values) return;
  const auto items = values->items();
  if (!items) return;
  for (const YamlReader& item : *items)
    if (auto value = read_value(item, cost)) spec.values.push_back(std::move(*value));
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
