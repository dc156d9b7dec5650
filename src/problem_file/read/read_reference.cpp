#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

bool is_word(const YamlReader& reader) { return reader.is_scalar() && !reader.is_number(); }

bool has_key(const YamlReader& reader, std::string_view key) {
  return reader.is_map() && reader.node().find(key) != nullptr;
}

std::optional<ReferenceValueSpec> read_value(const YamlReader& reader, ResidualKind kind) {
  ReferenceValueSpec value{.place = reader.place()};
  const auto done = [&](bool found) {
    return found ? std::optional<ReferenceValueSpec>(value) : std::nullopt;
  };
  const bool of_state = kind != ResidualKind::kControl && kind != ResidualKind::kContactForce;
  if (is_word(reader) && of_state) {
    value.name = reader.name();
    return done(value.name.has_value());
  }
  switch (kind) {
    case ResidualKind::kState:
      if (reader.is_map()) {
        value.state = read_state(reader);
        return done(value.state.has_value());
      }
      [[fallthrough]];
    case ResidualKind::kControl:
    case ResidualKind::kJointPosition:
    case ResidualKind::kJointVelocity:
    case ResidualKind::kJointAcceleration:
    case ResidualKind::kCentroidalMomentum:
    case ResidualKind::kContactForce:
      value.components = read_components(reader);
      return done(value.components.has_value());
    case ResidualKind::kFramePosition:
    case ResidualKind::kComPosition: {
      const auto position = read_vector3(reader, "[x, y, z] in m");
      value.pose = PoseSpec{.place = reader.place(), .position = position};
      return done(position.has_value());
    }
    case ResidualKind::kFrameRotation:
    case ResidualKind::kFramePlacement:
      value.pose = read_pose(reader);
      if (value.pose && value.pose->position && kind == ResidualKind::kFrameRotation)
        reader.error("a rotation has no position", "use the residual 'frame_placement'");
      return done(value.pose.has_value());
    case ResidualKind::kFrameVelocity:
      value.twist = read_twist(reader);
      return done(value.twist.has_value());
    case ResidualKind::kControlRate:
    case ResidualKind::kControlGravity:
    case ResidualKind::kFrictionCone:
    case ResidualKind::kWrenchCone:
    case ResidualKind::kCenterOfPressure:
    case ResidualKind::kDistance:
    case ResidualKind::kContactVelocity:
    case ResidualKind::kCycle:
    case ResidualKind::kCombination:
      break;
  }
  return std::nullopt;
}

void read_way_points(const YamlReader& reader, ResidualKind kind, ReferenceSpec& spec) {
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
    if (auto value = read_value(item, kind)) spec.values.push_back(std::move(*value));
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

std::optional<ReferenceSpec> read_reference(const YamlReader& reader, ResidualKind kind,
                                            const std::filesystem::path& folder) {
  ReferenceSpec spec{.place = reader.place()};
  if (has_key(reader, "file")) {
    YamlMap map(reader);
    spec.file = read_data_file(map, folder);
  } else if (has_key(reader, "times") || has_key(reader, "knots")) {
    read_way_points(reader, kind, spec);
  } else if (auto value = read_value(reader, kind)) {
    spec.values.push_back(std::move(*value));
  } else {
    return std::nullopt;
  }
  return spec;
}

}  // namespace conddp
