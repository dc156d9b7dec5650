#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "problem_file/yaml/synonyms.hpp"
#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Range of accepted numbers.
struct NumberRange {
  double lower;
  double upper;
  bool lower_open;  ///< excludes the lower end
  bool upper_open;
  std::string_view words;  ///< "a positive number"

  bool contains(double value) const {
    return (lower_open ? value > lower : value >= lower) &&
           (upper_open ? value < upper : value <= upper);
  }
};
extern const NumberRange kAnyNumber;
extern const NumberRange kPositive;
extern const NumberRange kNotNegative;

/// One accepted word of an enumerated key.
template <class E>
struct Choice {
  std::string_view word;
  E value;
  std::string_view description = {};  ///< one line, for lists that explain the words
};

/// A node with its key path and its destination for errors. Every method that returns an empty
/// optional has reported the reason. Cheap to copy; the node must outlive it.
class YamlReader {
 public:
  /// `folder`, from which relative paths in the file start, must outlive the reader; null: the
  /// working directory.
  YamlReader(const YamlNode& node, std::string path, Diagnostics& out,
             const std::filesystem::path* folder = nullptr)
      : node_(&node), path_(std::move(path)), out_(&out), folder_(folder) {}
  /// A reader of another node of the same file.
  YamlReader at(const YamlNode& node, std::string path) const {
    return {node, std::move(path), *out_, folder_};
  }

  const YamlNode& node() const { return *node_; }
  Place place() const { return {node_->mark, path_}; }
  Diagnostics& diagnostics() const { return *out_; }
  std::filesystem::path folder() const { return folder_ != nullptr ? *folder_ : ""; }
  /// True for a mapping with the key.
  bool has(std::string_view key) const { return is_map() && node_->find(key) != nullptr; }
  bool is_null() const { return node_->kind == YamlNode::Kind::kNull; }
  bool is_scalar() const { return node_->kind == YamlNode::Kind::kScalar; }
  bool is_sequence() const { return node_->kind == YamlNode::Kind::kSequence; }
  bool is_map() const { return node_->kind == YamlNode::Kind::kMap; }
  bool is_number() const;
  void error(std::string message, std::string hint = {}) const;
  /// "<what> is expected here, not <what was found>".
  void expected(std::string_view what, std::string hint = {}) const;

  std::optional<double> number(const NumberRange& range = kAnyNumber) const;
  /// An integer without decimal point or exponent.
  std::optional<long long> integer(long long lower, long long upper) const;
  /// A word or quoted text; must not be empty.
  std::optional<std::string> text() const;
  std::optional<Name> name() const;
  /// The elements of a list; empty with an error otherwise. `hint` may show the correct form.
  std::optional<std::vector<YamlReader>> items(std::string_view hint = {}) const;
  std::optional<std::vector<double>> numbers() const;
  /// Exactly `count` numbers; `what` describes them: "[x, y, z] in m".
  std::optional<std::vector<double>> numbers(std::size_t count, std::string_view what) const;
  std::optional<std::vector<Name>> names() const;
  /// A list of names; a single name stands for a list with one entry.
  std::optional<std::vector<Name>> name_or_names() const;
  /// The value of an accepted word. `what`: "integrator".
  template <class E, std::size_t N>
  std::optional<E> choice(const Choice<E> (&table)[N], std::string_view what) const {
    std::vector<std::string> words;
    for (const auto& entry : table) words.emplace_back(entry.word);
    const std::optional<std::size_t> index = choose(words, what);
    if (!index) return std::nullopt;
    return table[*index].value;
  }
  /// The same, but returns the index. `more`: names of these words in other tools.
  std::optional<std::size_t> choose(const std::vector<std::string>& words, std::string_view what,
                                    const std::vector<Synonyms>& more = {}) const;
  /// Entries with free names (costs, joints, ...) in the order of the file; not for fixed keys.
  /// `hint`, shown with an error, may give the correct form.
  std::optional<std::vector<std::pair<Name, YamlReader>>> named_entries(
      std::string_view hint = {}) const;

 private:
  const YamlNode* node_;
  std::string path_;
  Diagnostics* out_;
  const std::filesystem::path* folder_;
};

/// A mapping with a fixed set of keys. Query each accepted key with find; `finish` (or the
/// destructor) reports all others. A node that is not a mapping is reported, with `hint`, and then
/// every key is absent.
class YamlMap {
 public:
  explicit YamlMap(const YamlReader& reader, std::string_view hint = {});
  ~YamlMap() { finish(); }
  YamlMap(const YamlMap&) = delete;
  YamlMap& operator=(const YamlMap&) = delete;

  /// The value of a key. A key with an empty value is present, as a null that no method accepts.
  std::optional<YamlReader> find(std::string_view key);
  /// The same, but reports a missing key.
  std::optional<YamlReader> require(std::string_view key);
  /// Reports an error and returns false if more than one of these alternative keys is present.
  bool exclusive(std::initializer_list<std::string_view> keys);
  bool valid() const { return valid_; }
  const YamlReader& reader() const { return reader_; }

  bool integer(std::string_view key, int& value, int lower, int upper);
  template <class E, std::size_t N>
  void choice(std::string_view key, E& value, const Choice<E> (&table)[N], std::string_view what) {
    if (const auto reader = find(key)) value = reader->choice(table, what).value_or(value);
  }

  /// Reports unknown keys now.
  void finish();
  /// Accepts all other keys, for mappings whose keys cannot be determined.
  void ignore_others() { finished_ = true; }

 private:
  std::string hint_by_name(const YamlNode::Entry& entry) const;
  void report_unknown(const YamlNode::Entry& entry) const;

  YamlReader reader_;
  bool valid_;
  bool finished_ = false;
  std::vector<std::string> known_;
};

}  // namespace conddp
