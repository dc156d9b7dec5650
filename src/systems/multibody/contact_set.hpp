#pragma once

#include <vector>

#include <Eigen/Core>

#include "robot/contact.hpp"
#include "systems/multibody/mimic_map.hpp"

namespace conddp {

/// Contacts that a robot holds at the same time, and the linear algebra of their forces λ (m rows,
/// the contacts' one after the other): with M a = f + Jᵀλ and J a + c = 0,
///   G λ = −c − J M⁻¹ f,  G = J M⁻¹ Jᵀ.
///
/// Where the rows depend on each other (several contacts on one body, straight legs), G is
/// singular. Such a G gets a compliance ε on its diagonal, so that J a + c + ε λ = 0: forces are
/// then the smallest ones, to rounding over ε. A G whose smallest pivot is above 10 ε is left
/// as it is. In lanes each lane decides for itself.
class ContactSet {
 public:
  ContactSet() = default;
  /// Throws std::invalid_argument where a contact's frame does not move.
  ContactSet(const RobotModel& model, const MimicMap& mimics, std::vector<Contact> contacts);

  bool empty() const { return contacts_.empty(); }
  const std::vector<Contact>& contacts() const { return contacts_; }
  int count() const { return static_cast<int>(contacts_.size()); }
  /// Rows of all contacts, and the first one of a contact.
  int rows() const { return rows_; }
  int offset(int contact) const { return offsets_[contact]; }
  /// ε, 1/kg (for a row of angular motion 1/(kg m²)).
  double compliance() const { return compliance_; }
  /// Adds a symmetric matrix of all rows to G in every state (ContactRank::softness), so that
  /// J a + c + softness λ = 0.
  void soften(const Eigen::MatrixXd& softness);
  /// Velocity indices (of the system) that move a contact.
  const std::vector<int>& columns(int contact) const { return columns_[contact].columns(); }

  template <class S>
  struct Data {
    Data(const ContactSet& set, const RobotModel& model, int nv, int nu);

    std::vector<ContactData<S>> contacts;
    std::vector<AlignedVector<S>> reduced;  ///< Jacobians in the system's velocities, mimics only
    AlignedVector<S> gathered;              ///< scratch of the size of the largest of them
    AlignedVector<S> response;    ///< Jᵀ, then L⁻ᵀ Jᵀ with M = Lᵀ D L; nv x m by columns
    AlignedVector<S> scaled;      ///< D⁻¹ times that
    AlignedVector<S> G, factors;  ///< m x m by columns, lower triangles
    MaskOf<S> compliant;          ///< where ε was added
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
  /// Gives the contacts their forces and bodies their wrenches from λ in `force`.
  template <class S>
  void distribute_forces(const RobotModel& model, Data<S>& data) const;
  /// W(:, first + j) −= the contacts' columns for the derivative `member` (wrt_q or wrt_v).
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
  std::vector<double> softness_;  ///< added to G: m x m, or nothing
};

}  // namespace conddp
