#include "systems/graphs/tangent_motions.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// Fills the motions of the numbers in one segment.
class SegmentMotions {
 public:
  SegmentMotions(ExpressionGraph& graph, std::span<const int> input_of, InputMotions& motions)
      : graph_(graph), input_of_(input_of), motions_(motions) {}

  void flat(int x, int dx, int n) {
    for (int i = 0; i < n; ++i) add(x + i, dx + i, graph_.constant(1));
  }

  /// q moves by q ⊗ (δ/2, 0); its numbers x y z w start at x.
  void rotation(int x, int dx) {
    constexpr int kFactor[4][3] = {{3, 2, 1}, {2, 3, 0}, {1, 0, 3}, {0, 1, 2}};
    constexpr double kHalf[4][3] = {
        {0.5, -0.5, 0.5}, {0.5, 0.5, -0.5}, {-0.5, 0.5, 0.5}, {-0.5, -0.5, -0.5}};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 3; ++j)
        add(x + i, dx + j,
            graph_.multiply(graph_.constant(kHalf[i][j]), number(x + kFactor[i][j])));
  }

  /// The position moves by R(q) δ; the quaternion starts at q.
  void translation(int x, int q, int dx) {
    const NodeId numbers[4] = {number(q), number(q + 1), number(q + 2), number(q + 3)};
    const auto twice = [&](int i, int j) {
      return graph_.multiply(graph_.constant(2), graph_.multiply(numbers[i], numbers[j]));
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int k = 3 - i - j;
        if (i == j) {
          const int a = (i + 1) % 3, b = (i + 2) % 3;
          add(x + i, dx + i,
              graph_.subtract(graph_.subtract(graph_.constant(1), twice(a, a)), twice(b, b)));
        } else {
          const bool positive = (i + 1) % 3 != j;
          add(x + i, dx + j,
              positive ? graph_.add(twice(i, j), twice(k, 3))
                       : graph_.subtract(twice(i, j), twice(k, 3)));
        }
      }
  }

 private:
  NodeId number(int x) { return graph_.input(input_of_[x]); }
  void add(int x, int column, NodeId by) { motions_[input_of_[x]].push_back({column, by}); }

  ExpressionGraph& graph_;
  std::span<const int> input_of_;
  InputMotions& motions_;
};

}  // namespace

InputMotions tangent_motions(ExpressionGraph& graph, const StateManifold& manifold,
                             std::span<const int> input_of) {
  InputMotions motions(input_of.empty() ? 0
                                        : *std::max_element(input_of.begin(), input_of.end()) + 1);
  SegmentMotions segments(graph, input_of, motions);
  for (const StateManifold::Segment& segment : manifold.segments()) {
    constexpr int kPosition = 3;
    switch (segment.part) {
      case StateManifold::Part::flat:
        segments.flat(segment.x, segment.dx, segment.n);
        break;
      case StateManifold::Part::so3:
        segments.rotation(segment.x, segment.dx);
        break;
      case StateManifold::Part::se3:
        segments.translation(segment.x, segment.x + kPosition, segment.dx);
        segments.rotation(segment.x + kPosition, segment.dx + kPosition);
        break;
    }
  }
  return motions;
}

InputMotions input_motions(ExpressionGraph& graph, const StateManifold& manifold,
                           std::span<const int> sources) {
  const int nx = manifold.nx();
  std::vector<int> input_of(nx, 0);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i] < nx) input_of[sources[i]] = static_cast<int>(i);
  InputMotions motions = tangent_motions(graph, manifold, input_of);
  motions.resize(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i] >= nx)
      motions[i].push_back({manifold.ndx() + sources[i] - nx, graph.constant(1)});
  return motions;
}

}  // namespace conddp
