#pragma once

#include <functional>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "base/json/ordered_json.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Documentation of a key of a mapping.
struct KeyInfo {
  std::string_view name;
  std::string_view says = {};  ///< meaning, with the unit; empty: that of the value
  bool required = false;
  std::string_view examples = {};  ///< a JSON list
  /// Default as JSON if it is not the value of a new struct; "none": the key has no default.
  std::string_view fallback = {};
  bool omitted = false;  ///< expanded files leave the key out
};

/// Documentation of a mapping.
struct MapInfo {
  std::string_view definition = {};  ///< name among the schema's definitions; empty: in place
  std::string_view title;
  std::string_view says = {};
  std::string_view examples;  ///< a JSON list
  /// Rules between keys, members of a JSON object: `"not": {"required": ["a", "b"]}`.
  std::string_view rules = {};
};

/// The schema's definitions that have been written so far, by name.
using SchemaDefinitions = OrderedJson;

/// The value of a key in its three forms: YAML, JSON with all defaults, and JSON Schema.
class KeyValue {
 public:
  virtual ~KeyValue() = default;
  /// Stores a valid value; an invalid one is reported.
  virtual void read(const YamlReader& reader) = 0;
  /// JSON that `read` reads as the same value; empty if the key is omitted.
  virtual std::optional<OrderedJson> expand() const = 0;
  virtual OrderedJson schema(SchemaDefinitions& definitions) const = 0;
  /// True if the schema shows the value of a new struct as the default.
  virtual bool has_default() const { return true; }
};

/// Visitor of a mapping's keys. Each struct of a problem file has one function
/// `describe(Keys&, Struct&)`, which reader, expansion and schema share.
class Keys {
 public:
  virtual ~Keys() = default;
  /// Precedes the keys.
  virtual void about(const MapInfo& /*info*/) {}
  /// Describes a key whose value has a form of key_forms.hpp. `T` is the form's type, or it
  /// Located or optional: with its place, or absent by default.
  template <class T, class Form>
  void operator()(const KeyInfo& key, T& value, const Form& form);
  /// The same with a CustomValue or a GroupValue.
  template <class Value>
  void operator()(const KeyInfo& key, Value value) {
    visit(key, value);
  }
  virtual void visit(const KeyInfo& key, KeyValue& value) = 0;
  /// At most one of these keys may be present.
  virtual void exclusive(std::initializer_list<std::string_view> /*keys*/) {}
  /// A key of former versions is an error with this hint.
  virtual void removed(std::string_view /*name*/, std::string_view /*hint*/) {}
  /// The mapping while it is read, for checks of several keys; otherwise null.
  virtual YamlMap* reading() { return nullptr; }
  /// The value of a key while the mapping is read and has it.
  std::optional<YamlReader> found(std::string_view key);
  /// Reports an error of the mapping while it is read.
  void error(std::string message, std::string hint = {});
  /// Number of errors so far while the mapping is read.
  int errors();
  /// True if the keys are documented, where those of all kinds of a mapping count.
  virtual bool documents() const { return false; }
};

/// A value with its own functions, for keys that no form fits. Without an expander it is omitted.
struct CustomValue final : KeyValue {
  CustomValue(std::function<void(const YamlReader&)> reader,
              std::function<std::optional<OrderedJson>()> expander, std::string_view schema_text)
      : reader_(std::move(reader)), expander_(std::move(expander)), schema_(schema_text) {}
  void read(const YamlReader& reader) override { reader_(reader); }
  std::optional<OrderedJson> expand() const override {
    return expander_ ? expander_() : std::nullopt;
  }
  OrderedJson schema(SchemaDefinitions& /*definitions*/) const override {
    return OrderedJson::parse(schema_);
  }
  bool has_default() const override { return false; }

 private:
  std::function<void(const YamlReader&)> reader_;
  std::function<std::optional<OrderedJson>()> expander_;
  std::string_view schema_;
};

namespace detail {

template <class T, class Form>
bool read_as(const Form& form, const YamlReader& reader, T& value) {
  return form.read(reader, value);
}
template <class T, class Form>
bool read_as(const Form& form, const YamlReader& reader, Located<T>& value) {
  value.place = reader.place();
  return read_as(form, reader, value.value);
}
template <class T, class Form>
bool read_as(const Form& form, const YamlReader& reader, std::optional<T>& value) {
  T read = value.value_or(T{});
  if (!read_as(form, reader, read)) return false;
  value = std::move(read);
  return true;
}

template <class T, class Form>
std::optional<OrderedJson> expand_as(const Form& form, const T& value) {
  return form.expand(value);
}
template <class T, class Form>
std::optional<OrderedJson> expand_as(const Form& form, const Located<T>& value) {
  return expand_as(form, value.value);
}
template <class T, class Form>
std::optional<OrderedJson> expand_as(const Form& form, const std::optional<T>& value) {
  return value ? expand_as(form, *value) : std::nullopt;
}

/// The value itself, or a new one if it is absent.
template <class T>
T plain(const T& value) {
  return value;
}
template <class T>
T plain(const Located<T>& value) {
  return value.value;
}
template <class T>
auto plain(const std::optional<T>& value) {
  return plain(value.value_or(T{}));
}

template <class T, class Form>
OrderedJson schema_as(const Form& form, const T& value, SchemaDefinitions& definitions) {
  if constexpr (requires { form.schema(); })
    return form.schema();
  else
    return form.schema(plain(value), definitions);
}

/// A variable that a form reads and expands.
template <class T, class Form>
struct FormValue final : KeyValue {
  FormValue(T& variable, const Form& its_form) : value(variable), form(its_form) {}
  void read(const YamlReader& reader) override { read_as(form, reader, value); }
  std::optional<OrderedJson> expand() const override { return expand_as(form, value); }
  OrderedJson schema(SchemaDefinitions& definitions) const override {
    return schema_as(form, value, definitions);
  }
  bool has_default() const override {
    return requires { form.schema(); };
  }

  T& value;
  const Form& form;
};

}  // namespace detail

template <class T, class Form>
void Keys::operator()(const KeyInfo& key, T& value, const Form& form) {
  detail::FormValue<T, Form> bound(value, form);
  visit(key, bound);
}

/// Reads the keys of a mapping.
class KeyReader final : public Keys {
 public:
  explicit KeyReader(YamlMap& map) : map_(map) {}
  void visit(const KeyInfo& key, KeyValue& value) override;
  void exclusive(std::initializer_list<std::string_view> keys) override { map_.exclusive(keys); }
  void removed(std::string_view name, std::string_view hint) override;
  YamlMap* reading() override { return &map_; }

 private:
  YamlMap& map_;
};

/// Expands the keys of a mapping.
class KeyWriter final : public Keys {
 public:
  void visit(const KeyInfo& key, KeyValue& value) override;
  OrderedJson json = OrderedJson::object();
};

/// Writes the JSON Schema of a mapping. Definitions that occur in it are added to the others.
class KeySchema final : public Keys {
 public:
  explicit KeySchema(SchemaDefinitions& definitions) : definitions_(definitions) {}
  bool documents() const override { return true; }
  void about(const MapInfo& info) override;
  void visit(const KeyInfo& key, KeyValue& value) override;
  void exclusive(std::initializer_list<std::string_view> keys) override;
  /// The schema, or a reference to it if it is a definition.
  OrderedJson schema();

 private:
  SchemaDefinitions& definitions_;
  MapInfo info_;
  bool is_known_ = false;  ///< the definition is written already, or being written
  OrderedJson properties_ = OrderedJson::object(), required_ = OrderedJson::array();
  OrderedJson rules_ = OrderedJson::object();
};

/// Reads a mapping, and its place if the struct has one; false if the node is no mapping, which is
/// reported with the hint.
template <class T>
bool read_map(const YamlReader& reader, T& value, std::string_view hint = {}) {
  if constexpr (requires { value.place = reader.place(); }) value.place = reader.place();
  YamlMap map(reader, hint);
  if (!map.valid()) return false;
  KeyReader keys(map);
  describe(keys, value);
  return true;
}

template <class T>
OrderedJson expand_map(T value) {
  KeyWriter keys;
  describe(keys, value);
  return std::move(keys.json);
}

/// The schema of a mapping, or a reference to its definition. `value`: a new one.
template <class T>
OrderedJson map_schema(SchemaDefinitions& definitions, T value = {}) {
  KeySchema keys(definitions);
  describe(keys, value);
  return keys.schema();
}

/// A mapping whose keys belong to the struct around it. It is omitted without keys.
struct GroupValue final : KeyValue {
  explicit GroupValue(std::function<void(Keys&)> its_keys, std::string_view its_hint = {})
      : describe(std::move(its_keys)), hint(its_hint) {}
  void read(const YamlReader& reader) override;
  std::optional<OrderedJson> expand() const override;
  OrderedJson schema(SchemaDefinitions& definitions) const override;
  bool has_default() const override { return false; }

  std::function<void(Keys&)> describe;
  std::string_view hint;
};

}  // namespace conddp
