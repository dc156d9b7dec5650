#pragma once

#include <vector>

#include "systems/multibody/contact_set.hpp"

namespace conddp {

/// Factors of the mass matrix: M = Lᵀ D L along the tree, as RobotData has them, or, where joints
/// mimic others, M = L D Lᵀ dense with D⁻¹ on the diagonal (dense_ldlt.hpp).
template <class S>
struct MassFactors {
  const S* L;          ///< n x n by columns
  const S* D_inverse;  ///< from one to the next it is `step` numbers
  int step;
};

/// Solves M a = f + Jᵀ λ with J a + c = 0 for several f and c side by side, halfway at a time: with
/// M = Lᵀ D L the contacts are dealt with at y = L⁻ᵀ f, where they touch only the rows between
/// their feet and the root, as f does: columns of one branch of the tree (a leg) go together, and
/// leave the rows of other branches alone until the way back.
class ColumnSolver {
 public:
  /// A non-zero of the matrix by which controls act.
  struct Entry {
    int row, column;
    double value;
  };

  ColumnSolver() = default;
  /// `dense`: the factors are those of a dense matrix with n rows.
  ColumnSolver(const RobotModel& model, bool dense, int n, const ContactSet& contacts,
               const std::vector<Entry>& controls, int nu);

  template <class S>
  struct Data {
    explicit Data(const ColumnSolver& solver);
    AlignedVector<S> y;  ///< rows of all columns of a batch, side by side
    AlignedVector<S> w;  ///< the contacts' rows
  };

  /// Turns Jᵀ in contacts.response into L⁻ᵀ Jᵀ, writes contacts.scaled and the lower triangle of G.
  template <class S>
  void prepare_contacts(const MassFactors<S>& factors, ContactSet::Data<S>& contacts,
                        Data<S>& data) const;
  /// x ← L⁻ᵀ x.
  template <class S>
  void solve_first_half(const MassFactors<S>& factors, S* x) const;
  /// x ← L⁻¹ D⁻¹ x.
  template <class S>
  void solve_second_half(const MassFactors<S>& factors, S* x) const;

  /// With contacts.force = −c at first: forces λ, and y, which comes with L⁻ᵀ f, gains
  /// L⁻ᵀ Jᵀ λ. G must be factored.
  template <class S>
  void hold_contacts(ContactSet::Data<S>& contacts, S* y) const;

  /// Right-hand sides: −tau_q, −tau_v (0 if null), then what the controls act on. On entry force_z
  /// (m x (2 n + nu)) holds −c, on return λ; fx and fu receive a.
  template <class S>
  void solve_columns(const MassFactors<S>& factors, const S* tau_q, const S* tau_v,
                     ContactSet::Data<S>& contacts, S* fx, S* fu, Data<S>& data) const;

 private:
  /// Rows of one branch and of the root that it hangs on; a branch without root is all rows.
  struct Branch {
    int begin, end;
    int root_begin = 0, root_end = 0;
    bool has(int row) const {
      return (row >= begin && row < end) || (row >= root_begin && row < root_end);
    }
  };
  /// Columns of f whose rows are those of a branch.
  struct Batch {
    Branch branch;
    std::vector<int> columns;
    std::vector<std::vector<int>> contact_rows;  ///< per contact: its rows in the branch
  };

  std::vector<Branch> find_branches(const RobotModel& model) const;
  std::vector<int> branches_of_rows(const std::vector<Branch>& branches) const;
  std::vector<std::vector<int>> contact_rows(const Branch& branch) const;
  static int branch_of(const std::vector<Entry>& entries, const std::vector<int>& branch_of_row);
  template <int kCount, class S>
  void load_column(const Branch& branch, int column, const S* tau_q, const S* tau_v, S* y) const;
  template <int kCount, class S>
  void first_half(const MassFactors<S>& factors, const Branch& branch, S* y) const;
  template <int kCount, class S>
  void first_half_dense(const S* L, S* y) const;
  template <int kCount, class S>
  void eliminate(const S* L, const Branch& branch, int begin, int end, bool root, S* y) const;
  template <int kCount, class S>
  void second_half(const MassFactors<S>& factors, S* y) const;
  template <int kCount, class S>
  void hold(const Batch& batch, const ContactSet::Data<S>& contacts, S* y, S* w) const;

  template <class S>
  void form_G(ContactSet::Data<S>& contacts) const;

  int n_ = 0, m_ = 0;
  bool dense_ = false;
  std::vector<int> parent_, subtree_end_;
  std::vector<Batch> batches_;
  std::vector<Branch> branch_of_contact_;
  std::vector<std::vector<int>> contact_columns_;
  std::vector<int> contact_offsets_;  ///< one more than contacts
  std::vector<std::vector<Entry>> controls_;
};

}  // namespace conddp
