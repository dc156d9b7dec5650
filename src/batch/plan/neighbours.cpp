#include "batch/plan/neighbours.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <unordered_set>
#include <utility>

#include "batch/plan/manifest.hpp"

namespace conddp {
namespace {

/// Varied values as points, with each number scaled to [0, 1].
class Points {
 public:
  explicit Points(const Manifest& manifest) : parts_(manifest.items.size()) {
    std::map<std::string, std::size_t> known;  // indices of parts by column and path
    std::vector<Range> ranges;
    for (std::size_t i = 0; i < manifest.items.size(); ++i)
      for (std::size_t c = 0; c < manifest.columns.size(); ++c)
        for (const ValueLeaf& leaf : leaves_of(manifest.items[i].values[c])) {
          const std::size_t part =
              known.try_emplace(std::to_string(c) + '.' + leaf.path, known.size()).first->second;
          ranges.resize(known.size());
          parts_[i].push_back(part_of(part, leaf.value));
          if (leaf.value.is_number()) ranges[part].take(parts_[i].back().number);
        }
    for (const Range& range : ranges) scales_.push_back(range.scale());
    for (auto& parts : parts_)
      std::sort(parts.begin(), parts.end(),
                [](const Part& a, const Part& b) { return a.index < b.index; });
  }

  double squared_distance(std::size_t a, std::size_t b) const {
    double sum = 0;
    auto other = parts_[b].begin();
    const auto end = parts_[b].end();
    for (const Part& part : parts_[a]) {
      for (; other != end && other->index < part.index; ++other) ++sum;
      const bool both = other != end && other->index == part.index;
      sum += both ? squared_distance(part, *other++) : 1;
    }
    return sum + static_cast<double>(end - other);
  }

 private:
  struct Range {
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    void take(double number) {
      lower = std::min(lower, number);
      upper = std::max(upper, number);
    }
    double scale() const { return upper > lower ? 1 / (upper - lower) : 0; }
  };
  /// A number or a text in the values of an item.
  struct Part {
    std::size_t index = 0;
    double number = 0;
    std::string word = {};  ///< empty for a number
  };

  static Part part_of(std::size_t index, const OrderedJson& value) {
    if (value.is_number()) return {index, value.get<double>()};
    return {index, 0, value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace)};
  }

  double squared_distance(const Part& a, const Part& b) const {
    if (a.word != b.word) return 1;
    const double change = scales_[a.index] * (a.number - b.number);
    return change * change;
  }

  std::vector<std::vector<Part>> parts_;  ///< by item
  std::vector<double> scales_;            ///< by part
};

}  // namespace

std::size_t block_of(const Manifest& manifest, std::size_t item) {
  if (manifest.warm_start != WarmStart::kNeighbour) return item;
  const std::size_t solvers = static_cast<std::size_t>(manifest.solvers);
  const std::size_t rows = manifest.items.size() / (solvers * manifest.problems.size());
  const std::size_t solver = item % solvers, row = item / solvers % rows,
                    problem = item / solvers / rows;
  const std::size_t blocks = (rows + kNeighbourBlock - 1) / kNeighbourBlock;
  return (problem * blocks + row / kNeighbourBlock) * solvers + solver;
}

void find_parents(Manifest& manifest, const std::vector<int>& shapes) {
  const Points points(manifest);
  std::map<std::pair<std::size_t, int>, std::vector<std::size_t>>
      blocks;  // items of the same shape in a block
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {
    std::vector<std::size_t>& before = blocks[{block_of(manifest, i), shapes[i]}];
    const auto nearest = std::min_element(before.begin(), before.end(), [&](auto a, auto b) {
      return points.squared_distance(i, a) < points.squared_distance(i, b);
    });
    if (nearest != before.end()) manifest.items[i].parent = manifest.items[*nearest].id;
    before.push_back(i);
  }
}

std::vector<std::size_t> with_descendants(const Manifest& manifest,
                                          const std::vector<std::size_t>& items) {
  const std::unordered_set<std::size_t> chosen(items.begin(), items.end());
  std::unordered_set<std::string> ids;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < manifest.items.size(); ++i) {  // parents come first
    const ManifestItem& item = manifest.items[i];
    if (!chosen.contains(i) && !ids.contains(item.parent)) continue;
    ids.insert(item.id);
    all.push_back(i);
  }
  return all;
}

}  // namespace conddp
