#pragma once

#include "spatial/lane.hpp"
#include "spatial/scalar.hpp"

namespace conddp {

/// A dual number v + d ε with ε² = 0: propagates a value and its derivative along one direction
/// exactly through any kernel. Over `Lane` each lane has its own direction. Comparisons and
/// `select` use only the value.
template <class S>
struct Dual {
  S v;
  S d;

  Dual() = default;
  Dual(double a) : v(a), d(0.0) {}  // NOLINT(google-explicit-constructor): a constant
  Dual(S value, S derivative) : v(value), d(derivative) {}

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
  friend Dual operator-(const Dual& a) { return {-a.v, -a.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.v * b.d + a.d * b.v}; }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const S inverse = S(1.0) / b.v;
    const S q = a.v * inverse;
    return {q, (a.d - q * b.d) * inverse};
  }
  friend Dual operator*(const Dual& a, double b) { return {a.v * S(b), a.d * S(b)}; }
  friend Dual operator*(double a, const Dual& b) { return b * a; }

  friend auto operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend auto operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  friend auto operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend auto operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
};

template <class S>
inline constexpr bool kIsScalar<Dual<S>> = true;

template <class Mask, class S>
Dual<S> select(Mask m, const Dual<S>& a, const Dual<S>& b) {
  return {select(m, a.v, b.v), select(m, a.d, b.d)};
}
template <class S>
Dual<S> min(const Dual<S>& a, const Dual<S>& b) {
  return select(b < a, b, a);
}
template <class S>
Dual<S> max(const Dual<S>& a, const Dual<S>& b) {
  return select(a < b, b, a);
}
template <class S>
Dual<S> abs(const Dual<S>& a) {
  return select(a < Dual<S>(0.0), -a, a);
}
template <class S>
S value_of(const Dual<S>& a) {
  return a.v;
}
template <class S>
Dual<S> sqrt(const Dual<S>& a) {
  const S root = sqrt(a.v);
  return {root, a.d / (root + root)};
}
template <class S>
Dual<S> exp(const Dual<S>& a) {
  const S e = exp(a.v);
  return {e, e * a.d};
}
template <class S>
Dual<S> log(const Dual<S>& a) {
  return {log(a.v), a.d / a.v};
}
template <class S>
void sincos(const Dual<S>& a, Dual<S>& s, Dual<S>& c) {
  S sv, cv;
  sincos(a.v, sv, cv);
  s = {sv, cv * a.d};
  c = {cv, -(sv * a.d)};
}
template <class S>
Dual<S> sin(const Dual<S>& a) {
  Dual<S> s, c;
  sincos(a, s, c);
  return s;
}
template <class S>
Dual<S> cos(const Dual<S>& a) {
  Dual<S> s, c;
  sincos(a, s, c);
  return c;
}
template <class S>
Dual<S> tan(const Dual<S>& a) {
  const S t = tan(a.v);
  return {t, (S(1.0) + t * t) * a.d};
}
template <class S>
Dual<S> asin(const Dual<S>& a) {
  return {asin(a.v), a.d / sqrt(S(1.0) - a.v * a.v)};
}
template <class S>
Dual<S> acos(const Dual<S>& a) {
  return {acos(a.v), -(a.d / sqrt(S(1.0) - a.v * a.v))};
}
template <class S>
Dual<S> atan2(const Dual<S>& y, const Dual<S>& x) {
  return {atan2(y.v, x.v), (y.d * x.v - x.d * y.v) / (x.v * x.v + y.v * y.v)};
}

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
