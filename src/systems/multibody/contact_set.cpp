#include "systems/multibody/contact_set.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

/// ε times the robot's mass.
constexpr double kCompliance = 1e-6;

}  // namespace

template <class S>
void factorize_ldlt(int n, S* A) {
  for (int k = 0; k < n; ++k) {
    S* pivot = A + k * n;
    pivot[k] = S(1.0) / pivot[k];
    for (int j = k + 1; j < n; ++j) {
      const S factor = pivot[j] * pivot[k];
      for (int i = j; i < n; ++i) A[j * n + i] -= pivot[i] * factor;
    }
    for (int i = k + 1; i < n; ++i) pivot[i] *= pivot[k];
  }
}

template <class S>
void solve_ldlt(int n, const S* factors, S* x) {
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i) x[i] -= factors[k * n + i] * x[k];
  for (int k = n - 1; k >= 0; --k) {
    S sum = x[k] * factors[k * n + k];
    for (int i = k + 1; i < n; ++i) sum -= factors[k * n + i] * x[i];
    x[k] = sum;
  }
}

ContactSet::ContactSet(const RobotModel& model, const MimicMap& mimics,
                       std::vector<Contact> contacts)
    : contacts_(std::move(contacts)) {
  double mass = 0;
  for (const Joint& joint : model.joints) mass += joint.inertia.mass;
  compliance_ = kCompliance / mass;
  for (const Contact& contact : contacts_) {
    if (model.frames[contact.frame].joint < 0)
      throw std::invalid_argument("contact " + contact.name + ": frame " +
                                  model.frames[contact.frame].name + " is fixed to the world");
    columns_.emplace_back(mimics, support(model, contact.pair()));
    offsets_.push_back(rows_);
    rows_ += contact.rows();
  }
}

void ContactSet::soften(const Eigen::MatrixXd& softness) {
  softness_.assign(softness.data(), softness.data() + softness.size());
}

template <class S>
ContactSet::Data<S>::Data(const ContactSet& set, const RobotModel& model, int nv, int nu) {
  const int m = set.rows();
  std::size_t largest = 0;
  for (int i = 0; i < set.count(); ++i) {
    contacts.emplace_back(model, set.contacts_[i]);
    const std::size_t size = set.contacts_[i].rows() * set.columns_[i].count();
    reduced.emplace_back(set.columns_[i].identity() ? 0 : size, S(0.0));
    largest = std::max(largest, size);
  }
  gathered.assign(largest, S(0.0));
  response.assign(nv * m, S(0.0));
  scaled.assign(nv * m, S(0.0));
  G.assign(m * m, S(0.0));
  factors.assign(m * m, S(0.0));
  force.assign(m, S(0.0));
  force_z.assign(m * (2 * nv + nu), S(0.0));
  if (m > 0) wrenches.assign(model.joint_count(), Force<S>::zero());
}

template <class S>
void ContactSet::update(const RobotModel& model, const RobotData<S>& robot, int nv,
                        Data<S>& data) const {
  std::fill(data.response.begin(), data.response.end(), S(0.0));
  for (int i = 0; i < count(); ++i) {
    update_contact(model, contacts_[i], robot, data.contacts[i]);
    const int rows = contacts_[i].rows();
    if (!columns_[i].identity())
      columns_[i].gather(data.contacts[i].jacobian.data(), rows, data.reduced[i].data());
    const AlignedVector<S>& J = jacobian(data, i);
    for (int c = 0; c < columns_[i].count(); ++c)
      for (int r = 0; r < rows; ++r)
        data.response[(offsets_[i] + r) * nv + columns(i)[c]] = J[c * rows + r];
  }
}

template <class S>
void ContactSet::factorize(Data<S>& data) const {
  const int m = rows_;
  const auto reset = [&] {
    data.factors = data.G;
    for (std::size_t i = 0; i < softness_.size(); ++i) data.factors[i] += S(softness_[i]);
  };
  reset();
  factorize_ldlt(m, data.factors.data());
  const S largest_inverse(1 / (10 * compliance_));
  MaskOf<S>& singular = data.compliant;
  singular = S(1.0) < S(0.0);
  for (int k = 0; k < m; ++k) {
    const S& inverse = data.factors[k * m + k];
    singular = singular | !(inverse > S(0.0)) | !(inverse < largest_inverse);
  }
  if (!any(singular)) return;
  reset();
  const S epsilon = select(singular, S(compliance_), S(0.0));
  for (int k = 0; k < m; ++k) data.factors[k * m + k] += epsilon;
  factorize_ldlt(m, data.factors.data());
}

template <class S>
void ContactSet::add_product(const Data<S>& data, double sign, const S* x, S* out) const {
  for (int i = 0; i < count(); ++i) {
    const int rows = contacts_[i].rows();
    const AlignedVector<S>& J = jacobian(data, i);
    for (int r = 0; r < rows; ++r) {
      S sum(0.0);
      for (int c = 0; c < columns_[i].count(); ++c) sum += J[c * rows + r] * x[columns(i)[c]];
      out[offsets_[i] + r] += S(sign) * sum;
    }
  }
}

template <class S>
void ContactSet::distribute_forces(const RobotModel& model, Data<S>& data) const {
  std::fill(data.wrenches.begin(), data.wrenches.end(), Force<S>::zero());
  for (int i = 0; i < count(); ++i) {
    set_contact_force(contacts_[i], &data.force[offsets_[i]], data.contacts[i]);
    add_contact_wrench(model, contacts_[i], data.contacts[i], data.wrenches);
  }
}

template <class S>
void ContactSet::subtract_derivative(Data<S>& data, AlignedVector<S> ContactData<S>::*member,
                                     int first, S* W) const {
  for (int i = 0; i < count(); ++i) {
    const int rows = contacts_[i].rows();
    const S* columns_in = (data.contacts[i].*member).data();
    if (!columns_[i].identity()) {
      columns_[i].gather(columns_in, rows, data.gathered.data());
      columns_in = data.gathered.data();
    }
    for (int c = 0; c < columns_[i].count(); ++c)
      for (int r = 0; r < rows; ++r)
        W[(first + columns(i)[c]) * rows_ + offsets_[i] + r] -= columns_in[c * rows + r];
  }
}

#define CONDDP_INSTANTIATE(S)                                                                      \
  template void factorize_ldlt(int n, S* A);                                                       \
  template void solve_ldlt(int n, const S*, S*);                                                   \
  template struct ContactSet::Data<S>;                                                             \
  template void ContactSet::update(const RobotModel&, const RobotData<S>&, int, Data<S>&) const;   \
  template void ContactSet::factorize(Data<S>&) const;                                             \
  template void ContactSet::add_product(const Data<S>&, double, const S*, S*) const;               \
  template void ContactSet::distribute_forces(const RobotModel&, Data<S>&) const;                  \
  template void ContactSet::subtract_derivative(Data<S>&, AlignedVector<S> ContactData<S>::*, int, \
                                                S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
