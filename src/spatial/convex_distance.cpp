#include "spatial/convex_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

using Vector = Vector3<double>;
using Points = std::span<const Vector>;

/// A point of A − B, with the vertices that it is the difference of.
struct Corner {
  Vector m;
  int first, second;
};

bool contain(std::span<const Corner> corners, const Corner& c) {
  return std::ranges::any_of(
      corners, [&](const Corner& own) { return own.first == c.first && own.second == c.second; });
}

int furthest(Points points, const Vector& direction) {
  int best = 0;
  double most = dot(points[0], direction);
  for (std::size_t i = 1; i < points.size(); ++i)
    if (const double along = dot(points[i], direction); along > most)
      best = static_cast<int>(i), most = along;
  return best;
}

/// The difference of two polytopes in the axes of the first.
class Difference {
 public:
  Difference(Points first, Points second, const SE3<double>& placement)
      : first_(first), second_(second), placement_(placement) {}

  Corner corner(int first, int second) const {
    return {first_[first] - (placement_.R * second_[second] + placement_.p), first, second};
  }
  /// The corner that is furthest along a direction.
  Corner support(const Vector& direction) const {
    return support(direction, in_second(-direction));
  }
  /// The one of the vertices that are furthest along a direction each, in their own axes.
  Corner support(const Vector& of_first, const Vector& of_second) const {
    return corner(furthest(first_, of_first), furthest(second_, of_second));
  }
  /// A direction in the axes of the second polytope.
  Vector in_second(const Vector& direction) const {
    return transpose_times(placement_.R, direction);
  }
  const Vector& vertex(int body, const Corner& c) const {
    return body == 0 ? first_[c.first] : second_[c.second];
  }

 private:
  Points first_, second_;
  const SE3<double>& placement_;
};

/// Up to four corners.
struct Simplex {
  std::array<Corner, 4> corners;
  int count = 0;
  Vector nearest = Vector::zero();  ///< its point next to the origin

  void add(const Corner& corner) { corners[count++] = corner; }
  std::span<const Corner> span() const { return {corners.data(), static_cast<std::size_t>(count)}; }
};

/// The point of the affine hull of some corners next to the origin; false if a weight is negative
/// or they are dependent.
bool project(const Simplex& s, std::span<const int> chosen, Vector& point) {
  const Vector& m = s.corners[chosen[0]].m;
  point = m;
  if (chosen.size() == 1) return true;
  const Vector d = s.corners[chosen[1]].m - m;
  const double dd = squared_norm(d), f = -dot(d, m);
  if (chosen.size() == 2) {
    if (f < 0 || f > dd || dd == 0) return false;
    point = m + (f / dd) * d;
    return true;
  }
  const Vector e = s.corners[chosen[2]].m - m;
  const Vector normal = cross(d, e);
  const double area = squared_norm(normal);
  if (area <= 1e-28 * dd * squared_norm(e)) return false;
  // The weights are areas of triangles with the origin's projection.
  const double weight_1 = -dot(cross(m, e), normal), weight_2 = -dot(cross(d, m), normal);
  if (weight_1 < 0 || weight_2 < 0 || weight_1 + weight_2 > area) return false;
  point = (dot(normal, m) / area) * normal;
  return true;
}

bool surrounds_origin(const Simplex& s) {
  const auto& c = s.corners;
  const auto volume = [](const Vector& a, const Vector& b, const Vector& d) {
    return dot(a, cross(b, d));
  };
  const double whole = volume(c[1].m - c[0].m, c[2].m - c[0].m, c[3].m - c[0].m);
  const double parts[] = {volume(c[1].m, c[2].m, c[3].m), -volume(c[0].m, c[2].m, c[3].m),
                          volume(c[0].m, c[1].m, c[3].m), -volume(c[0].m, c[1].m, c[2].m)};
  return whole != 0 && std::all_of(std::begin(parts), std::end(parts),
                                   [&](double part) { return part * whole >= 0; });
}

/// Reduces a simplex to the face with its point next to the origin; its last corner is new. False
/// if it surrounds the origin.
bool reduce(Simplex& s) {
  if (s.count == 4 && surrounds_origin(s)) return false;
  const int last = s.count - 1;
  double least = std::numeric_limits<double>::infinity();
  std::array<int, 3> best{};
  int best_count = 0;
  for (int others = 0; others < 1 << last; ++others) {
    std::array<int, 4> chosen{last};
    int count = 1;
    for (int i = 0; i < last; ++i)
      if (others >> i & 1) chosen[count++] = i;
    Vector point;
    if (count == 4 || !project(s, {chosen.data(), static_cast<std::size_t>(count)}, point))
      continue;
    if (const double square = squared_norm(point); square < least) {
      least = square;
      s.nearest = point;
      std::copy_n(chosen.begin(), count, best.begin());
      best_count = count;
    }
  }
  std::array<Corner, 3> kept;
  for (int i = 0; i < best_count; ++i) kept[i] = s.corners[best[i]];
  std::copy_n(kept.begin(), best_count, s.corners.begin());
  s.count = best_count;
  return true;
}

NearestPairs pairs_of(std::span<const Corner> corners) {
  NearestPairs pairs{.count = static_cast<int>(corners.size())};
  for (int i = 0; i < pairs.count; ++i) {
    pairs.first[i] = corners[i].first;
    pairs.second[i] = corners[i].second;
  }
  return pairs;
}

/// A face of the expanding polytope with its outward unit normal.
struct Face {
  std::array<int, 3> corners;
  Vector normal;
  double height;  ///< of its plane above the origin
};

/// The polytope of van den Bergen, which grows inside A − B until its nearest face is one of it, or
/// until it has kMostCorners.
class ExpandingPolytope {
 public:
  ExpandingPolytope(const Difference& difference, const Simplex& start) : difference_(difference) {
    for (int i = 0; i < start.count; ++i) corners_[corner_count_++] = start.corners[i];
    complete();
  }

  NearestPairs nearest() {
    if (corner_count_ < 4) return flat_face();
    while (true) {
      const Face face =
          *std::min_element(faces_.begin(), faces_.begin() + face_count_,
                            [](const Face& a, const Face& b) { return a.height < b.height; });
      const Corner corner = difference_.support(face.normal);
      const double gain = dot(face.normal, corner.m) - face.height;
      if (gain <= kFlat * size_ || !expand(corner)) return answer(face);
    }
  }

 private:
  static constexpr int kMostCorners = 128, kMostFaces = 2 * kMostCorners;
  /// Share of the size below which corners count as lying in one plane.
  static constexpr double kFlat = 1e-12;

  /// Adds corners until four of them span a tetrahedron.
  void complete() {
    constexpr Vector kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Vector& axis : kAxes)
      size_ = std::max({size_, std::abs(dot(axis, difference_.support(axis).m)),
                        std::abs(dot(axis, difference_.support(-axis).m))});
    const auto& c = corners_;
    for (int i = 0; i < 3 && corner_count_ == 1; ++i) extend(kAxes[i]);
    for (int i = 0; i < 3 && corner_count_ == 2; ++i) extend(cross(c[1].m - c[0].m, kAxes[i]));
    if (corner_count_ == 3) extend(cross(c[1].m - c[0].m, c[2].m - c[0].m));
    if (corner_count_ < 4) return;
    inside_ = 0.25 * (c[0].m + c[1].m + c[2].m + c[3].m);
    constexpr std::array<int, 3> kSides[] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
    for (const auto& side : kSides) add_face(side);
  }

  /// Adds the furthest corner to either side of those that there are.
  void extend(const Vector& direction) {
    const double length = std::sqrt(squared_norm(direction));
    if (length <= kFlat * size_ * size_) return;
    for (const double sign : {1.0, -1.0}) {
      const Vector unit = (sign / length) * direction;
      const Corner corner = difference_.support(unit);
      if (dot(unit, corner.m - corners_[0].m) <= kFlat * size_) continue;
      corners_[corner_count_++] = corner;
      return;
    }
  }

  bool add_face(const std::array<int, 3>& corners) {
    const Vector& m = corners_[corners[0]].m;
    Vector normal = cross(corners_[corners[1]].m - m, corners_[corners[2]].m - m);
    const double length = std::sqrt(squared_norm(normal));
    if (length == 0 || face_count_ == kMostFaces) return false;
    normal = ((dot(normal, m - inside_) < 0 ? -1 : 1) / length) * normal;
    faces_[face_count_++] = {corners, normal, dot(normal, m)};
    return true;
  }

  /// Replaces the faces that a corner sees; false if there is no room.
  bool expand(const Corner& corner) {
    if (corner_count_ == kMostCorners) return false;
    std::array<std::array<int, 2>, 3 * kMostFaces> horizon;
    int edges = 0, kept = 0;
    for (int i = 0; i < face_count_; ++i) {
      const Face face = faces_[i];
      if (dot(face.normal, corner.m) - face.height <= kFlat * size_) {
        faces_[kept++] = face;
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        std::array<int, 2> edge{face.corners[k], face.corners[(k + 1) % 3]};
        std::sort(edge.begin(), edge.end());
        // An edge of two such faces lies inside.
        const auto twin = std::find(horizon.begin(), horizon.begin() + edges, edge);
        if (twin == horizon.begin() + edges)
          horizon[edges++] = edge;
        else
          *twin = horizon[--edges];
      }
    }
    face_count_ = kept;
    corners_[corner_count_] = corner;
    for (int i = 0; i < edges; ++i)
      if (!add_face({horizon[i][0], horizon[i][1], corner_count_})) return false;
    ++corner_count_;
    return true;
  }

  NearestPairs answer(const Face& face) const {
    const Corner &a = corners_[face.corners[0]], &b = corners_[face.corners[1]],
                 &c = corners_[face.corners[2]];
    return {.first = {a.first, b.first, c.first},
            .second = {a.second, b.second, c.second},
            .count = 3,
            .overlap = true,
            .reversed = dot(cross(b.m - a.m, c.m - a.m), face.normal) < 0};
  }

  /// A face of three corners, if any, of a flat difference: such polytopes touch at most.
  NearestPairs flat_face() const {
    NearestPairs face = pairs_of({corners_.data(), std::min<std::size_t>(corner_count_, 3)});
    face.overlap = face.count == 3;
    return face;
  }

  const Difference& difference_;
  std::array<Corner, kMostCorners> corners_;
  std::array<Face, kMostFaces> faces_;
  int corner_count_ = 0, face_count_ = 0;
  double size_ = 0;
  Vector inside_ = Vector::zero();
};

/// Reduces a simplex to the face next to the origin. False if the bodies overlap; the simplex then
/// surrounds or touches the origin.
bool descend(const Difference& difference, Simplex& simplex) {
  /// Relative gain of the squared distance below which rounding decides.
  constexpr double kRounding = 1e-14;
  /// Share of the first distance that counts as touching.
  constexpr double kTouching = 1e-10;
  constexpr int kMostSteps = 128;
  simplex.add(difference.corner(0, 0));
  reduce(simplex);
  const double touching = kTouching * kTouching * squared_norm(simplex.nearest);
  for (int step = 0; step < kMostSteps; ++step) {
    const double square = squared_norm(simplex.nearest);
    if (square <= touching) return false;
    const Corner corner = difference.support(-simplex.nearest);
    if (square - dot(simplex.nearest, corner.m) <= kRounding * square ||
        contain(simplex.span(), corner))
      break;
    Simplex next = simplex;
    next.add(corner);
    const bool outside = reduce(next);
    if (outside && squared_norm(next.nearest) >= square) break;
    simplex = next;
    if (!outside) return false;
  }
  return true;
}

/// Wolfe's method for the point next to the origin in the convex hull of (m, √w (a − c_A)/r_A,
/// √w (b − c_B)/r_B) over the pairs of vertices a, b, with w = 2 δ ‖m‖ by iteration. A linear
/// function of these points is one of a plus one of b, so that its least value needs no pairs.
class RoundedNearest {
 public:
  /// Begins with the pairs of the exact nearest points.
  RoundedNearest(const Difference& difference, const DistanceRounding& rounding,
                 const Simplex& start)
      : difference_(difference), rounding_(rounding), gap_(std::sqrt(squared_norm(start.nearest))) {
    for (const Corner& corner : start.span()) add(corner, 0);
    weights_[0] = 1;
  }

  NearestPairs solve() {
    constexpr int kIterations = 3;
    constexpr double kSettled = 1e-6;
    for (int i = 0; i < kIterations; ++i) {
      const double next = gap_with(gap_);
      const bool settled = std::abs(next - gap_) <= kSettled * next;
      gap_ = settled ? next : detail::accelerated(gap_, next, gap_with(next));
      if (settled) break;
    }
    NearestPairs pairs = pairs_of(corners());
    pairs.gap = gap_;
    return pairs;
  }

 private:
  /// Relative gain of the squared distance below which rounding decides.
  static constexpr double kRounding = 1e-13;
  /// Share of the largest scalar product below which a pivot means dependent corners.
  static constexpr double kDependent = 1e-14;

  double gap_with(double gap) {
    constexpr int kMostSteps = 64;
    for (int body = 0; body < 2; ++body)
      factor_[body] =
          2 * rounding_.length * gap / (rounding_.radius[body] * rounding_.radius[body]);
    settle();
    for (int step = 0; step < kMostSteps; ++step) {
      locate();
      const Corner next = support();
      const double gain = square_ - product(next);
      if (gain <= kRounding * square_ || contain(corners(), next) || count_ == NearestPairs::kMost)
        break;
      add(next, 0);
      settle();
    }
    return std::sqrt(squared_norm(m_));
  }

  std::span<const Corner> corners() const {
    return {corners_.data(), static_cast<std::size_t>(count_)};
  }
  void add(const Corner& corner, double weight) {
    corners_[count_] = corner;
    weights_[count_++] = weight;
  }
  void remove(int i) {
    corners_[i] = corners_[--count_];
    weights_[i] = weights_[count_];
  }

  Vector from_center(int body, const Corner& c) const {
    return difference_.vertex(body, c) - rounding_.center[body];
  }
  double scalar_product(const Corner& a, const Corner& b) const {
    return dot(a.m, b.m) + factor_[0] * dot(from_center(0, a), from_center(0, b)) +
           factor_[1] * dot(from_center(1, a), from_center(1, b));
  }

  /// The combination of the corners.
  void locate() {
    m_ = away_[0] = away_[1] = Vector::zero();
    for (int i = 0; i < count_; ++i) {
      m_ += weights_[i] * corners_[i].m;
      for (int body = 0; body < 2; ++body)
        away_[body] += weights_[i] * from_center(body, corners_[i]);
    }
    for (int body = 0; body < 2; ++body) away_[body] = factor_[body] * away_[body];
    square_ = 0;
    for (int i = 0; i < count_; ++i) square_ += weights_[i] * product(corners_[i]);
  }
  double product(const Corner& c) const {
    return dot(m_, c.m) + dot(away_[0], from_center(0, c)) + dot(away_[1], from_center(1, c));
  }
  Corner support() const {
    return difference_.support(-(m_ + away_[0]), difference_.in_second(m_) - away_[1]);
  }

  /// Moves to the point of the affine hull next to the origin, dropping corners on the way whose
  /// weight would become negative.
  void settle() {
    while (count_ > 1) {
      std::array<double, NearestPairs::kMost> to{};
      if (!minimize(to)) {  // dependent: another combination has the same point
        remove(static_cast<int>(std::min_element(weights_.begin(), weights_.begin() + count_) -
                                weights_.begin()));
        continue;
      }
      double share = 1;
      int leaving = -1;
      for (int i = 0; i < count_; ++i) {
        if (to[i] > 0) continue;
        const double until = weights_[i] / (weights_[i] - to[i]);
        if (leaving < 0 || until < share) share = std::min(share, until), leaving = i;
      }
      if (leaving < 0) {
        weights_ = to;
        return;
      }
      for (int i = 0; i < count_; ++i) weights_[i] += share * (to[i] - weights_[i]);
      remove(leaving);
    }
    weights_[0] = 1;
  }

  /// Weights of the point of the affine hull next to the origin. False for dependent corners.
  bool minimize(std::array<double, NearestPairs::kMost>& weights) const {
    double K[NearestPairs::kMost][NearestPairs::kMost], size = 0;
    for (int i = 0; i < count_; ++i)
      for (int j = 0; j <= i; ++j) K[i][j] = scalar_product(corners_[i], corners_[j]);
    for (int i = 0; i < count_; ++i) size = std::max(size, K[i][i]);
    for (int i = 0; i < count_; ++i)
      for (int j = 0; j <= i; ++j) K[i][j] += size;
    std::fill_n(weights.begin(), count_, 1.0);
    detail::solve_weights(count_, K, weights.data());
    for (int i = 0; i < count_; ++i)
      if (!(K[i][i] > kDependent * size)) return false;
    return true;
  }

  const Difference& difference_;
  const DistanceRounding& rounding_;
  double gap_;
  std::array<Corner, NearestPairs::kMost> corners_;
  std::array<double, NearestPairs::kMost> weights_{};
  int count_ = 0;
  double factor_[2] = {0, 0};  ///< w/r², m²
  Vector m_ = Vector::zero();
  Vector away_[2] = {Vector::zero(), Vector::zero()};  ///< of the centers, times the factor
  double square_ = 0;
};

}  // namespace

NearestPairs nearest_pairs(Points first, Points second, const SE3<double>& second_in_first,
                           const DistanceRounding& rounding) {
  const Difference difference(first, second, second_in_first);
  Simplex simplex;
  if (!descend(difference, simplex)) return ExpandingPolytope(difference, simplex).nearest();
  if (rounding.length > 0) return RoundedNearest(difference, rounding, simplex).solve();
  NearestPairs pairs = pairs_of(simplex.span());
  pairs.gap = std::sqrt(squared_norm(simplex.nearest));
  return pairs;
}

std::vector<Vector> hull_points(Points points, double tolerance) {
  const SE3<double> same = SE3<double>::identity();
  std::vector<Vector> hull = {points[furthest(points, {1, 0, 0})]};
  for (const Vector& point : points)
    while (hull.size() < points.size()) {
      const Vector own[] = {point};
      const Difference difference(own, hull, same);
      Simplex simplex;
      if (!descend(difference, simplex)) break;
      if (squared_norm(simplex.nearest) <= tolerance * tolerance) break;
      // The furthest point in that direction belongs to the hull of all.
      hull.push_back(points[furthest(points, simplex.nearest)]);
    }
  return hull;
}

}  // namespace conddp
