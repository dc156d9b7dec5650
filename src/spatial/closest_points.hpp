#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

/// Segment p + s·d with s from 0 to 1 (a point if d = 0). d rotates with constant length, so its
/// squared length is a constant.
template <class S>
struct Segment {
  Vector3<S> p, d;
  double squared_length;  ///< m²
};

/// The factor of (squared length)·(s − ½)² in the smoothed squared distance of two segments.
/// Without this term the closest points of parallel segments are not unique, and jump when the
/// segments pass through parallel.
inline constexpr double kParallelSmoothing = 1e-5;
/// The value, in m, of the smoothed distance at an exact distance of 0. It gives the distance a
/// gradient there.
inline constexpr double kCrossingSmoothing = 1e-4;

/// The closest points of two segments, and their distance.
template <class S>
struct ClosestPoints {
  S s, t;          ///< along the first and the second segment
  Vector3<S> gap;  ///< from the point on the second to the point on the first
  S distance;      ///< m
};

/// The smallest D with D² = ‖gap‖² + ε (a (s − ½)² + b (t − ½)²) + δ² over s and t in [0, 1]. Here
/// a and b are the squared lengths and δ = kCrossingSmoothing. ε = kParallelSmoothing between two
/// segments, and 0 if either is a point. D is continuously differentiable. It is never below the
/// distance d of the segments, and above it by at most (ε (a + b)/4 + δ²)/(2 d). Since (s, t) is
/// the minimizer, the derivative of D is that at fixed s and t: gap·(change of gap)/D.
///
/// The method is that of Ericson, Real-Time Collision Detection (2005), 5.1.9, without its
/// branches. It is exact for the strictly convex problem.
template <class S>
ClosestPoints<S> closest_points(const Segment<S>& first, const Segment<S>& second) {
  const auto clamped = [](const S& a) { return min(max(a, S(0.0)), S(1.0)); };
  const double a = first.squared_length, b = second.squared_length;
  const double epsilon = a > 0 && b > 0 ? kParallelSmoothing : 0;
  const double A = (1 + epsilon) * a, B = (1 + epsilon) * b;
  const Vector3<S> r = first.p - second.p;
  ClosestPoints<S> c{S(0.0), S(0.0), r, S(0.0)};
  const S f = dot(first.d, r) - S(0.5 * epsilon * a);
  const S g = dot(second.d, r) + S(0.5 * epsilon * b);
  if (a > 0 && b > 0) {
    const S m = dot(first.d, second.d);
    c.s = clamped((m * g - f * B) / (S(A * B) - m * m));
    c.t = clamped((m * c.s + g) * (1 / B));
    c.s = clamped((m * c.t - f) * (1 / A));
  } else if (a > 0) {
    c.s = clamped(-f * (1 / A));
  } else if (b > 0) {
    c.t = clamped(g * (1 / B));
  }
  c.gap = r + c.s * first.d - c.t * second.d;
  const S from_middle = c.s - S(0.5), from_middle_2 = c.t - S(0.5);
  c.distance =
      sqrt(squared_norm(c.gap) + S(kCrossingSmoothing * kCrossingSmoothing) +
           epsilon * (a * (from_middle * from_middle) + b * (from_middle_2 * from_middle_2)));
  return c;
}

}  // namespace conddp
