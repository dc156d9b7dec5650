#include "batch/plan/neighbours.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_set>
#include <utility>

#include "base/text/strict_number.hpp"

namespace conddp {
namespace {

/// Varied values as points, column by column in [0, 1].
class Points {
 public:
  explicit Points(const Manifest& manifest) : manifest_(manifest) {
    const std::size_t columns = manifest.columns.size();
    numbers_.resize(manifest.items.size() * columns);
    std::vector<Range> ranges(columns);
    for (std::size_t i = 0; i < manifest.items.size(); ++i)
      for (std::size_t c = 0; c < columns; ++c) {
        const auto number = parse_number(manifest.items[i].values[c]).value;
        numbers_[i * columns + c] = number.value_or(std::numeric_limits<double>::quiet_NaN());
        if (number) ranges[c].take(*number);
      }
    for (const Range& range : ranges) scales_.push_back(range.scale());
  }

  double squared_distance(std::size_t a, std::size_t b) const {
    const std::size_t columns = scales_.size();
    double sum = 0;
    for (std::size_t c = 0; c < columns; ++c) {
      const double change = scales_[c] * (numbers_[a * columns + c] - numbers_[b * columns + c]);
      // What is no number leaves NaN.
      sum += change == change ? change * change : differs(a, b, c);
    }
    return sum;
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

  double differs(std::size_t a, std::size_t b, std::size_t column) const {
    return manifest_.items[a].values[column] == manifest_.items[b].values[column] ? 0 : 1;
  }

  const Manifest& manifest_;
  std::vector<double> numbers_;  ///< of the items, row by row; NaN for what is no number
  std::vector<double> scales_;   ///< of the columns
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
  std::map<std::pair<std::size_t, int>, std::vector<std::size_t>> blocks;  // of one shape each
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
