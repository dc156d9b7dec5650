#pragma once

#include "spatial/dual.hpp"

namespace conddp {

/// Elementary functions outside the rigid-body kernels, for every scalar.

using std::atan;
using std::cosh;
using std::pow;
using std::sinh;
using std::tanh;

inline Lane atan(Lane a) {
  return lanewise([](double x) { return std::atan(x); }, a);
}
inline Lane sinh(Lane a) {
  return lanewise([](double x) { return std::sinh(x); }, a);
}
inline Lane cosh(Lane a) {
  return lanewise([](double x) { return std::cosh(x); }, a);
}
inline Lane tanh(Lane a) {
  return lanewise([](double x) { return std::tanh(x); }, a);
}
/// a to the power b.
inline Lane pow(Lane a, Lane b) {
  return lanewise([](double x, double y) { return std::pow(x, y); }, a, b);
}

template <class S>
Dual<S> atan(const Dual<S>& a) {
  return {atan(a.v), a.d / (S(1.0) + a.v * a.v)};
}
template <class S>
Dual<S> sinh(const Dual<S>& a) {
  return {sinh(a.v), cosh(a.v) * a.d};
}
template <class S>
Dual<S> cosh(const Dual<S>& a) {
  return {cosh(a.v), sinh(a.v) * a.d};
}
template <class S>
Dual<S> tanh(const Dual<S>& a) {
  const S t = tanh(a.v);
  return {t, (S(1.0) - t * t) * a.d};
}
/// The derivative with respect to a constant base or exponent need not exist, so it is skipped:
/// that with respect to the exponent contains the logarithm of the base.
template <class S>
Dual<S> pow(const Dual<S>& a, const Dual<S>& b) {
  const S p = pow(a.v, b.v);
  const S zero(0.0);
  const S of_base = select(a.d == zero, zero, b.v * pow(a.v, b.v - S(1.0)) * a.d);
  const S of_exponent = select(b.d == zero, zero, p * log(a.v) * b.d);
  return {p, of_base + of_exponent};
}

}  // namespace conddp
