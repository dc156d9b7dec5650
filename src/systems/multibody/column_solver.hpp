#pragma once

#include <vector>

#include "systems/multibody/contact_set.hpp"

namespace conddp {

/// Factors of the mass matrix: M = Lᵀ D L along the tree, as in RobotData. With mimic joints the
/// factors are M = L D Lᵀ, dense with D⁻¹ on the diagonal (contact_set.hpp).
template <class S>
struct MassFactors {
  const S* L;          ///< n x n by columns
  const S* D_inverse;  ///< with stride `step`
  int step;
};

/// Solves M a = f + Jᵀ λ with J a + c = 0 for several f and c together, in two halves. With M = Lᵀ
/// D L the contact forces are computed at y = L⁻ᵀ f. There contacts involve only the rows between
/// their feet and the root, and so does f. So columns of one branch of the tree (a leg) are
/// processed together, and do not touch the rows of other branches before the second half.
class ColumnSolver {
 public:
  /// A nonzero entry of the matrix that maps controls to generalized forces.
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
    AlignedVector<S> y;  ///< all columns of a batch, interleaved by rows
    AlignedVector<S> w;  ///< rows of the contacts
  };

  /// Overwrites Jᵀ in contacts.response with L⁻ᵀ Jᵀ; writes contacts.scaled and the lower triangle
  /// of G.
  template <class S>
  void prepare_contacts(const MassFactors<S>& factors, ContactSet::Data<S>& contacts,
                        Data<S>& data) const;
  /// x ← L⁻ᵀ x.
  template <class S>
  void solve_first_half(const MassFactors<S>& factors, S* x) const;
  /// x ← L⁻¹ D⁻¹ x.
  template <class S>
  void solve_second_half(const MassFactors<S>& factors, S* x) const;

  /// On entry contacts.force is −c and y is L⁻ᵀ f. On return contacts.force is λ and y includes L⁻ᵀ
  /// Jᵀ λ. G must be factored.
  template <class S>
  void hold_contacts(ContactSet::Data<S>& contacts, S* y) const;

  /// Right-hand sides: −tau_q, −tau_v (0 if null), then the columns of the controls. On entry
  /// force_z (m x (2 n + nu)) is −c, on return λ; fx and fu receive a.
  template <class S>
  void solve_columns(const MassFactors<S>& factors, const S* tau_q, const S* tau_v,
                     ContactSet::Data<S>& contacts, S* fx, S* fu, Data<S>& data) const;

 private:
  /// Rows of one branch and of its root; a branch without a root includes all rows.
  struct Branch {
    int begin, end;
    int root_begin = 0, root_end = 0;
    bool has(int row) const {
      return (row >= begin && row < end) || (row >= root_begin && row < root_end);
    }
  };
  /// Columns of f whose rows lie in one branch.
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
  std::vector<int> contact_offsets_;  ///< one more entry than contacts
  std::vector<std::vector<Entry>> controls_;
};

}  // namespace conddp
