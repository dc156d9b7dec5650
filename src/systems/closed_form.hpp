#pragma once

#include "systems/system.hpp"

namespace conddp {

/// A system given by a formula: `Derived` has `template <class S> void rate(const S* x,
/// const S* u, S* f) const`, valid for dual numbers too. Jacobians come from one dual-number
/// direction per column, so they are exact.
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
    const int rows = this->rows();
    for (int i = 0; i < this->nu(); ++i) data.u[i] = {u[i], S(0.0)};
    for (auto& d : data.dx) d = Dual<S>(0.0);
    for (int j = 0; j < this->ndx(); ++j) {
      for (int i = 0; i < this->nx(); ++i) data.x[i] = {x[i], S(0.0)};
      data.dx[j].d = S(1.0);
      this->manifold().integrate(data.x.data(), data.dx.data(), data.x.data());
      data.dx[j].d = S(0.0);
      self().rate(data.x.data(), data.u.data(), data.f_dual.data());
      for (int i = 0; i < rows; ++i) data.fx[j * rows + i] = data.f_dual[i].d;
    }
    for (int i = 0; i < this->nx(); ++i) data.x[i] = {x[i], S(0.0)};
    for (int j = 0; j < this->nu(); ++j) {
      data.u[j].d = S(1.0);
      self().rate(data.x.data(), data.u.data(), data.f_dual.data());
      data.u[j].d = S(0.0);
      for (int i = 0; i < rows; ++i) data.fu[j * rows + i] = data.f_dual[i].d;
    }
  }

  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}

 private:
  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

}  // namespace conddp
