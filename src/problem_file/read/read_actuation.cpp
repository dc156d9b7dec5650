#include <cmath>

#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// A number; null means `none`.
struct LimitForm {
  double none;
  bool read(const YamlReader& reader, double& value) const {
    const auto limit = reader.is_null() ? none : reader.number();
    value = limit.value_or(value);
    return limit.has_value();
  }
  std::optional<OrderedJson> expand(double value) const { return finite_or_null(value); }
  OrderedJson schema() const { return {{"type", {"number", "null"}}}; }
};

}  // namespace

static void describe(Keys& keys, ThrusterSpec& thruster) {
  keys.about({.definition = "thruster",
              .title = "Thruster",
              .says = "A rotor or jet: one control that pushes and twists a floating base",
              .examples = R"([{"name": "front", "frame": "rotor_front", "torque_ratio": 0.0245,
                               "upper": 12}])"});
  keys({.name = "name", .says = "Of its control", .required = true}, thruster.name, NameForm{});
  keys({.name = "frame",
        .says = "Frame fixed to the floating base in whose origin it pushes",
        .required = true},
       thruster.frame, NameForm{});
  keys({"direction", "Direction of the force in the frame; its length does not matter"},
       thruster.direction, DirectionForm{});
  keys({"torque_ratio", "Torque about the direction for each unit of force, Nm per N"},
       thruster.torque_ratio, NumberForm{});
  keys({"lower", "Smallest force, N; null: no limit"}, thruster.lower, LimitForm{-kUnlimited});
  keys({"upper", "Largest force, N; null: no limit"}, thruster.upper, LimitForm{kUnlimited});
  if (thruster.lower > thruster.upper)
    keys.error(fmt::format("the lower limit {} is above the upper limit {}", thruster.lower,
                           thruster.upper));
}

static void describe(Keys& keys, ActuationSpec& actuation) {
  keys.about({.title = "Thrusters and joints",
              .examples = R"([{"joints": ["hip", "knee"]},
                              {"thrusters": [{"name": "front", "frame": "rotor_front"}]}])",
              .rules = R"("anyOf": [{"required": ["joints"]}, {"required": ["thrusters"]}])"});
  keys({.name = "joints", .says = "Actuated joints", .fallback = "none"}, actuation.joints,
       NamesForm{});
  keys({"thrusters", "Rotors or jets on the floating base"}, actuation.thrusters, MapsForm{});
  if (!keys.found("joints") && !keys.found("thrusters"))
    keys.error("'joints' or 'thrusters' is expected here", "or write 'actuation: none'");
}

bool ActuationForm::read(const YamlReader& reader, ActuationSpec& actuation) const {
  if (!reader.is_scalar()) {
    actuation.full = false;
    return read_map(reader, actuation);
  }
  const auto full = reader.choice(kActuationWords, "actuation (nor a mapping)");
  actuation.full = full.value_or(true);
  return full.has_value();
}

std::optional<OrderedJson> ActuationForm::expand(const ActuationSpec& actuation) const {
  if (actuation.full || (actuation.joints.empty() && actuation.thrusters.empty()))
    return OrderedJson(word_of(kActuationWords, actuation.full));
  return expand_map(actuation);
}

OrderedJson ActuationForm::schema(const ActuationSpec& /*names the type*/,
                                  SchemaDefinitions& definitions) const {
  const WordForm words(kActuationWords, "");
  definitions["actuation"] = {
      {"title", "Actuation"},
      {"description",
       "full: a generalized force on every joint but those of the base; none: no actuators; or the "
       "thrusters and joints that there are"},
      {"default", "full"},
      {"anyOf", {words.schema(), map_schema<ActuationSpec>(definitions)}},
      {"examples", OrderedJson::parse(R"(["full", {"joints": ["slider"]}])")}};
  return {{"$ref", "#/definitions/actuation"}};
}

}  // namespace conddp
