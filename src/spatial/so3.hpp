#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

/// Rotations as unit quaternions with the scalar part last.
template <class S>
struct Quaternion {
  S x, y, z, w;

  static Quaternion identity() { return {S(0.0), S(0.0), S(0.0), S(1.0)}; }
};

template <class S>
Quaternion<S> operator*(const Quaternion<S>& a, const Quaternion<S>& b) {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
template <class S>
Quaternion<S> conjugate(const Quaternion<S>& q) {
  return {-q.x, -q.y, -q.z, q.w};
}
/// One Newton step towards unit length; exact to rounding for a product of unit quaternions.
template <class S>
Quaternion<S> renormalized(const Quaternion<S>& q) {
  const S k = S(1.5) - S(0.5) * (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {k * q.x, k * q.y, k * q.z, k * q.w};
}
/// The rotation matrix of a unit quaternion.
template <class S>
Matrix3<S> rotation_matrix(const Quaternion<S>& q) {
  const S x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const S xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const S xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const S wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  const S one(1.0);
  return {{one - yy - zz, xy - wz, xz + wy, xy + wz, one - xx - zz, yz - wx, xz - wy, yz + wx,
           one - xx - yy}};
}
/// A unit quaternion of a rotation matrix, by Shepperd's method (largest pivot).
template <class S>
Quaternion<S> quaternion(const Matrix3<S>& r) {
  const S one(1.0);
  const S xx = one + r(0, 0) - r(1, 1) - r(2, 2), yy = one - r(0, 0) + r(1, 1) - r(2, 2);
  const S zz = one - r(0, 0) - r(1, 1) + r(2, 2), ww = one + r(0, 0) + r(1, 1) + r(2, 2);
  const S xy = r(0, 1) + r(1, 0), xz = r(0, 2) + r(2, 0), yz = r(1, 2) + r(2, 1);
  const S wx = r(2, 1) - r(1, 2), wy = r(0, 2) - r(2, 0), wz = r(1, 0) - r(0, 1);
  Quaternion<S> q{wx, wy, wz, ww};
  S largest = ww;
  const auto take = [&](const S& pivot, const Quaternion<S>& candidate) {
    const auto larger = value_of(pivot) > value_of(largest);
    q = {select(larger, candidate.x, q.x), select(larger, candidate.y, q.y),
         select(larger, candidate.z, q.z), select(larger, candidate.w, q.w)};
    largest = select(larger, pivot, largest);
  };
  take(xx, {xx, xy, xz, wx});
  take(yy, {xy, yy, yz, wy});
  take(zz, {xz, yz, zz, wz});
  const S k = one / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {k * q.x, k * q.y, k * q.z, k * q.w};
}
/// Rotation by fixed-axis roll, pitch, yaw (radians) as in URDF: Rz(yaw) Ry(pitch) Rx(roll).
template <class S>
Matrix3<S> rotation_rpy(const S& roll, const S& pitch, const S& yaw) {
  S sr, cr, sp, cp, sy, cy;
  sincos(roll, sr, cr);
  sincos(pitch, sp, cp);
  sincos(yaw, sy, cy);
  return {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr,
           sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr}};
}

/// The coefficients of the exponential maps of SO(3) and SE(3) as functions of t = θ², without
/// cancellation: a = sin θ/θ, b = (1 − cos θ)/θ², c = (θ − sin θ)/θ³, d = (½ − b)/θ², e = (3c −
/// b)/(2θ²). The inverse Jacobians use inv = (1 − a/(2b))/θ² (regular at θ = π).
template <class S>
struct RotationCoefficients {
  S a, b, c, d, e, inv;

  explicit RotationCoefficients(const S& t) {
    // Σ (−t)^k / (2k + n)!, exact to rounding for t < 1/4.
    const auto series = [&t](double c0, double c1, double c2, double c3, double c4, double c5,
                             double c6) {
      return S(c0) -
             t * (S(c1) - t * (S(c2) - t * (S(c3) - t * (S(c4) - t * (S(c5) - t * S(c6))))));
    };
    const auto small = value_of(t) < decltype(value_of(t))(0.25);
    const S as =
        series(1.0, 1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800);
    const S bs = series(1.0 / 2, 1.0 / 24, 1.0 / 720, 1.0 / 40320, 1.0 / 3628800, 1.0 / 479001600,
                        1.0 / 87178291200);
    const S cs = series(1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800,
                        1.0 / 6227020800, 1.0 / 1307674368000);
    const S ds = series(1.0 / 24, 1.0 / 720, 1.0 / 40320, 1.0 / 3628800, 1.0 / 479001600,
                        1.0 / 87178291200, 1.0 / 20922789888000);
    const S es = series(1.0 / 120, 2.0 / 5040, 3.0 / 362880, 4.0 / 39916800, 5.0 / 6227020800,
                        6.0 / 1307674368000, 7.0 / 355687428096000);
    const S is =
        S(1.0 / 12) +
        t * (S(1.0 / 720) +
             t * (S(1.0 / 30240) +
                  t * (S(1.0 / 1209600) +
                       t * (S(1.0 / 47900160) + t * (S(691.0 / 1307674368000) +
                                                     t * (S(1.0 / 74724249600) +
                                                          t * S(3617.0 / 10670622842880000)))))));
    const S tl = select(small, S(1.0), t);
    const S theta = sqrt(tl);
    const S it = S(1.0) / tl;
    S sin_theta, cos_theta;
    sincos(theta, sin_theta, cos_theta);
    const S al = sin_theta / theta;
    const S bl = (S(1.0) - cos_theta) * it;
    const S cl = (S(1.0) - al) * it;
    a = select(small, as, al);
    b = select(small, bs, bl);
    c = select(small, cs, cl);
    d = select(small, ds, (S(0.5) - bl) * it);
    e = select(small, es, S(0.5) * (S(3.0) * cl - bl) * it);
    inv = select(small, is, (S(1.0) - al / (bl + bl)) * it);
  }
};

/// exp: rotation vector (rad) to unit quaternion.
template <class S>
Quaternion<S> exp_so3(const Vector3<S>& w) {
  const S t = S(0.25) * squared_norm(w);
  const RotationCoefficients<S> k(t);
  const S h = S(0.5) * k.a;
  // cos(θ/2) = 1 − 2 sin²(θ/4) would avoid cancellation too, but b is already available.
  return {h * w.x, h * w.y, h * w.z, S(1.0) - t * k.b};
}

/// log: unit quaternion to rotation vector, with a length of at most π.
template <class S>
Vector3<S> log_so3(const Quaternion<S>& q) {
  const auto negative = value_of(q.w) < decltype(value_of(q.w))(0.0);
  const S w = select(negative, -q.w, q.w);
  const Vector3<S> v{select(negative, -q.x, q.x), select(negative, -q.y, q.y),
                     select(negative, -q.z, q.z)};
  const S n2 = squared_norm(v);
  const auto small = value_of(n2) < decltype(value_of(n2))(1e-4);
  const S safe = select(small, S(1.0), n2);
  const S n = sqrt(safe);
  const S large_factor = S(2.0) * atan2(n, w) / n;
  // 2 atan(s)/(s w) with s = n/w: a series in s².
  const S iw = S(1.0) / select(small, w, S(1.0));
  const S s2 = n2 * iw * iw;
  const S small_factor =
      S(2.0) * iw *
      (S(1.0) - s2 * (S(1.0 / 3) - s2 * (S(1.0 / 5) - s2 * (S(1.0 / 7) - s2 * S(1.0 / 9)))));
  return select(small, small_factor, large_factor) * v;
}

/// Right Jacobian of the exponential: exp(w + δ) = exp(w) exp(Jr δ) to first order.
template <class S>
Matrix3<S> right_jacobian_so3(const Vector3<S>& w) {
  const RotationCoefficients<S> k(squared_norm(w));
  const Matrix3<S> x = skew(w);
  return Matrix3<S>::identity() - k.b * x + k.c * (x * x);
}
/// Inverse of the right Jacobian; regular at |w| = π.
template <class S>
Matrix3<S> inverse_right_jacobian_so3(const Vector3<S>& w) {
  const RotationCoefficients<S> k(squared_norm(w));
  const Matrix3<S> x = skew(w);
  return Matrix3<S>::identity() + S(0.5) * x + k.inv * (x * x);
}

}  // namespace conddp
