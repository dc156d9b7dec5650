#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// Increasing times, s.
struct TimesForm {
  NumberForm form{kNotNegative};
  bool read(const YamlReader& reader, std::vector<Located<double>>& times) const {
    const auto items = reader.items();
    if (!items) return false;
    for (const YamlReader& item : *items) {
      double time = 0;
      form.read(item, time);
      if (!times.empty() && time <= times.back().value) item.error("the times must increase");
      times.push_back({time, item.place()});
    }
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<Located<double>>& times) const {
    OrderedJson json = OrderedJson::array();
    for (const Located<double>& time : times) json.push_back(time.value);
    return json;
  }
  OrderedJson schema() const { return {{"type", "array"}, {"items", form.schema()}}; }
};

/// A value in the form of the cost's residual, or the name of a state.
struct ReferenceValueForm {
  const CostSpec& cost;
  bool read(const YamlReader& reader, ReferenceValueSpec& value) const {
    const ReferenceForm& form = *cost.definition->reference;
    if (!form.of_state || !reader.is_scalar() || reader.is_number()) {
      const auto read = form.read(reader, cost);
      if (read) value = *read;
      return read.has_value();
    }
    value = {.place = reader.place(), .name = reader.name()};
    return value.name.has_value();
  }
  std::optional<OrderedJson> expand(const ReferenceValueSpec& value) const {
    return value.name ? OrderedJson(value.name->value) : cost.definition->reference->expand(value);
  }
  static OrderedJson schema(SchemaDefinitions& definitions) {
    return defined(definitions, "reference_value", [&] {
      OrderedJson schema = OrderedJson::parse(R"({
        "title": "Value of a reference",
        "description": "In the form that fits the residual",
        "anyOf": [{"type": "string", "minLength": 1}, {"type": "number"},
                  {"type": "array", "items": {"type": ["number", "null"]}},
                  {"type": "object", "additionalProperties": {"type": ["number", "null"]}}],
        "examples": ["initial", 0.5, [0.1, 0.2, 0.3],
                     {"position": [0, 0, 1], "rpy": [0, 0, 0]}]})");
      for (OrderedJson kind :
           {map_schema<StateSpec>(definitions), map_schema<PoseSpec>(definitions),
            TwistForm().schema({}, definitions)})
        schema["anyOf"].push_back(std::move(kind));
      return schema;
    });
  }
};

struct ReferenceValuesForm {
  const CostSpec& cost;
  bool read(const YamlReader& reader, std::vector<ReferenceValueSpec>& values) const {
    const auto items = reader.items();
    if (!items) return false;
    for (const YamlReader& item : *items) {
      ReferenceValueSpec value;
      if (ReferenceValueForm{cost}.read(item, value)) values.push_back(std::move(value));
    }
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<ReferenceValueSpec>& values) const {
    OrderedJson json = OrderedJson::array();
    for (const ReferenceValueSpec& value : values)
      json.push_back(*ReferenceValueForm{cost}.expand(value));
    return json;
  }
  OrderedJson schema(const std::vector<ReferenceValueSpec>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {{"type", "array"}, {"items", ReferenceValueForm::schema(definitions)}};
  }
};

void check_way_points(YamlMap& map, const ReferenceSpec& reference) {
  map.exclusive({"times", "knots"});
  const auto times = map.find("times"), knots = map.find("knots"), values = map.find("values");
  if (!values || !values->is_sequence()) return;
  const std::size_t count = values->node().items.size();
  const std::size_t places = reference.times.size() + reference.knots.size();
  if (count != places)
    values->error(fmt::format("there are {} values for {} {}", count, places,
                              reference.knots.empty() ? "times" : "knots"));
  else if (count == 0)
    values->error("there is no way-point");
}

/// Values at times, or at knots.
void describe_way_points(Keys& keys, bool at_knots, const CostSpec& cost,
                         ReferenceSpec& reference) {
  if (at_knots)
    keys.about({.title = "Way-points at knots",
                .examples = R"([{"knots": [0, 50], "values": [[0, 0, 1], [1, 0, 1]]}])"});
  else
    keys.about({.title = "Way-points in time",
                .examples = R"([{"times": [0, 50], "values": [[0, 0, 1], [1, 0, 1]]}])"});
  if (at_knots)
    keys({.name = "knots",
          .says = "Increasing: numbers from 0, or a phase, its first knot, and 'phase + 3'",
          .required = true},
         reference.knots, KnotsForm{});
  else
    keys({.name = "times", .says = "Increasing, s", .required = true}, reference.times,
         TimesForm{});
  keys({.name = "values", .says = at_knots ? "One a knot" : "One a time", .required = true},
       reference.values, ReferenceValuesForm{cost});
  if (YamlMap* map = keys.reading()) check_way_points(*map, reference);
}

}  // namespace

void describe(Keys& keys, DataFileSpec& file) {
  keys.about({.definition = "data_file",
              .title = "Columns of a file over time",
              .says = "A CSV file or a former solution and which of its columns to take",
              .examples = R"([{"file": "motion.csv", "columns": ["q/hip", "q/knee"]}])"});
  keys({.name = "file",
        .says = "CSV file with a header and a column t (s), or a solution.json; relative to the "
                "problem file",
        .required = true},
       file.file, NameForm{});
  keys({.name = "columns",
        .says = "Columns to read; by default those of the quantity itself",
        .fallback = "none",
        .omitted = file.columns.empty()},
       file.columns, NamesForm{});
  if (YamlMap* map = keys.reading()) file.path = map->reader().folder() / file.file.value;
}

bool OriginForm::read(const YamlReader& reader, CostSpec& cost) const {
  if (cost.definition->reference == nullptr) {
    reader.error(fmt::format("the residual '{}' has no reference", cost.definition->name));
    return false;
  }
  ReferenceSpec& reference = cost.reference.emplace();
  reference.place = reader.place();
  if (reader.has("file")) return read_map(reader, reference.file.emplace());
  if (reader.has("times") || reader.has("knots")) {
    GroupValue([&](Keys& keys) {
      describe_way_points(keys, !reader.has("times"), cost, reference);
    }).read(reader);
    return true;
  }
  if (ReferenceValueForm{cost}.read(reader, reference.values.emplace_back())) return true;
  cost.reference.reset();
  return false;
}

std::optional<OrderedJson> OriginForm::expand(const CostSpec& cost) const {
  const ReferenceForm* form = cost.definition->reference;
  if (form == nullptr) return std::nullopt;
  if (!cost.reference) {
    // Limits from the URDF are absolute and exclude a reference.
    const auto zero =
        cost.activation.from_urdf ? std::nullopt : form->zero(cost, cost.residual.place);
    return zero ? std::optional(form->expand(*zero)) : std::nullopt;
  }
  ReferenceSpec reference = *cost.reference;
  if (reference.file) return expand_map(*reference.file);
  if (reference.times.empty() && reference.knots.empty())
    return ReferenceValueForm{cost}.expand(reference.values[0]);
  return GroupValue([&](Keys& keys) {
           describe_way_points(keys, !reference.knots.empty(), cost, reference);
         })
      .expand();
}

OrderedJson OriginForm::schema(const CostSpec& cost, SchemaDefinitions& definitions) const {
  return defined(definitions, "reference", [&] {
    const auto way_points = [&](bool at_knots) {
      ReferenceSpec none;
      return GroupValue([&](Keys& keys) { describe_way_points(keys, at_knots, cost, none); })
          .schema(definitions);
    };
    return OrderedJson{{"title", "Reference"},
                       {"description",
                        "The name of a configuration, 'initial' for the initial state, numbers, a "
                        "state, a pose, a "
                        "velocity; way-points between which knots interpolate; or a file."},
                       {"anyOf",
                        {ReferenceValueForm::schema(definitions), way_points(false),
                         way_points(true), map_schema<DataFileSpec>(definitions)}},
                       {"examples", OrderedJson::parse(R"(["initial", {"values": {"theta": 3.14}},
           {"times": [0, 1.5], "values": [[0, 0, 1], [1, 0, 1]]}, {"file": "motion.csv"}])")}};
  });
}

}  // namespace conddp
