#pragma once

#include "spatial/so3.hpp"
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
template <class S>
Motion<S> operator-(const Motion<S>& a) {
  return {-a.linear, -a.angular};
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

/// A placement: x_outer = R x_inner + p.
template <class S>
struct SE3 {
  Matrix3<S> R;
  Vector3<S> p;

  static SE3 identity() { return {Matrix3<S>::identity(), Vector3<S>::zero()}; }
  template <class T>
  SE3<T> cast() const {
    return {R.template cast<T>(), p.template cast<T>()};
  }
};

template <class A, class B>
SE3<ProductOf<A, B>> operator*(const SE3<A>& a, const SE3<B>& b) {
  return {a.R * b.R, a.p + a.R * b.p};
}
template <class S>
SE3<S> inverse(const SE3<S>& a) {
  const Matrix3<S> rt = transpose(a.R);
  return {rt, -(rt * a.p)};
}
/// A twist of the inner frame expressed in the outer one (Ad m).
template <class S>
Motion<S> act(const SE3<S>& a, const Motion<S>& m) {
  const Vector3<S> w = a.R * m.angular;
  return {a.R * m.linear + cross(a.p, w), w};
}
/// A twist of the outer frame expressed in the inner one (Ad⁻¹ m).
template <class S>
Motion<S> act_inverse(const SE3<S>& a, const Motion<S>& m) {
  return {transpose_times(a.R, m.linear - cross(a.p, m.angular)), transpose_times(a.R, m.angular)};
}
template <class S>
Force<S> act(const SE3<S>& a, const Force<S>& f) {
  const Vector3<S> l = a.R * f.linear;
  return {l, a.R * f.angular + cross(a.p, l)};
}
template <class S>
Force<S> act_inverse(const SE3<S>& a, const Force<S>& f) {
  return {transpose_times(a.R, f.linear), transpose_times(a.R, f.angular - cross(a.p, f.linear))};
}

/// A 6x6 matrix by rows, acting on (linear; angular).
template <class S>
struct Matrix6 {
  S m[36];

  const S& operator()(int row, int column) const { return m[6 * row + column]; }
  S& operator()(int row, int column) { return m[6 * row + column]; }

  /// [[a, b], [0, a]]: the structure of adjoints and of Jacobians of the exponential.
  static Matrix6 upper(const Matrix3<S>& a, const Matrix3<S>& b) {
    Matrix6 r;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        r(i, j) = a(i, j);
        r(i, j + 3) = b(i, j);
        r(i + 3, j) = S(0.0);
        r(i + 3, j + 3) = a(i, j);
      }
    return r;
  }
};
/// The matrix of act(a, ·) on motions.
template <class S>
Matrix6<S> adjoint(const SE3<S>& a) {
  return Matrix6<S>::upper(a.R, skew(a.p) * a.R);
}

/// A rigid placement as position and unit quaternion, the format of a free body's state.
template <class S>
struct Pose {
  Vector3<S> p;
  Quaternion<S> q;
};
template <class S>
SE3<S> placement(const Pose<S>& a) {
  return {rotation_matrix(a.q), a.p};
}

/// a exp(m): moves a pose by a twist expressed in its own frame.
template <class S>
Pose<S> integrate_se3(const Pose<S>& a, const Motion<S>& m) {
  const RotationCoefficients<S> k(squared_norm(m.angular));
  const Vector3<S> wv = cross(m.angular, m.linear);
  const Vector3<S> step = m.linear + k.b * wv + k.c * cross(m.angular, wv);
  return {a.p + rotation_matrix(a.q) * step, renormalized(a.q * exp_so3(m.angular))};
}
/// log(R, p) for a relative pose.
template <class S>
Motion<S> log_se3(const Pose<S>& a) {
  const Vector3<S> w = log_so3(a.q);
  const RotationCoefficients<S> k(squared_norm(w));
  const Vector3<S> wp = cross(w, a.p);
  return {a.p - S(0.5) * wp + k.inv * cross(w, wp), w};
}
/// log(a⁻¹ b): the twist in a's frame that moves a to b.
template <class S>
Motion<S> difference_se3(const Pose<S>& a, const Pose<S>& b) {
  return log_se3(Pose<S>{transpose_times(rotation_matrix(a.q), b.p - a.p), conjugate(a.q) * b.q});
}

namespace detail {
/// The upper right block of the right Jacobian of exp on SE(3) (Barfoot and Furgale 2014, eq. 102,
/// evaluated at −m).
template <class S>
Matrix3<S> right_jacobian_block(const Motion<S>& m, const RotationCoefficients<S>& k) {
  const Matrix3<S> x = skew(-m.angular), v = skew(-m.linear);
  const Matrix3<S> xv = x * v, vx = v * x, xvx = xv * x;
  const Matrix3<S> c1 = xv + vx + xvx;
  const Matrix3<S> c2 = x * xv + vx * x - S(3.0) * xvx;
  const Matrix3<S> c3 = xvx * x + x * xvx;
  return S(0.5) * v + k.c * c1 + k.d * c2 + k.e * c3;
}
}  // namespace detail

/// Right Jacobian of exp on SE(3): exp(m + δ) = exp(m) exp(Jr δ) to first order.
template <class S>
Matrix6<S> right_jacobian_se3(const Motion<S>& m) {
  const RotationCoefficients<S> k(squared_norm(m.angular));
  const Matrix3<S> x = skew(m.angular);
  const Matrix3<S> j = Matrix3<S>::identity() - k.b * x + k.c * (x * x);
  return Matrix6<S>::upper(j, detail::right_jacobian_block(m, k));
}
/// Inverse of the right Jacobian; regular at a rotation by π.
template <class S>
Matrix6<S> inverse_right_jacobian_se3(const Motion<S>& m) {
  const RotationCoefficients<S> k(squared_norm(m.angular));
  const Matrix3<S> x = skew(m.angular);
  const Matrix3<S> ji = Matrix3<S>::identity() + S(0.5) * x + k.inv * (x * x);
  const Matrix3<S> q = detail::right_jacobian_block(m, k);
  return Matrix6<S>::upper(ji, S(-1.0) * (ji * q * ji));
}

}  // namespace conddp
