// Every key of problem files has an example, in a problem file or in a document for newcomers.
#include <set>

#include <gtest/gtest.h>

#include "schema_document.hpp"

namespace conddp {
namespace {

/// Name and meaning of a key, which mappings of several kinds may share.
using Key = std::pair<std::string, std::string>;

Key key_of(const std::string& name, const Json& schema) {
  return {name, schema.value("description", schema.value("title", schema.dump()))};
}

/// Keys below a part of the schema, except those of compiled functions, whose examples would need
/// a compiler.
void collect(const Json& part, std::set<Key>& keys) {
  if (part.is_object() && part.value("title", Json()) == "library") return;
  if (part.is_object() && part.contains("properties"))
    for (const auto& [name, schema] : part["properties"].items())
      if (const Key key = key_of(name, schema); !key.second.starts_with("For library"))
        keys.insert(key);
  for (const Json& inner : part)
    if (inner.is_structured()) collect(inner, keys);
}

/// Follows values through the schema and notes the keys of their mappings.
class UsedKeys {
 public:
  void note(const Json& document) { note(schema_, document); }
  const std::set<Key>& keys() const { return keys_; }
  const Json& schema() const { return schema_; }

 private:
  const Json& resolved(const Json& form) const {
    if (!form.contains("$ref")) return form;
    const std::string link = form["$ref"];
    return schema_.at(Json::json_pointer(link.substr(1)));
  }

  /// True if a mapping may have this form, by its keys and constants.
  bool fits(const Json& unresolved, const Json& value) const {
    const Json& form = resolved(unresolved);
    if (!value.is_object() || !form.contains("properties")) return true;
    for (const Json& name : form.value("required", Json::array()))
      if (!value.contains(name)) return false;
    const Json& properties = form["properties"];
    for (const auto& [name, inner] : value.items()) {
      if (!properties.contains(name)) return form.value("additionalProperties", Json()) != false;
      if (properties[name].contains("const") && properties[name]["const"] != inner) return false;
    }
    return true;
  }

  void note(const Json& unresolved, const Json& value) {
    const Json& form = resolved(unresolved);
    for (const char* word : {"allOf", "anyOf", "oneOf"})
      for (const Json& branch : form.value(word, Json::array()))
        if (fits(branch, value)) note(branch, value);
    if (value.is_array() && form.contains("items"))
      for (const Json& item : value) note(form["items"], item);
    if (value.is_object()) note_mapping(form, value);
  }

  void note_mapping(const Json& form, const Json& map) {
    const Json properties = form.value("properties", Json::object());
    const Json others = form.value("additionalProperties", Json());
    for (const auto& [name, value] : map.items()) {
      if (properties.contains(name)) keys_.insert(key_of(name, properties[name]));
      note(properties.value(name, others.is_object() ? others : Json::object()), value);
    }
  }

  Json schema_ = load_schema();
  std::set<Key> keys_;
};

void note_documents(UsedKeys& used) {
  for (const char* document : {"tutorial", "recipes", "mpc"}) {
    const std::string begin = "```yaml\n", end = "```\n";
    const std::string text = read_file(kProblems / ".." / "docs" / (document + std::string(".md")));
    for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
      at += begin.size();
      used.note(parse_to_json(text.substr(at, text.find(end, at) - at)));
    }
  }
}

TEST(Examples, UseEveryKey) {
  UsedKeys used;
  note_documents(used);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kProblems))
    if (entry.path().extension() == ".yaml" && entry.path().parent_path().stem() != "batches")
      used.note(parse_to_json(read_file(entry.path())));
  std::set<Key> keys;
  collect(used.schema(), keys);
  EXPECT_GT(keys.size(), 300u);
  for (const auto& [name, meaning] : keys)
    // Only rewritten files have parameters of a robot.
    EXPECT_TRUE(used.keys().contains({name, meaning}) || meaning.starts_with("States that rest"))
        << "no example has the key '" << name << "': " << meaning;
}

}  // namespace
}  // namespace conddp
