#pragma once

#include <cstdint>

#include "spatial/scalar.hpp"

namespace conddp {

#if defined(__AVX512F__)
inline constexpr int kLaneWidth = 8;
#elif defined(__AVX__)
inline constexpr int kLaneWidth = 4;
#else
inline constexpr int kLaneWidth = 2;
#endif

/// Truth values, one per lane: all bits set where true.
struct LaneMask {
  using Vector = std::int64_t __attribute__((vector_size(8 * kLaneWidth)));
  Vector v;

  friend LaneMask operator&(LaneMask a, LaneMask b) { return {a.v & b.v}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.v | b.v}; }
  friend LaneMask operator!(LaneMask a) { return {~a.v}; }
};

inline bool any(LaneMask m) {
  std::int64_t bits = 0;
  for (int i = 0; i < kLaneWidth; ++i) bits |= m.v[i];
  return bits != 0;
}

/// One double per lane, as wide as the machine's registers. A kernel with this scalar evaluates
/// kLaneWidth knots (or step lengths, or derivative directions) at once.
struct alignas(8 * kLaneWidth) Lane {
  using Vector = double __attribute__((vector_size(8 * kLaneWidth)));
  Vector v;

  Lane() = default;
  /// Broadcasts a. The subtraction a − 0 equals a bit for bit, so the compiler removes it; a + 0
  /// does not.
  Lane(double a) : v(a - Vector{}) {}  // NOLINT(google-explicit-constructor)
  explicit Lane(Vector a) : v(a) {}

  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double a) { v[lane] = a; }

  Lane& operator+=(Lane b) { return v += b.v, *this; }
  Lane& operator-=(Lane b) { return v -= b.v, *this; }
  Lane& operator*=(Lane b) { return v *= b.v, *this; }
  Lane& operator/=(Lane b) { return v /= b.v, *this; }
  friend Lane operator+(Lane a, Lane b) { return Lane(a.v + b.v); }
  friend Lane operator-(Lane a, Lane b) { return Lane(a.v - b.v); }
  friend Lane operator*(Lane a, Lane b) { return Lane(a.v * b.v); }
  friend Lane operator/(Lane a, Lane b) { return Lane(a.v / b.v); }
  friend Lane operator-(Lane a) { return Lane(-a.v); }
  friend LaneMask operator<(Lane a, Lane b) { return {a.v < b.v}; }
  friend LaneMask operator<=(Lane a, Lane b) { return {a.v <= b.v}; }
  friend LaneMask operator>(Lane a, Lane b) { return {a.v > b.v}; }
  friend LaneMask operator>=(Lane a, Lane b) { return {a.v >= b.v}; }
  friend LaneMask operator==(Lane a, Lane b) { return {a.v == b.v}; }
};

template <>
inline constexpr bool kIsScalar<Lane> = true;

inline Lane select(LaneMask m, Lane a, Lane b) { return Lane(m.v ? a.v : b.v); }
inline Lane min(Lane a, Lane b) { return select(b < a, b, a); }
inline Lane max(Lane a, Lane b) { return select(a < b, b, a); }
inline Lane abs(Lane a) { return select(a < Lane(0.0), -a, a); }
inline Lane value_of(Lane a) { return a; }

/// Applies a function of doubles lane by lane, outside hot paths.
template <class F, class... Args>
Lane lanewise(F f, Args... args) {
  Lane r;
  for (int i = 0; i < kLaneWidth; ++i) r.v[i] = f(args[i]...);
  return r;
}

inline Lane sqrt(Lane a) {
  return lanewise([](double x) { return std::sqrt(x); }, a);
}
inline Lane exp(Lane a) {
  return lanewise([](double x) { return std::exp(x); }, a);
}
inline Lane log(Lane a) {
  return lanewise([](double x) { return std::log(x); }, a);
}
inline Lane tan(Lane a) {
  return lanewise([](double x) { return std::tan(x); }, a);
}
inline Lane asin(Lane a) {
  return lanewise([](double x) { return std::asin(x); }, a);
}
inline Lane acos(Lane a) {
  return lanewise([](double x) { return std::acos(x); }, a);
}
inline Lane atan2(Lane y, Lane x) {
  return lanewise([](double b, double a) { return std::atan2(b, a); }, y, x);
}

namespace detail {
/// Cody-Waite reduction by π/2 in three parts; minimax polynomials of degree 13 and 14 on [−π/4,
/// π/4], with the coefficients of fdlibm's kernels.
inline void sincos_of_moderate(Lane angle, Lane& s, Lane& c) {
  const Lane to_integer(6755399441055744.0);  // 1.5·2^52: the sum rounds to an integer
  const Lane shifted = angle * Lane(0.63661977236758134308) + to_integer;
  const Lane turns = shifted - to_integer;
  const LaneMask::Vector quadrant = (LaneMask::Vector)shifted.v;  // reinterprets the bits
  Lane r = angle - turns * Lane(1.5707963267341256e+00);
  r -= turns * Lane(6.0771005063039660e-11);
  r -= turns * Lane(2.0222662487959506e-21);
  const Lane z = r * r;
  const Lane sin_r = r + r * z *
                             (Lane(-1.66666666666666324348e-01) +
                              z * (Lane(8.33333333332248946124e-03) +
                                   z * (Lane(-1.98412698298579493134e-04) +
                                        z * (Lane(2.75573137070700676789e-06) +
                                             z * (Lane(-2.50507602534068634195e-08) +
                                                  z * Lane(1.58969099521155010221e-10))))));
  const Lane cos_r = Lane(1.0) - Lane(0.5) * z +
                     z * z *
                         (Lane(4.16666666666666019037e-02) +
                          z * (Lane(-1.38888888888741095749e-03) +
                               z * (Lane(2.48015872894767294178e-05) +
                                    z * (Lane(-2.75573143513906633035e-07) +
                                         z * (Lane(2.08757232129817482790e-09) +
                                              z * Lane(-1.13596475577881948265e-11))))));
  const LaneMask odd{(quadrant & 1) != 0};
  const LaneMask sin_negative{(quadrant & 2) != 0};
  const LaneMask cos_negative{((quadrant + 1) & 2) != 0};
  const Lane s0 = select(odd, cos_r, sin_r);
  const Lane c0 = select(odd, sin_r, cos_r);
  s = select(sin_negative, -s0, s0);
  c = select(cos_negative, -c0, c0);
}
}  // namespace detail

/// Sine and cosine in all lanes at once, to about 1 ulp for |angle| ≤ 1e5. A lane beyond this bound
/// uses libm without affecting the others.
inline void sincos(Lane angle, Lane& s, Lane& c) {
  detail::sincos_of_moderate(angle, s, c);
  const LaneMask beyond = !(abs(angle) <= Lane(1e5));
  if (any(beyond)) [[unlikely]] {
    for (int i = 0; i < kLaneWidth; ++i) {
      if (!beyond.v[i]) continue;
      s.set(i, std::sin(angle[i]));
      c.set(i, std::cos(angle[i]));
    }
  }
}

inline Lane sin(Lane a) {
  Lane s, c;
  sincos(a, s, c);
  return s;
}
inline Lane cos(Lane a) {
  Lane s, c;
  sincos(a, s, c);
  return c;
}

}  // namespace conddp
