#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/values/keys.hpp"

namespace conddp {

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

  bool read(const YamlReader& reader, std::vector<T>& values) const {
    const auto entries = reader.named_entries(hint);
    if (!entries) return false;
    for (const auto& [own, value] : *entries) {
      T entry{};
      entry.*name = own;
      read_map(value, entry);
      values.push_back(std::move(entry));
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
    return {{"type", "object"}, {"additionalProperties", map_schema<T>(definitions)}};
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

void describe(Keys& keys, PoseSpec& pose);
void describe(Keys& keys, TwistSpec& twist);
void describe(Keys& keys, BaseSpec& base);
void describe(Keys& keys, StateSpec& state);
void describe(Keys& keys, NamedState& state);
/// The key `joints` of a state.
void describe_joints(Keys& keys, StateSpec& state);

}  // namespace conddp
