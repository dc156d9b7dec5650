#pragma once

#include <vector>

#include <Eigen/Core>

#include "robot/contact.hpp"
#include "systems/multibody/mimic_map.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Factors a symmetric positive definite matrix (n x n by columns, lower triangle) in place: A = L
/// D Lᵀ. The unit lower triangle L is stored below the diagonal and D⁻¹ on it. Each lane holds its
/// own matrix; no pivoting, hence no branches.
template <class S>
void factorize_ldlt(int n, S* A);

/// x ← A⁻¹ x with the factors.
template <class S>
void solve_ldlt(int n, const S* factors, S* x);

/// Contacts that a robot holds at the same time, and the linear algebra of their forces λ (m rows,
/// contact by contact): with M a = f + Jᵀλ and J a + c = 0,
///   G λ = −c − J M⁻¹ f,  G = J M⁻¹ Jᵀ.
///
/// If the rows depend on each other (several contacts on one body, straight legs), G is singular.
/// We then add a compliance ε to its diagonal, so that J a + c + ε λ = 0. The result is the
/// smallest force, with a rounding error amplified by 1/ε. If the smallest pivot of G is above 10
/// ε, G remains unchanged. Each lane decides separately.
class ContactSet {
 public:
  ContactSet() = default;
  /// Throws std::invalid_argument if a contact's frame cannot move.
  ContactSet(const RobotModel& model, const MimicMap& mimics, std::vector<Contact> contacts);

  bool empty() const { return contacts_.empty(); }
  const std::vector<Contact>& contacts() const { return contacts_; }
  int count() const { return static_cast<int>(contacts_.size()); }
  /// Number of rows of all contacts, and first row of a contact.
  int rows() const { return rows_; }
  int offset(int contact) const { return offsets_[contact]; }
  /// ε, in 1/kg; for rows of angular motion in 1/(kg m²).
  double compliance() const { return compliance_; }
  /// Adds a symmetric matrix over all rows to G in every state (ContactRank::softness), so that J a
  /// + c + softness λ = 0.
  void soften(const Eigen::MatrixXd& softness);
  /// Velocity indices (of the system) that move a contact.
  const std::vector<int>& columns(int contact) const { return columns_[contact].columns(); }

  template <class S>
  struct Data {
    Data(const ContactSet& set, const RobotModel& model, int nv, int nu);

    std::vector<ContactData<S>> contacts;
    std::vector<AlignedVector<S>>
        reduced;                  ///< Jacobians in the system's velocities, with mimics only
    AlignedVector<S> gathered;    ///< scratch with the size of the largest one
    AlignedVector<S> response;    ///< Jᵀ, then L⁻ᵀ Jᵀ with M = Lᵀ D L; nv x m by columns
    AlignedVector<S> scaled;      ///< D⁻¹ times `response`
    AlignedVector<S> G, factors;  ///< m x m by columns, lower triangles
    MaskOf<S> compliant;          ///< lanes with ε added
    AlignedVector<S> force;       ///< m: λ (N, Nm), or impulses (Ns, Nms)
    AlignedVector<S> force_z;     ///< m x (2 nv + nu): derivative of λ
    AlignedVector<Force<S>> wrenches;  ///< per joint, root frame
  };

  /// Writes the contacts' Jacobians, and Jᵀ into `response`.
  template <class S>
  void update(const RobotModel& model, const RobotData<S>& robot, int nv, Data<S>& data) const;
  /// Factors G.
  template <class S>
  void factorize(Data<S>& data) const;
  /// rows += sign · J x.
  template <class S>
  void add_product(const Data<S>& data, double sign, const S* x, S* rows) const;
  /// Sets the contacts' forces and the bodies' wrenches from λ in `force`.
  template <class S>
  void distribute_forces(const RobotModel& model, Data<S>& data) const;
  /// Subtracts the contacts' columns of the derivative `member` (wrt_q or wrt_v) from W(:, first +
  /// j).
  template <class S>
  void subtract_derivative(Data<S>& data, AlignedVector<S> ContactData<S>::*member, int first,
                           S* W) const;

 private:
  template <class S>
  const AlignedVector<S>& jacobian(const Data<S>& data, int contact) const {
    return columns_[contact].identity() ? data.contacts[contact].jacobian : data.reduced[contact];
  }

  std::vector<Contact> contacts_;
  std::vector<ReducedColumns> columns_;
  std::vector<int> offsets_;
  int rows_ = 0;
  double compliance_ = 0;
  std::vector<double> softness_;  ///< added to G: m x m, or empty
};

}  // namespace conddp
