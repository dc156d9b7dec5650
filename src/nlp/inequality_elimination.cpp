#include "nlp/inequality_elimination.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "nlp/chain_factorization.hpp"

namespace conddp {

InequalityElimination::InequalityElimination(std::unique_ptr<SymmetricFactorization> rest)
    : rest_(std::move(rest)) {}

std::unique_ptr<SymmetricFactorization> InequalityElimination::make() {
  return std::make_unique<InequalityElimination>(ChainFactorization::make());
}

void InequalityElimination::analyse(int size, int entries, const int* rows, const int* columns) {
  size_ = size;
  find_pairs(entries, rows, columns);
  place_entries(entries, rows, columns);
  place_products();
  rest_values_.resize(rest_rows_.size());
  local_.resize(left_size_);
  rest_->analyse(left_size_, static_cast<int>(rest_rows_.size()), rest_rows_.data(),
                 rest_columns_.data());
}

/// A slack has one off-diagonal entry and precedes its multiplier.
void InequalityElimination::find_pairs(int entries, const int* rows, const int* columns) {
  const auto size = static_cast<std::size_t>(size_);
  std::vector<int> others(size, 0), neighbor(size, -1);
  for (int e = 0; e < entries; ++e) {
    if (rows[e] == columns[e]) continue;
    for (const auto& [a, b] : {std::pair{rows[e], columns[e]}, std::pair{columns[e], rows[e]}}) {
      ++others[static_cast<std::size_t>(a)];
      neighbor[static_cast<std::size_t>(a)] = b;
    }
  }
  pairs_.clear();
  pair_of_.assign(size, -1);
  for (int slack = 0; slack < size_; ++slack) {
    const auto s = static_cast<std::size_t>(slack);
    if (others[s] != 1 || pair_of_[s] >= 0) continue;
    const auto multiplier = static_cast<std::size_t>(neighbor[s]);
    if (neighbor[s] < slack || pair_of_[multiplier] >= 0) continue;
    pair_of_[s] = pair_of_[multiplier] = static_cast<int>(pairs_.size());
    pairs_.push_back({slack, neighbor[s], 0, 0});
  }
  part_coupled_pairs(entries, rows, columns);
  left_.assign(size, -1);
  left_size_ = 0;
  for (std::size_t i = 0; i < size; ++i)
    if (pair_of_[i] < 0) left_[i] = left_size_++;
}

/// Drops one of two pairs with an entry between them.
void InequalityElimination::part_coupled_pairs(int entries, const int* rows, const int* columns) {
  std::vector<bool> stays(pairs_.size(), true);
  for (int e = 0; e < entries; ++e) {
    const int a = pair_of_[static_cast<std::size_t>(rows[e])];
    const int b = pair_of_[static_cast<std::size_t>(columns[e])];
    if (a < 0 || b < 0 || a == b || !stays[static_cast<std::size_t>(a)]) continue;
    stays[static_cast<std::size_t>(b)] = false;
  }
  std::vector<Pair> kept;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const int number = stays[i] ? static_cast<int>(kept.size()) : -1;
    pair_of_[static_cast<std::size_t>(pairs_[i].slack)] = number;
    pair_of_[static_cast<std::size_t>(pairs_[i].multiplier)] = number;
    if (stays[i]) kept.push_back(pairs_[i]);
  }
  pairs_ = std::move(kept);
}

void InequalityElimination::place_entries(int entries, const int* rows, const int* columns) {
  targets_.clear();
  rest_rows_.clear();
  rest_columns_.clear();
  std::vector<std::vector<Column>> of(pairs_.size());
  for (int e = 0; e < entries; ++e) {
    const auto a = static_cast<std::size_t>(rows[e]), b = static_cast<std::size_t>(columns[e]);
    const int pair = std::max(pair_of_[a], pair_of_[b]);
    if (pair < 0) {
      targets_.push_back({Target::rest, static_cast<int>(rest_rows_.size())});
      rest_rows_.push_back(std::max(left_[a], left_[b]));
      rest_columns_.push_back(std::min(left_[a], left_[b]));
    } else if (pair_of_[a] != pair_of_[b]) {
      of[static_cast<std::size_t>(pair)].push_back({e, std::max(left_[a], left_[b])});
      targets_.push_back({Target::column, -1});
    } else {
      const bool slack = rows[e] == pairs_[static_cast<std::size_t>(pair)].slack;
      const auto diagonal = slack ? Target::slack : Target::multiplier;
      targets_.push_back({a == b ? diagonal : Target::coupling, pair});
    }
  }
  columns_.clear();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    pairs_[i].first = static_cast<int>(columns_.size());
    for (const Column& column : of[i]) {
      targets_[static_cast<std::size_t>(column.entry)].index = static_cast<int>(columns_.size());
      columns_.push_back(column);
    }
    pairs_[i].last = static_cast<int>(columns_.size());
  }
}

/// Places the products of a pair's columns in the rest: one new entry for each position.
void InequalityElimination::place_products() {
  products_.clear();
  std::map<std::pair<int, int>, int> places;
  for (const Pair& pair : pairs_)
    for (int i = pair.first; i < pair.last; ++i)
      for (int j = pair.first; j <= i; ++j) {
        const int a = columns_[static_cast<std::size_t>(i)].left;
        const int b = columns_[static_cast<std::size_t>(j)].left;
        const auto [place, is_new] = places.try_emplace({std::max(a, b), std::min(a, b)},
                                                        static_cast<int>(rest_rows_.size()));
        if (is_new) {
          rest_rows_.push_back(std::max(a, b));
          rest_columns_.push_back(std::min(a, b));
        }
        products_.push_back(place->second);
      }
}

SymmetricFactorization::Outcome InequalityElimination::factorize(const double* values,
                                                                 double pivot_tolerance) {
  std::fill(rest_values_.begin(), rest_values_.end(), 0.0);
  for (Pair& pair : pairs_) std::fill(std::begin(pair.inverse), std::end(pair.inverse), 0.0);
  for (std::size_t e = 0; e < targets_.size(); ++e) {
    const auto& [kind, index] = targets_[e];
    const auto i = static_cast<std::size_t>(index);
    if (kind == Target::rest)
      rest_values_[i] += values[e];
    else if (kind == Target::column)
      columns_[i].value = values[e];
    else
      pairs_[i].inverse[kind] += values[e];
  }
  negative_ = 0;
  std::size_t product = 0;
  for (Pair& pair : pairs_) {
    if (!invert(pair)) return Outcome::singular;
    for (int i = pair.first; i < pair.last; ++i)
      for (int j = pair.first; j <= i; ++j) {
        const Column &a = columns_[static_cast<std::size_t>(i)],
                     &b = columns_[static_cast<std::size_t>(j)];
        // Two columns of one unknown add to its diagonal twice.
        const double times = i != j && a.left == b.left ? 2 : 1;
        rest_values_[static_cast<std::size_t>(products_[product++])] -=
            times * a.value * pair.inverse[2] * b.value;
      }
  }
  const Outcome outcome = rest_->factorize(rest_values_.data(), pivot_tolerance);
  negative_ += rest_->negative_eigenvalues();
  return outcome;
}

/// Inverts the two rows of a pair in place; false if they are singular.
bool InequalityElimination::invert(Pair& pair) {
  const auto [slack, coupling, multiplier] = pair.inverse;
  const double determinant = slack * multiplier - coupling * coupling;
  if (determinant == 0) return false;
  negative_ += determinant < 0 ? 1 : slack < 0 ? 2 : 0;
  pair.inverse[0] = multiplier / determinant;
  pair.inverse[1] = -coupling / determinant;
  pair.inverse[2] = slack / determinant;
  return true;
}

void InequalityElimination::solve(double* b) const {
  for (int i = 0; i < size_; ++i)
    if (left_[static_cast<std::size_t>(i)] >= 0) local_[left_[static_cast<std::size_t>(i)]] = b[i];
  for (const Pair& pair : pairs_) {
    const double along = pair.inverse[1] * b[pair.slack] + pair.inverse[2] * b[pair.multiplier];
    for (int c = pair.first; c < pair.last; ++c) {
      const Column& column = columns_[static_cast<std::size_t>(c)];
      local_[column.left] -= column.value * along;
    }
  }
  rest_->solve(local_.data());
  for (const Pair& pair : pairs_) {
    double multiplier = b[pair.multiplier];
    for (int c = pair.first; c < pair.last; ++c) {
      const Column& column = columns_[static_cast<std::size_t>(c)];
      multiplier -= column.value * local_[column.left];
    }
    const double slack = b[pair.slack];
    b[pair.slack] = pair.inverse[0] * slack + pair.inverse[1] * multiplier;
    b[pair.multiplier] = pair.inverse[1] * slack + pair.inverse[2] * multiplier;
  }
  for (int i = 0; i < size_; ++i)
    if (left_[static_cast<std::size_t>(i)] >= 0) b[i] = local_[left_[static_cast<std::size_t>(i)]];
}

}  // namespace conddp
