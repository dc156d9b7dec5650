#include "systems/multibody/column_solver.hpp"

#include <algorithm>
#include <numeric>

namespace conddp {
namespace {

/// Maximum number of columns processed together; their sums stay in registers.
constexpr int kWidest = 12;

/// Calls act(count, first) for runs of columns, with the compiled widths.
template <class F>
void for_each_run(int columns, F act) {
  int first = 0;
  const auto take = [&]<int kCount>(std::integral_constant<int, kCount> count) {
    for (; columns - first >= kCount; first += kCount) act(count, first);
  };
  take(std::integral_constant<int, kWidest>());
  take(std::integral_constant<int, 9>());
  take(std::integral_constant<int, 6>());
  take(std::integral_constant<int, 3>());
  take(std::integral_constant<int, 1>());
}

/// Adjacent numbers, summed in registers.
template <int kCount, class S>
struct Sums {
  // At -O2, g++ 12 wrongly assumes that a leaf function's stack is aligned to 16 bytes. For
  // stricter alignments it emits code that aligns.
  alignas(std::max<std::size_t>(32, alignof(S))) S at[kCount];

  explicit Sums(const S* from) {
    for (int c = 0; c < kCount; ++c) at[c] = from[c];
  }
  void add(const S& factor, const S* x) {
    for (int c = 0; c < kCount; ++c) at[c] += factor * x[c];
  }
  void subtract(const S& factor, const S* x) {
    for (int c = 0; c < kCount; ++c) at[c] -= factor * x[c];
  }
  void scale(const S& factor) {
    for (int c = 0; c < kCount; ++c) at[c] = factor * at[c];
  }
  void store(S* to) const {
    for (int c = 0; c < kCount; ++c) to[c] = at[c];
  }
};

/// w ← G⁻¹ w with the factors of G.
template <int kCount, class S>
void solve_side_by_side(int m, const S* factors, S* w) {
  if constexpr (kCount == 1) {
    // A single column updates its rows independently: sums by row would have to wait for each
    // other.
    for (int k = 0; k < m; ++k)
      for (int i = k + 1; i < m; ++i) w[i] -= factors[k * m + i] * w[k];
  } else {
    for (int i = 1; i < m; ++i) {
      Sums<kCount, S> sum(w + i * kCount);
      for (int k = 0; k < i; ++k) sum.subtract(factors[k * m + i], w + k * kCount);
      sum.store(w + i * kCount);
    }
  }
  for (int k = m - 1; k >= 0; --k) {
    Sums<kCount, S> sum(w + k * kCount);
    sum.scale(factors[k * m + k]);
    for (int i = k + 1; i < m; ++i) sum.subtract(factors[k * m + i], w + i * kCount);
    sum.store(w + k * kCount);
  }
}

}  // namespace

ColumnSolver::ColumnSolver(const RobotModel& model, bool dense, int n, const ContactSet& contacts,
                           const std::vector<Entry>& controls, int nu)
    : n_(n),
      m_(contacts.rows()),
      dense_(dense),
      parent_(model.parent_dof),
      subtree_end_(model.subtree_end),
      controls_(nu) {
  for (const Entry& entry : controls) controls_[entry.column].push_back(entry);
  const std::vector<Branch> branches = find_branches(model);
  const std::vector<int> branch_of_row = branches_of_rows(branches);
  std::vector<int> all_rows(n);
  std::iota(all_rows.begin(), all_rows.end(), 0);
  // Positions that move a force on another branch.
  std::vector<bool> spreads(n, false);
  for (int i = 0; i < contacts.count(); ++i) {
    contact_columns_.push_back(dense ? all_rows : contacts.columns(i));
    contact_offsets_.push_back(contacts.offset(i));
    // A contact of two branches takes the rows of all.
    const Branch& branch = branches[branch_of_row[contacts.columns(i).back()]];
    const bool alone =
        &branch != &branches.front() &&
        std::ranges::all_of(contacts.columns(i), [&](int row) { return branch.has(row); });
    branch_of_contact_.push_back(alone ? branch : branches.front());
    for (const int row : contacts.columns(i))
      if (!alone) spreads[row] = true;
  }
  contact_offsets_.push_back(m_);
  for (const Branch& branch : branches) batches_.push_back({branch, {}, contact_rows(branch)});
  for (int column = 0; column < 2 * n; ++column) {
    const bool spread = column < n && spreads[column];
    batches_[spread ? 0 : branch_of_row[column % n]].columns.push_back(column);
  }
  for (int control = 0; control < nu; ++control)
    batches_[branch_of(controls_[control], branch_of_row)].columns.push_back(2 * n + control);
}

/// The branch of each row; the first branch for rows outside of branches.
std::vector<int> ColumnSolver::branches_of_rows(const std::vector<Branch>& branches) const {
  std::vector<int> branch_of_row(n_, 0);
  for (std::size_t b = 1; b < branches.size(); ++b)
    std::fill(&branch_of_row[branches[b].begin], &branch_of_row[0] + branches[b].end,
              static_cast<int>(b));
  return branch_of_row;
}

/// The common branch of all entries of a control, or the branch of all rows.
int ColumnSolver::branch_of(const std::vector<Entry>& entries,
                            const std::vector<int>& branch_of_row) {
  if (entries.empty()) return 0;
  const int branch = branch_of_row[entries.front().row];
  const bool alone = std::all_of(entries.begin(), entries.end(), [&](const Entry& entry) {
    return branch_of_row[entry.row] == branch;
  });
  return alone ? branch : 0;
}

/// For each contact, those of its columns that are rows of a branch.
std::vector<std::vector<int>> ColumnSolver::contact_rows(const Branch& branch) const {
  std::vector<std::vector<int>> rows;
  for (const std::vector<int>& columns : contact_columns_) {
    rows.emplace_back();
    for (const int row : columns)
      if (branch.has(row)) rows.back().push_back(row);
  }
  return rows;
}

/// The branch of all rows, which serves as a fallback, and the branches attached to floating
/// bodies.
std::vector<ColumnSolver::Branch> ColumnSolver::find_branches(const RobotModel& model) const {
  std::vector<Branch> branches{{0, n_}};
  if (dense_) return branches;
  for (const Joint& root : model.joints) {
    if (root.type != JointType::floating) continue;
    const int root_end = root.v + root.nv();
    for (int row = root_end; row < subtree_end_[root.v]; row = subtree_end_[row])
      branches.push_back({row, subtree_end_[row], root.v, root_end});
  }
  return branches;
}

template <class S>
ColumnSolver::Data<S>::Data(const ColumnSolver& solver)
    : y(solver.n_ * kWidest, S(0.0)), w(solver.m_ * kWidest, S(0.0)) {}

template <int kCount, class S>
void ColumnSolver::first_half_dense(const S* L, S* y) const {
  for (int i = 1; i < n_; ++i) {
    Sums<kCount, S> sum(y + i * kCount);
    for (int k = 0; k < i; ++k) sum.subtract(L[k * n_ + i], y + k * kCount);
    sum.store(y + i * kCount);
  }
}

/// Eliminates the rows of a branch, or of its root.
template <int kCount, class S>
inline void ColumnSolver::eliminate(const S* L, const Branch& branch, int begin, int end, bool root,
                                    S* y) const {
  for (int j = end - 1; j >= begin; --j) {
    Sums<kCount, S> sum(y + j * kCount);
    const S* column = L + j * n_;
    const int last = root ? end : subtree_end_[j];
    for (int i = j + 1; i < last; ++i) sum.subtract(column[i], y + i * kCount);
    if (root)
      for (int i = branch.begin; i < branch.end; ++i) sum.subtract(column[i], y + i * kCount);
    sum.store(y + j * kCount);
  }
}

template <int kCount, class S>
void ColumnSolver::first_half(const MassFactors<S>& factors, const Branch& branch, S* y) const {
  if (dense_) return first_half_dense<kCount>(factors.L, y);
  eliminate<kCount>(factors.L, branch, branch.begin, branch.end, false, y);
  eliminate<kCount>(factors.L, branch, branch.root_begin, branch.root_end, true, y);
}

template <int kCount, class S>
void ColumnSolver::second_half(const MassFactors<S>& factors, S* y) const {
  const S* L = factors.L;
  for (int step = 0; step < n_; ++step) {
    const int i = dense_ ? n_ - 1 - step : step;
    Sums<kCount, S> sum(y + i * kCount);
    sum.scale(factors.D_inverse[i * factors.step]);
    if (dense_)
      for (int k = i + 1; k < n_; ++k) sum.subtract(L[i * n_ + k], y + k * kCount);
    else
      for (int j = parent_[i]; j >= 0; j = parent_[j]) sum.subtract(L[j * n_ + i], y + j * kCount);
    sum.store(y + i * kCount);
  }
}

/// w ← G⁻¹ (w − J M⁻¹ f) and y += L⁻ᵀ Jᵀ w.
template <int kCount, class S>
void ColumnSolver::hold(const Batch& batch, const ContactSet::Data<S>& contacts, S* y, S* w) const {
  const int count = static_cast<int>(contact_columns_.size());
  for (int contact = 0; contact < count; ++contact)
    for (int r = contact_offsets_[contact]; r < contact_offsets_[contact + 1]; ++r) {
      Sums<kCount, S> sum(w + r * kCount);
      const S* scaled = contacts.scaled.data() + r * n_;
      for (const int row : batch.contact_rows[contact]) sum.subtract(scaled[row], y + row * kCount);
      sum.store(w + r * kCount);
    }
  solve_side_by_side<kCount>(m_, contacts.factors.data(), w);
  for (int contact = 0; contact < count; ++contact)
    for (const int row : contact_columns_[contact]) {
      Sums<kCount, S> sum(y + row * kCount);
      for (int r = contact_offsets_[contact]; r < contact_offsets_[contact + 1]; ++r)
        sum.add(contacts.response[r * n_ + row], w + r * kCount);
      sum.store(y + row * kCount);
    }
}

template <class S>
void ColumnSolver::prepare_contacts(const MassFactors<S>& factors, ContactSet::Data<S>& contacts,
                                    Data<S>& data) const {
  for (std::size_t contact = 0; contact < contact_columns_.size(); ++contact) {
    const Branch& branch = branch_of_contact_[contact];
    const int offset = contact_offsets_[contact];
    for_each_run(contact_offsets_[contact + 1] - offset, [&](auto width, int first) {
      constexpr int kCount = decltype(width)::value;
      S* y = data.y.data();
      S* response = contacts.response.data() + (offset + first) * n_;
      S* scaled = contacts.scaled.data() + (offset + first) * n_;
      const auto for_each_row = [&](auto act) {
        for (int row = branch.root_begin; row < branch.root_end; ++row) act(row);
        for (int row = branch.begin; row < branch.end; ++row) act(row);
      };
      for_each_row([&](int row) {
        for (int c = 0; c < kCount; ++c) y[row * kCount + c] = response[c * n_ + row];
      });
      first_half<kCount>(factors, branch, y);
      for_each_row([&](int row) {
        const S& inverse = factors.D_inverse[row * factors.step];
        for (int c = 0; c < kCount; ++c) {
          response[c * n_ + row] = y[row * kCount + c];
          scaled[c * n_ + row] = inverse * y[row * kCount + c];
        }
      });
    });
  }
  form_G(contacts);
}

/// Computes the rows of G up to the end of each contact's diagonal block, from response and scaled.
template <class S>
void ColumnSolver::form_G(ContactSet::Data<S>& contacts) const {
  for (std::size_t contact = 0; contact < contact_columns_.size(); ++contact) {
    const int end = contact_offsets_[contact + 1];
    for (int r = contact_offsets_[contact]; r < end; ++r) {
      const S* response = contacts.response.data() + r * n_;
      for_each_run(end, [&](auto width, int first) {
        constexpr int kCount = decltype(width)::value;
        const S* scaled = contacts.scaled.data() + first * n_;
        S sum[kCount];
        for (int c = 0; c < kCount; ++c) sum[c] = S(0.0);
        for (const int row : contact_columns_[contact])
          for (int c = 0; c < kCount; ++c) sum[c] += response[row] * scaled[c * n_ + row];
        for (int c = 0; c < kCount; ++c) contacts.G[(first + c) * m_ + r] = sum[c];
      });
    }
  }
}

template <class S>
void ColumnSolver::hold_contacts(ContactSet::Data<S>& contacts, S* y) const {
  hold<1>(batches_.front(), contacts, y, contacts.force.data());
}

template <class S>
void ColumnSolver::solve_first_half(const MassFactors<S>& factors, S* x) const {
  first_half<1>(factors, Branch{0, n_}, x);
}

template <class S>
void ColumnSolver::solve_second_half(const MassFactors<S>& factors, S* x) const {
  second_half<1>(factors, x);
}

/// Writes the rows of a branch in a column of f, before it is solved, into every kCount-th number.
template <int kCount, class S>
void ColumnSolver::load_column(const Branch& branch, int column, const S* tau_q, const S* tau_v,
                               S* y) const {
  if (column >= 2 * n_) {
    for (const Entry& entry : controls_[column - 2 * n_]) y[entry.row * kCount] = S(entry.value);
    return;
  }
  if (column >= n_ && tau_v == nullptr) return;
  const S* tau = column < n_ ? tau_q + column * n_ : tau_v + (column - n_) * n_;
  for (int row = branch.root_begin; row < branch.root_end; ++row) y[row * kCount] = -tau[row];
  for (int row = branch.begin; row < branch.end; ++row) y[row * kCount] = -tau[row];
}

template <class S>
void ColumnSolver::solve_columns(const MassFactors<S>& factors, const S* tau_q, const S* tau_v,
                                 ContactSet::Data<S>& contacts, S* fx, S* fu, Data<S>& data) const {
  for (const Batch& batch : batches_) {
    const Branch& branch = batch.branch;
    for_each_run(static_cast<int>(batch.columns.size()), [&](auto width, int first) {
      constexpr int kCount = decltype(width)::value;
      const int* columns = batch.columns.data() + first;
      S* y = data.y.data();
      S* w = data.w.data();
      std::fill_n(y, n_ * kCount, S(0.0));
      for (int c = 0; c < kCount; ++c) {
        const int column = columns[c];
        for (int r = 0; r < m_; ++r) w[r * kCount + c] = contacts.force_z[column * m_ + r];
        load_column<kCount>(branch, column, tau_q, tau_v, y + c);
      }
      first_half<kCount>(factors, branch, y);
      if (m_ > 0) hold<kCount>(batch, contacts, y, w);
      second_half<kCount>(factors, y);
      for (int c = 0; c < kCount; ++c) {
        const int column = columns[c];
        S* to = column < 2 * n_ ? fx + column * n_ : fu + (column - 2 * n_) * n_;
        for (int row = 0; row < n_; ++row) to[row] = y[row * kCount + c];
        for (int r = 0; r < m_; ++r) contacts.force_z[column * m_ + r] = w[r * kCount + c];
      }
    });
  }
}

#define CONDDP_INSTANTIATE(S)                                                               \
  template struct ColumnSolver::Data<S>;                                                    \
  template void ColumnSolver::prepare_contacts(const MassFactors<S>&, ContactSet::Data<S>&, \
                                               Data<S>&) const;                             \
  template void ColumnSolver::hold_contacts(ContactSet::Data<S>&, S*) const;                \
  template void ColumnSolver::solve_first_half(const MassFactors<S>&, S*) const;            \
  template void ColumnSolver::solve_second_half(const MassFactors<S>&, S*) const;           \
  template void ColumnSolver::solve_columns(const MassFactors<S>&, const S*, const S*,      \
                                            ContactSet::Data<S>&, S*, S*, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
