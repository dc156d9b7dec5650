#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "problem_file/model/spec_expression.hpp"
#include "problem_file/model/spec_values.hpp"
#include "problem_file/yaml/keys.hpp"

namespace conddp {

/// The definition of a schema with this name, made once, as a reference.
template <class Make>
OrderedJson defined(SchemaDefinitions& definitions, const char* name, Make make) {
  if (!definitions.contains(name)) {
    definitions[name];
    OrderedJson schema = make();
    definitions[name] = std::move(schema);
  }
  return {{"$ref", std::string("#/definitions/") + name}};
}

/// Forms of values: how each is read, expanded, and documented. `read` returns false with an error
/// and leaves the value; `expand` is empty for a value that the file omits.

struct NumberForm {
  NumberRange range = kAnyNumber;
  bool read(const YamlReader& reader, double& value) const;
  std::optional<OrderedJson> expand(double value) const;  ///< empty if not finite
  OrderedJson schema() const;
};

struct IntegerForm {
  long long lower = 0, upper = 0;
  template <class T>
  bool read(const YamlReader& reader, T& value) const {
    const auto number = reader.integer(lower, upper);
    if (number) value = static_cast<T>(*number);
    return number.has_value();
  }
  template <class T>
  std::optional<OrderedJson> expand(T value) const {
    return OrderedJson(value);
  }
  OrderedJson schema() const;
};

/// A knot: its number, a phase (its first knot), or 'phase + 3', 'phase - 1'.
struct KnotForm {
  bool read(const YamlReader& reader, KnotSpec& knot) const;
  std::optional<OrderedJson> expand(const KnotSpec& knot) const;
  OrderedJson schema() const;
};

/// Knots in a list.
struct KnotsForm {
  bool read(const YamlReader& reader, std::vector<KnotSpec>& knots) const;
  std::optional<OrderedJson> expand(const std::vector<KnotSpec>& knots) const;
  OrderedJson schema() const;
};

/// A word of a table. `what`: "integrator".
template <class E, std::size_t N>
struct WordForm {
  WordForm(const Choice<E> (&words)[N], std::string_view meaning) : table(words), what(meaning) {}
  bool read(const YamlReader& reader, E& value) const {
    const auto chosen = reader.choice(table, what);
    if (chosen) value = *chosen;
    return chosen.has_value();
  }
  std::optional<OrderedJson> expand(E value) const {
    for (const Choice<E>& entry : table)
      if (entry.value == value) return OrderedJson(entry.word);
    return std::nullopt;
  }
  OrderedJson schema() const {
    OrderedJson words = OrderedJson::array();
    for (const Choice<E>& entry : table) words.push_back(entry.word);
    return {{"enum", std::move(words)}};
  }
  const Choice<E> (&table)[N];
  std::string_view what;
};

struct FlagForm {
  std::string_view what;
  bool read(const YamlReader& reader, bool& value) const;
  std::optional<OrderedJson> expand(bool value) const { return OrderedJson(value); }
  OrderedJson schema() const { return {{"type", "boolean"}}; }
};

struct NameForm {
  bool read(const YamlReader& reader, std::string& value) const;
  std::optional<OrderedJson> expand(const std::string& value) const { return OrderedJson(value); }
  OrderedJson schema() const { return {{"type", "string"}, {"minLength", 1}}; }
};

/// A list of names, each at most once.
struct NamesForm {
  bool read(const YamlReader& reader, std::vector<Name>& value) const;
  std::optional<OrderedJson> expand(const std::vector<Name>& value) const;
  OrderedJson schema() const;
};

/// The same, or a single name.
struct NameOrNamesForm : NamesForm {
  std::string_view empty = {};  ///< what an empty list lacks: "phase"
  bool read(const YamlReader& reader, std::vector<Name>& value) const;
  OrderedJson schema() const;
};

/// `all`, a name, or a list of names.
struct ContactNamesForm {
  bool read(const YamlReader& reader, ContactNames& value) const;
  std::optional<OrderedJson> expand(const ContactNames& value) const;
  OrderedJson schema(const ContactNames& value, SchemaDefinitions& definitions) const;
};

/// A motion of a base in the plane: [x, y, yaw] or [x, y, yaw, rise].
struct MotionForm {
  bool read(const YamlReader& reader, PlanarMotion& value) const;
  std::optional<OrderedJson> expand(const PlanarMotion& value) const;
};

/// Constants of expressions. The reader of formulas reads them before all other keys.
struct ParametersForm {
  bool read(const YamlReader& /*reader*/, ExpressionNamesSpec& /*names*/) const { return true; }
  std::optional<OrderedJson> expand(const ExpressionNamesSpec& names) const;
  OrderedJson schema(const ExpressionNamesSpec& names, SchemaDefinitions& definitions) const;
};

struct ExpressionForm {
  bool read(const YamlReader& reader, ExpressionText& value) const;
  std::optional<OrderedJson> expand(const ExpressionText& value) const { return value.text; }
  OrderedJson schema(const ExpressionText& value, SchemaDefinitions& definitions) const;
};

struct NumbersForm {
  bool read(const YamlReader& reader, std::vector<double>& value) const;
  std::optional<OrderedJson> expand(const std::vector<double>& value) const {
    return OrderedJson(value);
  }
  OrderedJson schema() const { return {{"type", "array"}, {"items", {{"type", "number"}}}}; }
};

/// Three numbers. `what`: "[x, y, z] in m".
struct VectorForm {
  std::string_view what;
  bool read(const YamlReader& reader, Vector3<double>& value) const;
  std::optional<OrderedJson> expand(const Vector3<double>& value) const;
  OrderedJson schema() const;
};

/// A vector that is scaled to unit length.
struct DirectionForm : VectorForm {
  DirectionForm() : VectorForm{"a direction [x, y, z]"} {}
  bool read(const YamlReader& reader, Vector3<double>& value) const;
};

struct NamedNumbersForm {
  NumberRange range = kAnyNumber;
  bool may_be_missing = false;  ///< omitted without numbers
  bool read(const YamlReader& reader, NamedNumbers& value) const;
  std::optional<OrderedJson> expand(const NamedNumbers& value) const;
  OrderedJson schema() const;
};

struct ComponentsForm {
  NumberRange range = kAnyNumber;
  bool read(const YamlReader& reader, ComponentsSpec& value) const;
  std::optional<OrderedJson> expand(const ComponentsSpec& value) const;
  OrderedJson schema() const;
};

/// Bounds by component; null means unbounded.
struct BoundsForm : ComponentsForm {
  bool read(const YamlReader& reader, ComponentsSpec& value) const;
  OrderedJson schema() const;
};

/// A mapping whose struct is described.
struct MapForm {
  std::string_view hint = {};
  template <class T>
  bool read(const YamlReader& reader, T& value) const {
    return read_map(reader, value, hint);
  }
  template <class T>
  std::optional<OrderedJson> expand(const T& value) const {
    return expand_map(value);
  }
  template <class T>
  OrderedJson schema(const T& /*names the type*/, SchemaDefinitions& definitions) const {
    return map_schema<T>(definitions);
  }
};

/// A word for whether something is the case; its place says that it is.
template <std::size_t N>
struct PlacedWord final : KeyValue {
  PlacedWord(const Choice<bool> (&words)[N], std::string_view what, std::optional<Place>& its_place)
      : form(words, what), place(its_place) {}
  void read(const YamlReader& reader) override {
    bool chosen = false;
    if (form.read(reader, chosen) && chosen) place = reader.place();
  }
  std::optional<OrderedJson> expand() const override { return form.expand(place.has_value()); }
  OrderedJson schema(SchemaDefinitions& /*definitions*/) const override { return form.schema(); }

  WordForm<bool, N> form;
  std::optional<Place>& place;
};

/// A list of mappings.
struct MapsForm {
  std::string_view hint = {};
  template <class T>
  bool read(const YamlReader& reader, std::vector<T>& values) const {
    const auto items = reader.items();
    if (!items) return false;
    values.clear();
    for (const YamlReader& item : *items) read_map(item, values.emplace_back(), hint);
    return true;
  }
  template <class T>
  std::optional<OrderedJson> expand(const std::vector<T>& values) const {
    OrderedJson list = OrderedJson::array();
    for (const T& value : values) list.push_back(expand_map(value));
    return list;
  }
  template <class T>
  OrderedJson schema(const std::vector<T>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {{"type", "array"}, {"items", map_schema<T>(definitions)}};
  }
};

/// Mappings by free names, with the name in a member of their struct.
template <class T>
struct EntriesForm {
  Name T::*name;
  std::string_view hint = {};
  bool may_be_missing = false;  ///< omitted without entries
  T initial = {};
  std::string_view entry_hint = {};

  bool read(const YamlReader& reader, std::vector<T>& values) const {
    const auto entries = reader.named_entries(hint);
    if (!entries) return false;
    for (const auto& [own, value] : *entries) {
      T& entry = values.emplace_back(initial);
      entry.*name = own;
      read_map(value, entry, entry_hint);
    }
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<T>& values) const {
    if (values.empty() && may_be_missing) return std::nullopt;
    OrderedJson json = OrderedJson::object();
    for (const T& value : values) json[(value.*name).value] = expand_map(value);
    return json;
  }
  OrderedJson schema(const std::vector<T>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {{"type", "object"}, {"additionalProperties", map_schema(definitions, initial)}};
  }
};

/// One alternative of a variant, a mapping.
template <class T>
struct AlternativeForm {
  template <class Variant>
  bool read(const YamlReader& reader, Variant& value) const {
    T read{};
    if (!read_map(reader, read)) return false;
    value = std::move(read);
    return true;
  }
  template <class Variant>
  std::optional<OrderedJson> expand(const Variant& value) const {
    const T* held = std::get_if<T>(&value);
    return held != nullptr ? std::optional(expand_map(*held)) : std::nullopt;
  }
  template <class Variant>
  OrderedJson schema(const Variant& /*of any alternative*/, SchemaDefinitions& definitions) const {
    return map_schema<T>(definitions);
  }
};

/// A unit quaternion [x, y, z, w].
struct QuaternionForm {
  bool read(const YamlReader& reader, Quaternion<double>& value) const;
  std::optional<OrderedJson> expand(const Quaternion<double>& value) const;
  OrderedJson schema() const;
};

/// Six numbers, or a mapping with the linear and the angular velocity.
struct TwistForm {
  bool read(const YamlReader& reader, TwistSpec& value) const;
  std::optional<OrderedJson> expand(const TwistSpec& value) const;
  OrderedJson schema(const TwistSpec& value, SchemaDefinitions& definitions) const;
};

/// Definitions of the values that forms only refer to.
SchemaDefinitions value_definitions();

/// Hint for the value of a state.
inline constexpr std::string_view kStateHint =
    "write '{values: {x: 0.5}}', '{state: [0.5, 0]}', or of a robot '{joints: {knee: 0.5}}' or "
    "'{configuration: NAME}'";
std::optional<StateSpec> read_state(const YamlReader& reader);

void describe(Keys& keys, PoseSpec& pose);
void describe(Keys& keys, TwistSpec& twist);
void describe(Keys& keys, BaseSpec& base);
void describe(Keys& keys, StateSpec& state);
void describe(Keys& keys, NamedState& state);
void describe(Keys& keys, PlacedFrame& frame);
/// The keys `joints` and `frames` of a state.
void describe_posture(Keys& keys, StateSpec& state);

}  // namespace conddp
