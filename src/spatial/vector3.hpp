#pragma once

#include "spatial/scalar.hpp"

namespace conddp {

/// A vector of three scalars.
template <class S>
struct Vector3 {
  S x, y, z;

  const S& operator[](int i) const { return (&x)[i]; }
  S& operator[](int i) { return (&x)[i]; }
  Vector3& operator+=(const Vector3& b) { return x += b.x, y += b.y, z += b.z, *this; }
  Vector3& operator-=(const Vector3& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
  static Vector3 zero() { return {S(0.0), S(0.0), S(0.0)}; }

  /// The same constants in another scalar type.
  template <class T>
  Vector3<T> cast() const {
    return {T(x), T(y), T(z)};
  }
};

template <class A, class B>
auto operator+(const Vector3<A>& a, const Vector3<B>& b) {
  using R = std::remove_cvref_t<decltype(a.x + b.x)>;
  return Vector3<R>{a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class A, class B>
auto operator-(const Vector3<A>& a, const Vector3<B>& b) {
  using R = std::remove_cvref_t<decltype(a.x - b.x)>;
  return Vector3<R>{a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S>
Vector3<S> operator-(const Vector3<S>& a) {
  return {-a.x, -a.y, -a.z};
}
template <Scalar A, class B>
Vector3<ProductOf<A, B>> operator*(const A& s, const Vector3<B>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class A, class B>
ProductOf<A, B> dot(const Vector3<A>& a, const Vector3<B>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class A, class B>
Vector3<ProductOf<A, B>> cross(const Vector3<A>& a, const Vector3<B>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class S>
S squared_norm(const Vector3<S>& a) {
  return dot(a, a);
}

/// A 3x3 matrix by rows.
template <class S>
struct Matrix3 {
  S m[9];

  const S& operator()(int row, int column) const { return m[3 * row + column]; }
  S& operator()(int row, int column) { return m[3 * row + column]; }
  Vector3<S> row(int i) const { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }
  Vector3<S> column(int j) const { return {m[j], m[3 + j], m[6 + j]}; }

  static Matrix3 identity() {
    return {{S(1.0), S(0.0), S(0.0), S(0.0), S(1.0), S(0.0), S(0.0), S(0.0), S(1.0)}};
  }
  static Matrix3 zero() {
    return {{S(0.0), S(0.0), S(0.0), S(0.0), S(0.0), S(0.0), S(0.0), S(0.0), S(0.0)}};
  }
  template <class T>
  Matrix3<T> cast() const {
    Matrix3<T> r;
    for (int i = 0; i < 9; ++i) r.m[i] = T(m[i]);
    return r;
  }
};

template <class A, class B>
Vector3<ProductOf<A, B>> operator*(const Matrix3<A>& a, const Vector3<B>& b) {
  return {a.m[0] * b.x + a.m[1] * b.y + a.m[2] * b.z, a.m[3] * b.x + a.m[4] * b.y + a.m[5] * b.z,
          a.m[6] * b.x + a.m[7] * b.y + a.m[8] * b.z};
}
template <class A, class B>
Matrix3<ProductOf<A, B>> operator*(const Matrix3<A>& a, const Matrix3<B>& b) {
  Matrix3<ProductOf<A, B>> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return r;
}
template <class S>
Matrix3<S> operator+(const Matrix3<S>& a, const Matrix3<S>& b) {
  Matrix3<S> r;
  for (int i = 0; i < 9; ++i) r.m[i] = a.m[i] + b.m[i];
  return r;
}
template <class S>
Matrix3<S> operator-(const Matrix3<S>& a, const Matrix3<S>& b) {
  Matrix3<S> r;
  for (int i = 0; i < 9; ++i) r.m[i] = a.m[i] - b.m[i];
  return r;
}
template <Scalar A, class B>
Matrix3<ProductOf<A, B>> operator*(const A& s, const Matrix3<B>& a) {
  Matrix3<ProductOf<A, B>> r;
  for (int i = 0; i < 9; ++i) r.m[i] = s * a.m[i];
  return r;
}
template <class S>
Matrix3<S> transpose(const Matrix3<S>& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}
/// aᵀ b.
template <class A, class B>
Vector3<ProductOf<A, B>> transpose_times(const Matrix3<A>& a, const Vector3<B>& b) {
  return {a.m[0] * b.x + a.m[3] * b.y + a.m[6] * b.z, a.m[1] * b.x + a.m[4] * b.y + a.m[7] * b.z,
          a.m[2] * b.x + a.m[5] * b.y + a.m[8] * b.z};
}
/// The matrix of the cross product: skew(a) b = a × b.
template <class S>
Matrix3<S> skew(const Vector3<S>& a) {
  return {{S(0.0), -a.z, a.y, a.z, S(0.0), -a.x, -a.y, a.x, S(0.0)}};
}

/// A symmetric 3x3 matrix.
template <class S>
struct Symmetric3 {
  S xx, xy, xz, yy, yz, zz;

  static Symmetric3 zero() { return {S(0.0), S(0.0), S(0.0), S(0.0), S(0.0), S(0.0)}; }
  Symmetric3& operator+=(const Symmetric3& b) {
    return xx += b.xx, xy += b.xy, xz += b.xz, yy += b.yy, yz += b.yz, zz += b.zz, *this;
  }
};
template <class A, class B>
Vector3<ProductOf<A, B>> operator*(const Symmetric3<A>& a, const Vector3<B>& b) {
  return {a.xx * b.x + a.xy * b.y + a.xz * b.z, a.xy * b.x + a.yy * b.y + a.yz * b.z,
          a.xz * b.x + a.yz * b.y + a.zz * b.z};
}

}  // namespace conddp
