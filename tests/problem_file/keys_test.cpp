// Descriptions of keys: what reader, expansion and schema make of one.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "problem_file/values/key_forms.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {
namespace {

struct Wheel {
  Name name;
  double radius = 0.3;
};

struct Cart {
  Place place;
  double mass = 0;
  std::optional<Located<int>> seats;
  double drag = 0.1, lift = 0.2;
  std::vector<Wheel> wheels;
};

}  // namespace

static void describe(Keys& keys, Wheel& wheel) {
  keys.about({.definition = "wheel", .title = "Wheel", .examples = R"([{"radius": 1}])"});
  keys({"radius", "Radius, m"}, wheel.radius, NumberForm{kPositive});
}

static void describe(Keys& keys, Cart& cart) {
  keys.about({.title = "Cart", .says = "On wheels", .examples = R"([{"mass": 1}])"});
  keys({.name = "mass", .says = "Mass, kg", .required = true}, cart.mass, NumberForm{kPositive});
  keys({"seats", "Seats"}, cart.seats, IntegerForm{1, 9});
  keys({"air", "Forces of the air"}, GroupValue([&](Keys& air) {
         air.about({.title = "Air", .examples = "[{}]"});
         air({"drag", "Drag, N"}, cart.drag, NumberForm{});
         air({.name = "lift", .says = "Lift, N", .fallback = "none"}, cart.lift, NumberForm{});
         air.exclusive({"drag", "lift"});
       }));
  keys({.name = "wheels", .says = "Wheels by name", .fallback = "{}"}, cart.wheels,
       EntriesForm{&Wheel::name});
}

namespace {

/// A cart read from a text, with its diagnostics.
struct CartFile {
  explicit CartFile(const std::string& text) {
    const auto node = parse_yaml(text, out.add_source("cart.yaml", text), out);
    valid = node && read_map(YamlReader(*node, "", out), cart, "write '{mass: 1}'");
    messages = format_diagnostics(out, false);
  }
  Diagnostics out;
  Cart cart;
  bool valid = false;
  std::string messages;
};

TEST(Keys, ReadsValuesWithTheirPlaces) {
  const CartFile read(
      "mass: 2\nseats: 4\nair: {drag: 3}\nwheels: {front: {radius: 0.5}, back: {}}\n");
  EXPECT_EQ(read.messages, "");
  EXPECT_EQ(read.cart.mass, 2);
  ASSERT_TRUE(read.cart.seats);
  EXPECT_EQ(read.cart.seats->value, 4);
  EXPECT_EQ(read.cart.seats->place.path, "seats");
  EXPECT_EQ(read.cart.drag, 3);
  ASSERT_EQ(read.cart.wheels.size(), 2u);
  EXPECT_EQ(read.cart.wheels[0].name.value, "front");
  EXPECT_EQ(read.cart.wheels[0].radius, 0.5);
  EXPECT_EQ(read.cart.wheels[1].radius, 0.3);
}

TEST(Keys, ReportsFaultsWhereTheyStand) {
  const CartFile wrong("mass: -1\nair: {drag: 1, lift: 2, push: 3}\n");
  EXPECT_NE(wrong.messages.find("cart.yaml:1:7: error: a positive number"), std::string::npos)
      << wrong.messages;
  EXPECT_NE(wrong.messages.find("cart.yaml:2:16: error: 'drag' and 'lift' exclude each other"),
            std::string::npos);
  EXPECT_NE(wrong.messages.find("cart.yaml:2:25: error: unknown key 'push' in 'air'"),
            std::string::npos);
  EXPECT_EQ(wrong.cart.mass, 0);
  EXPECT_NE(CartFile("seats: 3").messages.find("the key 'mass' is missing"), std::string::npos);
  const CartFile list("[1]");
  EXPECT_FALSE(list.valid);
  EXPECT_NE(list.messages.find("hint: write '{mass: 1}'"), std::string::npos);
}

TEST(Keys, ExpandsDefaultsButNoAbsentKeys) {
  const CartFile read("mass: 2\nwheels: {a: {}}\n");
  EXPECT_EQ(expand_map(read.cart), OrderedJson::parse(R"({
    "mass": 2.0, "air": {"drag": 0.1, "lift": 0.2}, "wheels": {"a": {"radius": 0.3}}})"));
}

TEST(Keys, WritesTheSchema) {
  SchemaDefinitions definitions = OrderedJson::object();
  const OrderedJson schema = map_schema<Cart>(definitions);
  // Without the order of the keys.
  EXPECT_EQ(nlohmann::json::parse(schema.dump()), nlohmann::json::parse(R"({
    "type": "object", "title": "Cart", "description": "On wheels",
    "properties": {
      "mass": {"type": "number", "exclusiveMinimum": 0.0, "description": "Mass, kg"},
      "seats": {"type": "integer", "minimum": 1, "maximum": 9, "description": "Seats"},
      "air": {
        "type": "object", "title": "Air",
        "properties": {
          "drag": {"type": "number", "description": "Drag, N", "default": 0.1},
          "lift": {"type": "number", "description": "Lift, N"}
        },
        "additionalProperties": false, "not": {"required": ["drag", "lift"]}, "examples": [{}],
        "description": "Forces of the air"
      },
      "wheels": {"type": "object", "additionalProperties": {"$ref": "#/definitions/wheel"},
                 "description": "Wheels by name", "default": {}}
    },
    "required": ["mass"], "additionalProperties": false, "examples": [{"mass": 1}]})"))
      << schema.dump(1);
  EXPECT_EQ(definitions["wheel"]["properties"]["radius"]["default"], 0.3);
  EXPECT_EQ(map_schema<Wheel>(definitions), OrderedJson({{"$ref", "#/definitions/wheel"}}));
}

}  // namespace
}  // namespace conddp
