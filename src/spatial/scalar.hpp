#pragma once

#include <cmath>
#include <type_traits>

/// Operations of every kernel scalar beyond arithmetic, here for `double`.
///
/// Kernels are templates on a scalar S: `double`, `Lane` (one knot per SIMD lane) or `Dual<S>` (a
/// value and one directional derivative). They must not branch on data: `select` chooses per lane.
namespace conddp {

using std::abs;
using std::acos;
using std::asin;
using std::atan2;
using std::cos;
using std::exp;
using std::log;
using std::sin;
using std::sqrt;
using std::tan;

/// True if S is a kernel scalar; specialized for each of them.
template <class S>
inline constexpr bool kIsScalar = std::is_floating_point_v<S>;

template <class S>
concept Scalar = kIsScalar<std::remove_cvref_t<S>>;

/// The result of comparing two scalars of type S: bool, or one truth value per lane.
template <class S>
using MaskOf = decltype(std::declval<S>() < std::declval<S>());

/// `a` if the condition is true, else `b`. Both are evaluated.
inline double select(bool condition, double a, double b) { return condition ? a : b; }

/// Sine and cosine of an angle in radians.
inline void sincos(double angle, double& s, double& c) {
  s = std::sin(angle);
  c = std::cos(angle);
}

inline double min(double a, double b) { return b < a ? b : a; }
inline double max(double a, double b) { return a < b ? b : a; }

/// The value without derivative parts.
inline double value_of(double a) { return a; }

/// True if the condition is true in at least one lane.
inline bool any(bool condition) { return condition; }

/// Type of the product of two scalars, for example a model constant and a lane.
template <class A, class B>
using ProductOf = std::remove_cvref_t<decltype(std::declval<A>() * std::declval<B>())>;

}  // namespace conddp
