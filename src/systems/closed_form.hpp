#pragma once

#include "systems/system.hpp"

namespace conddp {

/// A system given by a formula: `Derived` has `template <class S> void rate(const S* x, const S* u,
/// S* f) const`, valid for dual numbers too. Jacobians are exact: each column takes one evaluation
/// in dual numbers.
template <class Derived>
class ClosedFormSystem : public SystemBase<Derived> {
 public:
  using SystemBase<Derived>::SystemBase;

  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const Derived& system)
        : x(system.nx()), dx(system.ndx()), u(system.nu()), f_dual(system.rows()) {}
    AlignedVector<Dual<S>> x, dx, u, f_dual;
  };

  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    self().rate(x, u, data.f.data());
  }

  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    self().rate(x, u, data.f.data());
    hold(x, this->nx(), data.x);
    hold(u, this->nu(), data.u);
    differentiate_by_state(x, data);
    differentiate_by_control(data);
  }

  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}

 private:
  template <class S>
  static void hold(const S* values, int count, AlignedVector<Dual<S>>& out) {
    for (int i = 0; i < count; ++i) out[i] = {values[i], S(0.0)};
  }

  /// Differentiates one tangent direction after the other. Leaves the derivatives in data.x zero.
  template <class S>
  void differentiate_by_state(const S* x, Data<S>& data) const {
    const int rows = this->rows();
    for (auto& d : data.dx) d = Dual<S>(0.0);
    for (int j = 0; j < this->ndx(); ++j) {
      data.dx[j].d = S(1.0);
      this->manifold().integrate(data.x.data(), data.dx.data(), data.x.data());
      data.dx[j].d = S(0.0);
      self().rate(data.x.data(), data.u.data(), data.f_dual.data());
      for (int i = 0; i < rows; ++i) data.fx[j * rows + i] = data.f_dual[i].d;
      hold(x, this->nx(), data.x);
    }
  }

  template <class S>
  void differentiate_by_control(Data<S>& data) const {
    const int rows = this->rows();
    for (int j = 0; j < this->nu(); ++j) {
      data.u[j].d = S(1.0);
      self().rate(data.x.data(), data.u.data(), data.f_dual.data());
      data.u[j].d = S(0.0);
      for (int i = 0; i < rows; ++i) data.fu[j * rows + i] = data.f_dual[i].d;
    }
  }

  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

}  // namespace conddp
