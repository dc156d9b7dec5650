#include "nlp/chain_factorization.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace conddp {
namespace {

constexpr int kScalingPasses = 2;
/// A search restarts from its far end while the chain gets longer, at most this many times.
constexpr int kSearches = 8;
/// Unknowns that a front may hand on if groups are small.
constexpr int kMostLeft = 64;

/// Neighbors of each unknown, without itself.
struct Graph {
  std::vector<int> first, neighbors;

  Graph(int size, int entries, const int* rows, const int* columns)
      : first(static_cast<std::size_t>(size) + 1, 0) {
    for (int e = 0; e < entries; ++e) {
      if (rows[e] == columns[e]) continue;
      ++first[static_cast<std::size_t>(rows[e]) + 1];
      ++first[static_cast<std::size_t>(columns[e]) + 1];
    }
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    neighbors.resize(static_cast<std::size_t>(first.back()));
    std::vector<int> next(first.begin(), first.end() - 1);
    const auto add = [&](int from, int to) {
      neighbors[static_cast<std::size_t>(next[static_cast<std::size_t>(from)]++)] = to;
    };
    for (int e = 0; e < entries; ++e) {
      if (rows[e] == columns[e]) continue;
      add(rows[e], columns[e]);
      add(columns[e], rows[e]);
    }
  }

  std::span<const int> of(int unknown) const {
    const auto i = static_cast<std::size_t>(unknown);
    return {neighbors.data() + first[i], static_cast<std::size_t>(first[i + 1] - first[i])};
  }
};

using Levels = std::vector<std::vector<int>>;

/// Levels of a breadth-first search from an unknown: itself, its neighbors, their neighbors, ...
/// `seen` is -1 for unknowns that no search has met, and becomes `mark` for those of this search.
Levels search(const Graph& graph, int start, std::vector<int>& seen, int mark) {
  Levels levels = {{start}};
  seen[static_cast<std::size_t>(start)] = mark;
  while (true) {
    std::vector<int> next;
    for (const int unknown : levels.back())
      for (const int neighbor : graph.of(unknown)) {
        int& met = seen[static_cast<std::size_t>(neighbor)];
        if (met == mark) continue;
        met = mark;
        next.push_back(neighbor);
      }
    if (next.empty()) return levels;
    levels.push_back(std::move(next));
  }
}

/// Levels of a search from an end of a component.
Levels longest_search(const Graph& graph, int start, std::vector<int>& seen, int& mark) {
  Levels levels = search(graph, start, seen, ++mark);
  for (int i = 0; i < kSearches; ++i) {
    const std::vector<int>& far = levels.back();
    const int end = *std::min_element(far.begin(), far.end(), [&](int a, int b) {
      return graph.of(a).size() < graph.of(b).size();
    });
    Levels longer = search(graph, end, seen, ++mark);
    const bool stop = longer.size() <= levels.size();
    levels = std::move(longer);
    if (stop) break;
  }
  return levels;
}

}  // namespace

Chain::Chain(int size, int entries, const int* rows, const int* columns) {
  const Graph graph(size, entries, rows, columns);
  std::vector<int> seen(static_cast<std::size_t>(size), -1);
  int mark = -1;
  for (int start = 0; start < size; ++start) {
    if (seen[static_cast<std::size_t>(start)] >= 0) continue;
    for (std::vector<int>& level : longest_search(graph, start, seen, mark)) {
      groups.push_back(std::move(level));
      goes_on.push_back(true);
    }
    goes_on.back() = false;
  }
}

int Chain::front_size(std::size_t group) const {
  return static_cast<int>(groups[group].size() + (goes_on[group] ? groups[group + 1].size() : 0));
}

std::unique_ptr<SymmetricFactorization> ChainFactorization::make() {
  return std::make_unique<ChainFactorization>();
}

void ChainFactorization::analyse(int size, int entries, const int* rows, const int* columns) {
  size_ = size;
  rows_.assign(rows, rows + entries);
  columns_of_.assign(columns, columns + entries);
  chain_ = Chain(size, entries, rows, columns);
  place_entries();
  scale_.resize(size);
  largest_.resize(size);
}

void ChainFactorization::place_entries() {
  struct Place {
    std::size_t group;
    int row;
  };
  std::vector<Place> places(static_cast<std::size_t>(size_));
  for (std::size_t g = 0; g < chain_.groups.size(); ++g)
    for (std::size_t i = 0; i < chain_.groups[g].size(); ++i)
      places[static_cast<std::size_t>(chain_.groups[g][i])] = {g, static_cast<int>(i)};
  entries_.assign(chain_.groups.size(), {});
  most_left_ = kMostLeft;
  for (const auto& group : chain_.groups)
    most_left_ = std::max(most_left_, static_cast<int>(group.size()));
  for (std::size_t e = 0; e < rows_.size(); ++e) {
    Place a = places[static_cast<std::size_t>(rows_[e])];
    Place b = places[static_cast<std::size_t>(columns_of_[e])];
    if (a.group > b.group) std::swap(a, b);
    if (b.group > a.group) b.row += static_cast<int>(chain_.groups[a.group].size());
    entries_[a.group].push_back(
        {static_cast<int>(e), std::max(a.row, b.row), std::min(a.row, b.row)});
  }
}

void ChainFactorization::find_scale(const double* values) {
  scale_.setOnes();
  for (int pass = 0; pass < kScalingPasses; ++pass) {
    largest_.setZero();
    for (std::size_t e = 0; e < rows_.size(); ++e) {
      const int r = rows_[e], c = columns_of_[e];
      const double value = std::abs(values[e]) * scale_[r] * scale_[c];
      largest_[r] = std::max(largest_[r], value);
      largest_[c] = std::max(largest_[c], value);
    }
    for (int i = 0; i < size_; ++i)
      if (largest_[i] > 0) scale_[i] /= std::sqrt(largest_[i]);
  }
  for (double& factor : scale_) factor = std::exp2(std::round(std::log2(factor)));
}

SymmetricFactorization::Outcome ChainFactorization::factorize(const double* values,
                                                              double pivot_tolerance) {
  find_scale(values);
  factors_.clear();
  columns_.clear();
  diagonal_.clear();
  names_.clear();
  negative_ = 0;
  for (std::size_t g = 0; g < chain_.groups.size(); ++g) {
    DenseFront& front = fronts_[g % 2];
    const DenseFront& before = fronts_[(g + 1) % 2];
    hand_on(before, front, g);
    const int shift = front.candidates() - static_cast<int>(chain_.groups[g].size());
    for (const Entry& entry : entries_[g])
      front.at(shift + entry.row, shift + entry.column) +=
          values[entry.index] * scale_[rows_[static_cast<std::size_t>(entry.index)]] *
          scale_[columns_of_[static_cast<std::size_t>(entry.index)]];
    front.eliminate(pivot_tolerance);
    const int left = front.candidates() - front.pivots();
    if (left > (chain_.goes_on[g] ? most_left_ : 0)) return Outcome::singular;
    negative_ += front.negative();
    keep(front);
  }
  return Outcome::done;
}

void ChainFactorization::hand_on(const DenseFront& from, DenseFront& to, std::size_t group) {
  const bool is_coupled = group > 0 && chain_.goes_on[group - 1];
  const int left = is_coupled ? from.candidates() - from.pivots() : 0;
  const auto& own = chain_.groups[group];
  to.reset(left + static_cast<int>(own.size()), left + chain_.front_size(group));
  int name = 0;
  for (int i = 0; i < left; ++i)
    to.names()[static_cast<std::size_t>(name++)] =
        from.names()[static_cast<std::size_t>(from.pivots() + i)];
  for (const int unknown : own) to.names()[static_cast<std::size_t>(name++)] = unknown;
  if (chain_.goes_on[group])
    for (const int unknown : chain_.groups[group + 1])
      to.names()[static_cast<std::size_t>(name++)] = unknown;
  if (!is_coupled) return;
  const int first = from.pivots(), rest = from.size() - first;
  for (int c = 0; c < rest; ++c)
    std::copy_n(from.column(first + c) + first + c, rest - c, to.column(c) + c);
}

void ChainFactorization::keep(const DenseFront& front) {
  const int size = front.size(), pivots = front.pivots();
  factors_.push_back({size, pivots, columns_.size(), diagonal_.size(), names_.size()});
  for (int c = 0; c < pivots; ++c) {
    columns_.insert(columns_.end(), front.column(c), front.column(c) + size);
    diagonal_.push_back(front.pivot(c));
  }
  names_.insert(names_.end(), front.names().begin(), front.names().end());
}

void ChainFactorization::solve(double* b) const {
  using Column = Eigen::Map<const Eigen::VectorXd>;
  Eigen::Map<Eigen::VectorXd> x(b, size_);
  x.array() *= scale_.array();
  const auto gather = [&](const Factor& factor) {
    local_.conservativeResize(std::max<Eigen::Index>(local_.size(), factor.size));
    for (int i = 0; i < factor.size; ++i)
      local_[i] = x[names_[factor.names + static_cast<std::size_t>(i)]];
  };
  const auto column = [&](const Factor& factor, int c) {
    return Column(&columns_[factor.columns] + static_cast<std::ptrdiff_t>(c) * factor.size,
                  factor.size);
  };
  for (const Factor& factor : factors_) {
    gather(factor);
    for (int c = 0; c < factor.pivots; ++c) {
      const int rest = factor.size - c - 1;
      local_.segment(c + 1, rest) -= local_[c] * column(factor, c).tail(rest);
    }
    for (int i = 0; i < factor.size; ++i)
      x[names_[factor.names + static_cast<std::size_t>(i)]] = local_[i];
  }
  for (auto factor = factors_.rbegin(); factor != factors_.rend(); ++factor) {
    gather(*factor);
    divide(*factor);
    for (int c = factor->pivots - 1; c >= 0; --c) {
      const int rest = factor->size - c - 1;
      local_[c] -= local_.segment(c + 1, rest).dot(column(*factor, c).tail(rest));
    }
    for (int i = 0; i < factor->pivots; ++i)
      x[names_[factor->names + static_cast<std::size_t>(i)]] = local_[i];
  }
  x.array() *= scale_.array();
}

void ChainFactorization::divide(const Factor& factor) const {
  for (int c = 0; c < factor.pivots; ++c) {
    const auto& [value, coupling] = diagonal_[factor.pivot + static_cast<std::size_t>(c)];
    if (coupling == 0) {
      local_[c] /= value;
      continue;
    }
    const double next = diagonal_[factor.pivot + static_cast<std::size_t>(c) + 1].value;
    const double determinant = value * next - coupling * coupling;
    const double x = local_[c], y = local_[c + 1];
    local_[c] = (next * x - coupling * y) / determinant;
    local_[c + 1] = (value * y - coupling * x) / determinant;
    ++c;
  }
}

}  // namespace conddp
