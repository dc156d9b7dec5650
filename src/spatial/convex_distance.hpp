#pragma once

#include <span>
#include <vector>

#include "spatial/dual.hpp"
#include "spatial/se3.hpp"

namespace conddp {

/// Vertices of two convex polytopes, in pairs whose differences span what is next to the origin in
/// A − B: the distance of the polytopes is that of their difference from the origin, and their
/// depth that of the origin below its surface.
struct NearestPairs {
  static constexpr int kMost = 10;
  int first[kMost] = {}, second[kMost] = {};  ///< vertex numbers
  int count = 1;
  double gap = 0;         ///< between the nearest points, m; 0 if they overlap
  bool overlap = false;   ///< the origin lies inside; there are three pairs, the corners of a face
  bool reversed = false;  ///< (m₁ − m₀) × (m₂ − m₀) points inwards
};

/// Rounding of the distance d of two polytopes: the least ‖a − b‖ + δ (‖a − c_A‖²/r_A² + ‖b −
/// c_B‖²/r_B²) over their points a and b, less 2 δ. The nearest points of parallel faces and edges
/// are unique then, and the derivative is continuous where the polytopes are apart. If balls of
/// radius r about the centers c contain them, the result is at most d, and at least d − 2 δ.
/// Polytopes that overlap have their negative depth less δ.
struct DistanceRounding {
  double length = 0;  ///< δ, m; 0: exact
  Vector3<double> center[2] = {Vector3<double>::zero(), Vector3<double>::zero()};  ///< own axes, m
  double radius[2] = {1, 1};                                                       ///< m
};

/// The pairs of two polytopes, each the convex hull of its points (m, at least one) in its own
/// axes; `second_in_first` places the axes of the second in those of the first.
///
/// Separate polytopes: the method of Gilbert, Johnson and Keerthi (1988), with the nearest point of
/// a simplex by inspection of its faces; with rounding that of Wolfe (1976) for the nearest point
/// of a polytope in nine dimensions. Overlap: the expanding polytope of van den Bergen (2001),
/// without rounding. All end at the exact pairs after finitely many steps, but for depths that need
/// more than 128 corners: these come out too small.
NearestPairs nearest_pairs(std::span<const Vector3<double>> first,
                           std::span<const Vector3<double>> second,
                           const SE3<double>& second_in_first,
                           const DistanceRounding& rounding = {});

/// Some of the points (at least one), whose convex hull reaches all others but for `tolerance` (m).
std::vector<Vector3<double>> hull_points(std::span<const Vector3<double>> points, double tolerance);

/// The pairs as numbers, for lanes that have different ones.
template <class S>
struct PairCorners {
  int count = 1;                           ///< the largest of all lanes
  Vector3<S> own[2][NearestPairs::kMost];  ///< corners in the axes of their body, m
  Vector3<S> m[NearestPairs::kMost];       ///< first minus second, in common axes
  S present[NearestPairs::kMost];          ///< 1 for a pair, 0 for none
  S gap, overlap, reversed;                ///< of NearestPairs, 1 for true
};

/// Distance of two polytopes with given nearest pairs.
template <class S>
struct PolytopeDistance {
  Vector3<S> point[2];  ///< nearest points, each in the axes of its body
  Vector3<S> along;     ///< moving the first polytope by d changes the distance by along·d
  S distance;           ///< m, negative if they overlap
};

namespace detail {
/// Solves K y = weights for a symmetric positive definite K, of which the lower triangle is given,
/// and scales y to the sum 1. The diagonal of K then has its pivots.
template <class S>
void solve_weights(int n, S (&K)[NearestPairs::kMost][NearestPairs::kMost], S* weights) {
  for (int j = 0; j < n; ++j)
    for (int i = j + 1; i < n; ++i) {
      const S factor = K[i][j] / K[j][j];
      for (int k = i; k < n; ++k) K[k][i] -= factor * K[k][j];
      K[i][j] = factor;
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) weights[i] -= K[i][j] * weights[j];
  for (int i = 0; i < n; ++i) weights[i] = weights[i] / K[i][i];
  S sum(0.0);
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) weights[i] -= K[k][i] * weights[k];
    sum += weights[i];
  }
  for (int i = 0; i < n; ++i) weights[i] = weights[i] / sum;
}

/// Aitken's limit of three numbers of a sequence; the last one if they do not differ.
template <class S>
S accelerated(const S& a, const S& b, const S& c) {
  const S bend = (c - b) - (b - a);
  const auto differ = abs(bend) > abs(c) * S(1e-12);
  const S step = b - a;
  return select(differ, max(S(0.0), a - step * step / select(differ, bend, S(1.0))), c);
}

/// Weights of the corners' combination that is nearest to the origin, 0 without a pair: the
/// solution of (11ᵀ σ + G + w L) y = 1, scaled, with the matrices G and L of scalar products of
/// differences and of vertices from their centers. The w = 2 δ ‖a − b‖ that makes the sum of
/// squares stationary where the sum of lengths is follows by iteration.
template <class S>
void nearest_weights(const PairCorners<S>& at, const DistanceRounding& rounding, S* weights) {
  constexpr int kMost = NearestPairs::kMost;
  const int n = at.count;
  S G[kMost][kMost], L[kMost][kMost], K[kMost][kMost];
  S size(1e-12);
  for (int i = 0; i < n; ++i) size += at.present[i] * squared_norm(at.m[i]);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      const S both = at.present[i] * at.present[j];
      G[i][j] = both * (size + dot(at.m[i], at.m[j]));
      if (i == j) G[i][j] += S(1.0) - both;
      L[i][j] = S(0.0);
      for (int body = 0; body < 2; ++body) {
        const Vector3<S> c = rounding.center[body].template cast<S>();
        L[i][j] += S(2 * rounding.length / (rounding.radius[body] * rounding.radius[body])) *
                   (both * dot(at.own[body][i] - c, at.own[body][j] - c));
      }
    }
  const auto gap_with = [&](const S& gap) {
    for (int i = 0; i < n; ++i) {
      weights[i] = at.present[i];
      for (int j = 0; j <= i; ++j) K[i][j] = G[i][j] + gap * L[i][j];
    }
    solve_weights(n, K, weights);
    Vector3<S> m = Vector3<S>::zero();
    for (int i = 0; i < n; ++i) m += weights[i] * at.m[i];
    return (S(1.0) - at.overlap) * sqrt(squared_norm(m) + at.overlap + S(1e-24));
  };
  S gap = at.gap;
  if (rounding.length > 0) {
    const S next = gap_with(gap);
    gap = accelerated(gap, next, gap_with(next));
  }
  gap_with(gap);
}
}  // namespace detail

template <class S>
PolytopeDistance<S> polytope_distance(const PairCorners<S>& at, const DistanceRounding& rounding) {
  S weights[NearestPairs::kMost];
  detail::nearest_weights(at, rounding, weights);
  PolytopeDistance<S> result;
  Vector3<S> gap = Vector3<S>::zero();
  for (int i = 0; i < at.count; ++i) gap += weights[i] * at.m[i];
  S rounded(-2 * rounding.length);
  for (int body = 0; body < 2; ++body) {
    Vector3<S>& point = result.point[body];
    point = Vector3<S>::zero();
    for (int i = 0; i < at.count; ++i) point += weights[i] * at.own[body][i];
    const Vector3<S> from_center = point - rounding.center[body].template cast<S>();
    rounded += S(rounding.length / (rounding.radius[body] * rounding.radius[body])) *
               squared_norm(from_center);
  }
  const Vector3<S> normal = cross(at.m[1] - at.m[0], at.m[2] - at.m[0]);
  const S apart = S(1.0) - at.overlap;
  const S gap_length = sqrt(squared_norm(gap) + at.overlap + S(1e-24));
  const S normal_length = sqrt(squared_norm(normal) + apart);
  // Outside, the distance grows along the gap; inside, it grows against the outward normal.
  const S inward = at.overlap * (at.reversed + at.reversed - S(1.0)) / normal_length;
  result.along = (apart / gap_length) * gap + inward * normal;
  result.distance = apart * (gap_length + rounded) + dot(inward * normal, at.m[0]) -
                    at.overlap * S(rounding.length);
  return result;
}

}  // namespace conddp
