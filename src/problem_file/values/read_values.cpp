#include "problem_file/values/read_values.hpp"

#include <cmath>
#include <limits>

namespace conddp {

double unit_scale(double length) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(length - 1) <= kRounding ? 1.0 : 1 / length;
}

std::optional<Vector3<double>> read_vector3(const YamlReader& reader, std::string_view what) {
  const auto n = reader.numbers(3, what);
  if (!n) return std::nullopt;
  return Vector3<double>{(*n)[0], (*n)[1], (*n)[2]};
}

NamedNumbers read_named_numbers(const YamlReader& reader, const NumberRange& range) {
  NamedNumbers values;
  if (const auto entries = reader.named_entries())
    for (const auto& [name, value] : *entries)
      if (const auto number = value.number(range)) values.emplace_back(name, *number);
  return values;
}

namespace {

/// Reads a number or null; returns false with an error otherwise.
bool read_component(const YamlReader& reader, const NumberRange& range,
                    std::optional<double>& value) {
  if (reader.is_null()) return true;
  value = reader.number(range);
  return value.has_value();
}

}  // namespace

std::optional<ComponentsSpec> read_components(const YamlReader& reader, const NumberRange& range) {
  ComponentsSpec spec{.place = reader.place()};
  if (reader.is_sequence()) {
    spec.form = ComponentsSpec::Form::kList;
    const auto items = reader.items();
    for (const YamlReader& item : *items)
      if (!read_component(item, range, spec.list.emplace_back())) return std::nullopt;
    return spec;
  }
  if (reader.is_map()) {
    spec.form = ComponentsSpec::Form::kMap;
    const auto entries = reader.named_entries();
    for (const auto& [name, value] : *entries)
      if (!read_component(value, range, spec.map.emplace_back(name, std::nullopt).second))
        return std::nullopt;
    return spec;
  }
  spec.scalar = reader.number(range);
  if (!spec.scalar) return std::nullopt;
  return spec;
}

std::optional<ComponentsSpec> read_component_bounds(const YamlReader& reader) {
  if (reader.is_null()) return ComponentsSpec{.place = reader.place()};
  return read_components(reader);
}

std::optional<MatrixSpec> read_symmetric_matrix(const YamlReader& reader) {
  constexpr std::string_view kHint = "write '[[2, 1], [1, 3]]' or '{x: {x: 2, v: 1}, v: {v: 3}}'";
  MatrixSpec matrix{.place = reader.place()};
  if (reader.is_map()) {
    const auto entries = reader.named_entries(kHint);
    for (const auto& [name, row] : *entries)
      matrix.entries.emplace_back(name, read_named_numbers(row));
    return matrix;
  }
  const auto rows = reader.items(kHint);
  if (!rows) return std::nullopt;
  for (const YamlReader& row : *rows) {
    const auto numbers = row.numbers();
    if (!numbers) return std::nullopt;
    matrix.rows.push_back({*numbers, row.place()});
  }
  return matrix;
}

std::optional<PlanarMotion> read_planar_motion(const YamlReader& reader) {
  const auto n = reader.numbers(3, "[x, y, yaw] in m and rad");
  if (!n) return std::nullopt;
  return PlanarMotion{(*n)[0], (*n)[1], (*n)[2]};
}

ContactNames read_contact_names(const YamlReader& reader) {
  ContactNames contacts;
  if (reader.is_scalar() && reader.node().text == "all") {
    contacts.all = true;
    return contacts;
  }
  if (const auto names = reader.name_or_names()) contacts.names = *names;
  return contacts;
}

}  // namespace conddp
