#pragma once

#include "spatial/se3.hpp"

namespace conddp {

/// Rigid-body inertia about a frame's origin: mass (kg), first moment of mass m c (kg m), and
/// rotational inertia about that origin (kg m²).
template <class S>
struct Inertia {
  S mass;
  Vector3<S> moment;
  Symmetric3<S> rotational;

  static Inertia zero() { return {S(0.0), Vector3<S>::zero(), Symmetric3<S>::zero()}; }
  Inertia& operator+=(const Inertia& b) {
    return mass += b.mass, moment += b.moment, rotational += b.rotational, *this;
  }
};

/// I m: the momentum of a body moving with m.
template <class A, class B>
Force<ProductOf<A, B>> operator*(const Inertia<A>& i, const Motion<B>& m) {
  return {i.mass * m.linear - cross(i.moment, m.angular),
          i.rotational * m.angular + cross(i.moment, m.linear)};
}

/// The m c² terms: the rotational inertia of a point mass at c is mass·(cᵀc 1 − c cᵀ).
template <class S>
Symmetric3<S> point_inertia(const S& mass, const Vector3<S>& c) {
  const S xx = mass * c.x * c.x, yy = mass * c.y * c.y, zz = mass * c.z * c.z;
  return {yy + zz, -(mass * c.x * c.y), -(mass * c.x * c.z), xx + zz, -(mass * c.y * c.z), xx + yy};
}

/// Inertia from mass, center of mass and rotational inertia about the center of mass.
template <class S>
Inertia<S> inertia_about_origin(const S& mass, const Vector3<S>& com,
                                const Symmetric3<S>& central) {
  Symmetric3<S> rotational = central;
  rotational += point_inertia(mass, com);
  return {mass, mass * com, rotational};
}

/// R J Rᵀ.
template <class A, class B>
Symmetric3<ProductOf<A, B>> rotate(const Matrix3<A>& r, const Symmetric3<B>& j) {
  const auto a = j * r.row(0), b = j * r.row(1), c = j * r.row(2);
  return {dot(r.row(0), a), dot(r.row(1), a), dot(r.row(2), a),
          dot(r.row(1), b), dot(r.row(2), b), dot(r.row(2), c)};
}

/// The inertia of the inner frame expressed in the outer one.
template <class A, class B>
Inertia<ProductOf<A, B>> act(const SE3<A>& a, const Inertia<B>& i) {
  using S = ProductOf<A, B>;
  const Vector3<S> rc = a.R * i.moment;  // m R c
  const Vector3<S> moment = rc + i.mass * a.p;
  Symmetric3<S> j = rotate(a.R, i.rotational);
  // Parallel axes: + m (p·p 1 − p pᵀ) + 2 (p·mRc) 1 − p (mRc)ᵀ − (mRc) pᵀ. With h = mRc + ½ m p,
  // the sum is twice (h·p) 1 − sym.
  const Vector3<S> h = rc + moment;
  const S hp = dot(h, a.p);
  const S half(0.5);
  j.xx += hp - h.x * a.p.x;
  j.yy += hp - h.y * a.p.y;
  j.zz += hp - h.z * a.p.z;
  j.xy -= half * (h.x * a.p.y + h.y * a.p.x);
  j.xz -= half * (h.x * a.p.z + h.z * a.p.x);
  j.yz -= half * (h.y * a.p.z + h.z * a.p.y);
  return {S(1.0) * i.mass, moment, j};
}

/// Rate of the rotational inertia about a fixed origin for a body moving with v: the lower right
/// block of v ×* I − I v ×.
template <class S>
Symmetric3<S> rotational_inertia_rate(const Inertia<S>& i, const Motion<S>& v) {
  const Symmetric3<S>& j = i.rotational;
  const Vector3<S>& w = v.angular;
  const Vector3<S>& c = i.moment;
  const Vector3<S> a = cross(w, Vector3<S>{j.xx, j.xy, j.xz});
  const Vector3<S> b = cross(w, Vector3<S>{j.xy, j.yy, j.yz});
  const Vector3<S> d = cross(w, Vector3<S>{j.xz, j.yz, j.zz});
  const Vector3<S>& u = v.linear;
  const S two(2.0);
  const S uc = two * dot(u, c);
  return {two * (a.x - u.x * c.x) + uc,      a.y + b.x - u.x * c.y - u.y * c.x,
          a.z + d.x - u.x * c.z - u.z * c.x, two * (b.y - u.y * c.y) + uc,
          b.z + d.y - u.y * c.z - u.z * c.y, two * (d.z - u.z * c.z) + uc};
}

}  // namespace conddp
