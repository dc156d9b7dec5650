#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "base/random_numbers.hpp"
#include "batch/plan/axis.hpp"
#include "batch/plan/axis_table.hpp"
#include "batch/plan/sobol.hpp"

namespace conddp {
namespace {

constexpr const char* kKinds =
    "write one of 'linspace', 'values', 'file', 'perturb', 'uniform', 'normal' and 'sobol'";

/// Parts of an instance that can be perturbed.
struct PerturbedPart {
  const char *word, *key;
};
constexpr PerturbedPart kPerturbed[] = {{"initial_state", "perturbation.initial_state"},
                                        {"guess", "perturbation.guess"}};

YamlNode number_node(double value, const Mark& mark) {
  return {.kind = YamlNode::Kind::kScalar, .mark = mark, .text = fmt::format("{}", value)};
}

/// Reads the keys of one axis.
class AxisReader {
 public:
  AxisReader(const Name& name, const YamlReader& reader, const std::filesystem::path& folder)
      : map_(reader, "write '{key: costs.effort.weight, values: [0.1, 1]}'"), folder_(folder) {
    axis_.name = name;
  }

  Axis read() {
    if (!map_.valid()) return std::move(axis_);
    const std::pair<const char*, void (AxisReader::*)(const YamlReader&)> kinds[] = {
        {"linspace", &AxisReader::read_linspace}, {"values", &AxisReader::read_values},
        {"file", &AxisReader::read_file},         {"perturb", &AxisReader::read_perturb},
        {"uniform", &AxisReader::read_uniform},   {"normal", &AxisReader::read_normal},
        {"sobol", &AxisReader::read_sobol}};
    if (!map_.exclusive({"linspace", "values", "file", "perturb", "uniform", "normal", "sobol"})) {
      map_.ignore_others();
      return std::move(axis_);
    }
    for (const auto& [word, read] : kinds)
      if (const auto r = map_.find(word)) {
        (this->*read)(*r);
        return std::move(axis_);
      }
    map_.reader().error(fmt::format("the values of '{}' are missing", axis_.name.value), kKinds);
    map_.ignore_others();
    return std::move(axis_);
  }

 private:
  /// Reads the key of an axis with a single key.
  void read_key() {
    if (const auto key = map_.require("key"))
      if (const auto path = key->name()) axis_.columns.push_back({axis_.name.value, *path});
  }

  void add_number(double value, const Mark& mark) {
    axis_.rows.push_back({number_node(value, mark)});
  }

  void read_linspace(const YamlReader& reader) {
    read_key();
    constexpr const char* kForm = "[first, last, count]";
    const auto items = reader.items("write '[0.3, 0.6, 20]'");
    if (!items) return;
    if (items->size() != 3) return reader.expected(kForm);
    const auto first = (*items)[0].number(), last = (*items)[1].number();
    const auto count = (*items)[2].integer(1, kMostItems);
    if (!first || !last || !count) return;
    if (*count == 1 && *first != *last)
      return (*items)[2].error("one value cannot reach from the first to the last");
    for (const double value : grid(*first, *last, *count)) add_number(value, reader.node().mark);
  }

  /// True if a grid consists of whole numbers that doubles represent exactly.
  static bool is_whole(double first, double last, long long count) {
    constexpr double kMostCounted = 1e15;
    const auto whole = [](double x) { return std::abs(x) < kMostCounted && std::round(x) == x; };
    return count > 1 && whole(first) && whole(last) &&
           std::fmod(last - first, static_cast<double>(count - 1)) == 0;
  }

  /// A grid with exact ends; it is symmetric, and whole numbers are exact.
  static std::vector<double> grid(double first, double last, long long count) {
    const bool whole = is_whole(first, last, count);
    std::vector<double> values;
    for (long long i = 0; i < count; ++i) {
      const double share = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
      const double value = share == 1 ? last : between(first, last, share);
      values.push_back(whole ? std::round(value) : value);
    }
    return values;
  }

  /// Interpolates between two numbers, even if their difference overflows.
  static double between(double first, double last, double share) {
    const double distance = last - first;
    return std::isfinite(distance) ? first + share * distance : (1 - share) * first + share * last;
  }

  /// The ends of a range. Nothing, with an error, if they are in the wrong order.
  static std::optional<std::vector<double>> range_of(const YamlReader& reader) {
    auto ends = reader.numbers(2, "[lower, upper]");
    if (ends && (*ends)[0] > (*ends)[1]) {
      reader.error("the lower end lies above the upper one");
      return std::nullopt;
    }
    return ends;
  }

  /// The mean and the standard deviation.
  static std::optional<std::vector<double>> normal_of(const YamlReader& reader) {
    auto parameters = reader.numbers(2, "[mean, standard deviation]");
    if (parameters && (*parameters)[1] < 0) {
      reader.error("the standard deviation is negative");
      return std::nullopt;
    }
    return parameters;
  }

  void read_values(const YamlReader& reader) {
    if (const auto keys = map_.find("keys")) return read_pairs(*keys, reader);
    read_key();
    if (const auto items = reader.items("write '[0.1, 1]'")) {
      if (items->empty()) reader.error("there is no value");
      for (const YamlReader& item : *items) axis_.rows.push_back({item.node()});
    }
  }

  void read_pairs(const YamlReader& keys, const YamlReader& reader) {
    map_.exclusive({"key", "keys"});
    if (const auto names = keys.names())
      for (const Name& key : *names) axis_.columns.push_back({key.value, key});
    const auto rows = reader.items("write '[[0.1, 1], [0.2, 2]]'");
    // After an error in a key, the length of rows is unknown.
    if (!rows || axis_.columns.empty() || axis_.columns.size() != keys.node().items.size()) return;
    if (rows->empty()) reader.error("there is no row of values");
    for (const YamlReader& row : *rows) add_row(row);
  }

  /// Adds a row with a value for each key.
  void add_row(const YamlReader& row) {
    const auto items = row.items("write '[0.1, 1]'");
    if (!items) return;
    if (items->size() != axis_.columns.size())
      return row.error(fmt::format("this row has {} values, and there are {} keys", items->size(),
                                   axis_.columns.size()));
    std::vector<YamlNode>& values = axis_.rows.emplace_back();
    for (const YamlReader& item : *items) values.push_back(item.node());
  }

  /// The columns of a table. Each becomes a column of the axis, with its key.
  std::vector<Name> read_columns(const YamlReader& reader) {
    std::vector<Name> columns;
    constexpr const char* kForm = "write '{gx: initial_state.values.x}'";
    const auto entries = reader.named_entries(kForm);
    if (!entries) return columns;
    if (entries->empty()) reader.error("there is no column", kForm);
    for (const auto& [column, key] : *entries)
      if (const auto path = key.name()) {
        columns.push_back(column);
        axis_.columns.push_back({column.value, *path});
      }
    return columns;
  }

  void read_file(const YamlReader& reader) {
    const auto file = reader.name();
    std::vector<Name> columns;
    if (const auto r = map_.require("columns")) columns = read_columns(*r);
    if (file && !columns.empty())
      axis_.rows =
          read_axis_table(folder_ / file->value, file->place, columns, reader.diagnostics());
  }

  std::uint64_t seed(std::uint64_t standard) {
    const auto r = map_.find("seed");
    return r ? static_cast<std::uint64_t>(r->integer(0, kLargestSeed).value_or(1)) : standard;
  }
  long long count() {
    const auto r = map_.require("count");
    return r ? r->integer(1, kMostItems).value_or(0) : 0;
  }

  /// Reads one perturbed part of an instance, or a list of them.
  static std::vector<std::size_t> read_perturbed(const YamlReader& reader) {
    const std::vector<YamlReader> items = reader.is_sequence()
                                              ? reader.items().value_or(std::vector<YamlReader>{})
                                              : std::vector<YamlReader>{reader};
    std::vector<std::size_t> parts;
    for (const YamlReader& item : items) {
      const auto part = item.choose({kPerturbed[0].word, kPerturbed[1].word}, "perturbation");
      if (!part) return {};
      if (std::find(parts.begin(), parts.end(), *part) != parts.end())
        item.error(fmt::format("'{}' stands twice in the list", kPerturbed[*part].word));
      parts.push_back(*part);
    }
    if (items.empty()) reader.error("the list is empty", "write '[initial_state, guess]'");
    return parts;
  }

  void read_perturb(const YamlReader& reader) {
    const std::vector<std::size_t> parts = read_perturbed(reader);
    const auto spread = map_.require("spread");
    const auto size = spread ? spread->number(kPositive) : std::nullopt;
    const long long draws = count();
    const std::uint64_t first = seed(1);
    if (parts.empty() || !size) return;
    const Place place = reader.place();
    const std::string& name = axis_.name.value;
    for (const std::size_t part : parts)
      axis_.columns.push_back({name + '.' + (parts.size() == 1 ? "spread" : kPerturbed[part].word),
                               {kPerturbed[part].key, place}});
    axis_.columns.push_back({name, {"perturbation.seed", place}});
    for (long long i = 0; i < draws; ++i) {
      std::vector<YamlNode>& row = axis_.rows.emplace_back(parts.size(), spread->node());
      row.push_back(number_node(static_cast<double>(first + i), place.mark));
    }
  }

  /// A key and the two parameters of its distribution.
  struct RandomKey {
    std::vector<double> parameters;
    Mark mark;
  };
  /// Reads two numbers. Nothing, with an error, if they are not valid parameters.
  using ReadParameters = std::optional<std::vector<double>> (*)(const YamlReader&);

  /// The keys of a mapping with their parameters; empty if any is invalid.
  std::vector<RandomKey> read_joint(const YamlReader& reader, ReadParameters parameters_of) {
    const auto entries = reader.named_entries("write '{costs.effort.weight: [0.1, 1]}'");
    if (!entries) return {};
    if (entries->empty()) reader.error("there is no key");
    std::vector<RandomKey> keys;
    for (const auto& [key, numbers] : *entries) {
      axis_.columns.push_back({key.value, key});
      if (auto parameters = parameters_of(numbers))
        keys.push_back({*std::move(parameters), numbers.node().mark});
    }
    return keys.size() == entries->size() ? std::move(keys) : std::vector<RandomKey>{};
  }

  /// The key of the axis with its parameters.
  std::vector<RandomKey> read_single(const YamlReader& reader, ReadParameters parameters_of) {
    read_key();
    auto parameters = parameters_of(reader);
    if (!parameters) return {};
    return {{*std::move(parameters), reader.node().mark}};
  }

  /// Adds independent draws of one key, or of several keys jointly.
  void read_random(const YamlReader& reader, ReadParameters parameters_of,
                   const std::function<double(const std::vector<double>&)>& draw) {
    const std::vector<RandomKey> keys =
        reader.is_map() ? read_joint(reader, parameters_of) : read_single(reader, parameters_of);
    const long long draws = count();
    for (long long i = 0; i < draws && !keys.empty(); ++i) {
      std::vector<YamlNode>& row = axis_.rows.emplace_back();
      for (const RandomKey& key : keys) row.push_back(number_node(draw(key.parameters), key.mark));
    }
  }

  void read_uniform(const YamlReader& reader) {
    std::mt19937_64 engine(seed(1));
    read_random(reader, range_of, [&](const std::vector<double>& bounds) {
      const double share = static_cast<double>(engine() >> 11) * 0x1p-53;
      return between(bounds[0], bounds[1], share);
    });
  }

  void read_normal(const YamlReader& reader) {
    NormalNumbers normal(seed(1));
    read_random(reader, normal_of,
                [&](const std::vector<double>& p) { return p[0] + p[1] * normal.next(); });
  }

  void read_sobol(const YamlReader& reader) {
    const std::vector<RandomKey> keys = read_joint(reader, range_of);
    const long long draws = count();
    const std::uint64_t shift = seed(1);
    if (keys.size() > static_cast<std::size_t>(kSobolDimensions))
      return reader.error(fmt::format("there are more than {} keys", kSobolDimensions));
    if (keys.empty()) return;
    SobolSequence sequence(static_cast<int>(keys.size()), shift);
    for (long long i = 0; i < draws; ++i) {
      const std::vector<double> point = sequence.next();
      std::vector<YamlNode>& row = axis_.rows.emplace_back();
      for (std::size_t c = 0; c < keys.size(); ++c) {
        const auto& bounds = keys[c].parameters;
        row.push_back(number_node(between(bounds[0], bounds[1], point[c]), keys[c].mark));
      }
    }
  }

  YamlMap map_;
  const std::filesystem::path& folder_;
  Axis axis_;
};

}  // namespace

Axis read_axis(const Name& name, const YamlReader& reader, const std::filesystem::path& folder) {
  return AxisReader(name, reader, folder).read();
}

}  // namespace conddp
