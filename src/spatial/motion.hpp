#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

template <class S>
struct Force;

/// A spatial velocity or acceleration at a frame's origin: linear part first.
template <class S>
struct Motion {
  Vector3<S> linear, angular;

  static Motion zero() { return {Vector3<S>::zero(), Vector3<S>::zero()}; }
  const S& operator[](int i) const { return i < 3 ? linear[i] : angular[i - 3]; }
  S& operator[](int i) { return i < 3 ? linear[i] : angular[i - 3]; }
  Motion& operator+=(const Motion& b) { return linear += b.linear, angular += b.angular, *this; }
};

/// A spatial force (or momentum) at a frame's origin: linear part first.
template <class S>
struct Force {
  Vector3<S> linear, angular;

  static Force zero() { return {Vector3<S>::zero(), Vector3<S>::zero()}; }
  const S& operator[](int i) const { return i < 3 ? linear[i] : angular[i - 3]; }
  S& operator[](int i) { return i < 3 ? linear[i] : angular[i - 3]; }
  Force& operator+=(const Force& b) { return linear += b.linear, angular += b.angular, *this; }
};

template <class S>
Motion<S> operator+(const Motion<S>& a, const Motion<S>& b) {
  return {a.linear + b.linear, a.angular + b.angular};
}
template <class S>
Motion<S> operator-(const Motion<S>& a, const Motion<S>& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}
template <Scalar A, class S>
Motion<S> operator*(const A& k, const Motion<S>& a) {
  return {k * a.linear, k * a.angular};
}
template <class S>
Force<S> operator+(const Force<S>& a, const Force<S>& b) {
  return {a.linear + b.linear, a.angular + b.angular};
}
template <class S>
Force<S> operator-(const Force<S>& a, const Force<S>& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}
/// Power: mᵀ f.
template <class S>
S dot(const Motion<S>& m, const Force<S>& f) {
  return dot(m.linear, f.linear) + dot(m.angular, f.angular);
}
/// Motion cross product a × b (the rate of change of b when it moves with a).
template <class S>
Motion<S> cross(const Motion<S>& a, const Motion<S>& b) {
  return {cross(a.angular, b.linear) + cross(a.linear, b.angular), cross(a.angular, b.angular)};
}
/// Force cross product a ×* f.
template <class S>
Force<S> cross(const Motion<S>& a, const Force<S>& f) {
  return {cross(a.angular, f.linear), cross(a.angular, f.angular) + cross(a.linear, f.linear)};
}

}  // namespace conddp
