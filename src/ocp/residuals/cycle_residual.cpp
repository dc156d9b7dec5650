#include <algorithm>
#include <array>

#include "ocp/residuals/residuals.hpp"

namespace conddp {
namespace {

/// x ⊖ ((x₀ ⊕ S m) + offset), part by part of the state.
class CycleResidual : public ResidualBase<CycleResidual> {
 public:
  CycleResidual(const StateManifold& manifold, const ChosenStart& start, std::vector<double> offset,
                const std::vector<int>& left_out, int last, int ndx)
      : ResidualBase(structure(manifold, start, left_out, last, ndx), 0, false),
        manifold_(manifold),
        start_(start.state),
        offset_(std::move(offset)),
        memory_(memory_of(manifold, start)),
        has_row_(rows_of(manifold, left_out)),
        last_(last),
        end_(manifold.nx() + ndx - manifold.ndx()) {
    for (const auto& segment : manifold.curved()) {
      StateManifold& part = parts_.emplace_back();
      part.append(segment.part);
    }
  }

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    std::size_t curved = 0;
    for (const auto& segment : manifold_.segments()) {
      if (segment.part == StateManifold::Part::flat) {
        for (int i = 0; i < segment.n; ++i) {
          const int x = segment.x + i, m = memory_[segment.dx + i];
          if (!has_row_[segment.dx + i]) continue;
          *r = in.x[x] - S(start_[x] + offset_[x]);
          if (m >= 0) *r -= in.x[manifold_.nx() + m];
          ++r;
        }
        continue;
      }
      S moved[kMost], target[kMost + 1];
      place(segment, parts_[curved], in.x, moved, target);
      parts_[curved++].difference(target, in.x + segment.x, r);
      r += segment.n;
    }
    for (int i = end_ - last_; i < end_; ++i) *r++ = in.x[i] - in.x[i - last_];
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    std::size_t curved = 0;
    for (const auto& segment : manifold_.segments()) {
      if (segment.part == StateManifold::Part::flat) {
        jacobian = write_flat(segment, jacobian);
        r += std::count(has_row_.begin() + segment.dx, has_row_.begin() + segment.dx + segment.n,
                        true);
      } else {
        jacobian = write_curved(segment, parts_[curved++], in, r, jacobian);
        r += segment.n;
      }
    }
    for (int i = 0; i < last_; ++i) {
      *jacobian++ = S(-1.0);
      *jacobian++ = S(1.0);
    }
  }

 private:
  template <class S>
  S* write_flat(const StateManifold::Segment& segment, S* jacobian) const {
    for (int i = 0; i < segment.n; ++i) {
      if (!has_row_[segment.dx + i]) continue;
      *jacobian++ = S(1.0);
      if (memory_[segment.dx + i] >= 0) *jacobian++ = S(-1.0);
    }
    return jacobian;
  }

  /// Writes the derivatives of a curved part from the values r of its rows.
  template <class S>
  S* write_curved(const StateManifold::Segment& segment, const StateManifold& part,
                  const ResidualInput<S>& in, const S* r, S* jacobian) const {
    const int n = segment.n;
    S moved[kMost], target[kMost + 1], minus[kMost];
    place(segment, part, in.x, moved, target);
    S by_x[StateManifold::kBlockSize], by_target[StateManifold::kBlockSize];
    S unused[StateManifold::kBlockSize], by_moved[StateManifold::kBlockSize];
    part.inverse_right_jacobian(r, by_x);
    for (int i = 0; i < n; ++i) minus[i] = -r[i];
    part.inverse_right_jacobian(minus, by_target);
    part.integrate_jacobians(moved, unused, by_moved);
    for (int c = 0; c < n; ++c)
      for (int i = 0; i < n; ++i) *jacobian++ = by_x[i * n + c];
    for (int c = 0; c < n; ++c)
      if (memory_[segment.dx + c] >= 0)
        jacobian = write_memory_column(n, c, by_target, by_moved, jacobian);
    return jacobian;
  }

  /// Column c of −A B.
  template <class S>
  static S* write_memory_column(int n, int c, const S* A, const S* B, S* column) {
    for (int i = 0; i < n; ++i) {
      S sum(0.0);
      for (int k = 0; k < n; ++k) sum -= A[i * n + k] * B[k * n + c];
      *column++ = sum;
    }
    return column;
  }

  static constexpr int kMost = 6;  ///< maximum tangent coordinates of a curved part

  /// The displacement of the initial state, and the target state, of a curved part.
  template <class S>
  void place(const StateManifold::Segment& segment, const StateManifold& part, const S* x, S* moved,
             S* target) const {
    const int nx = part.nx();
    for (int i = 0; i < segment.n; ++i) {
      const int m = memory_[segment.dx + i];
      moved[i] = m < 0 ? S(0.0) : x[manifold_.nx() + m];
    }
    for (int i = 0; i < nx; ++i) target[i] = S(start_[segment.x + i]);
    part.integrate(target, moved, target);
    for (int i = 0; i < nx; ++i) target[i] += S(offset_[segment.x + i]);
  }

  /// For each tangent coordinate, its index among the free initial coordinates, or −1.
  static std::vector<int> memory_of(const StateManifold& manifold, const ChosenStart& start) {
    std::vector<int> memory(manifold.ndx(), -1);
    for (std::size_t i = 0; i < start.coordinates.size(); ++i)
      memory[start.coordinates[i]] = start.before + static_cast<int>(i);
    return memory;
  }
  static std::vector<bool> rows_of(const StateManifold& manifold,
                                   const std::vector<int>& left_out) {
    std::vector<bool> has_row(manifold.ndx(), true);
    for (const int i : left_out) has_row[i] = false;
    return has_row;
  }
  static std::vector<RowBlock> structure(const StateManifold& manifold, const ChosenStart& start,
                                         const std::vector<int>& left_out, int last, int ndx) {
    const std::vector<int> memory = memory_of(manifold, start);
    const std::vector<bool> has_row = rows_of(manifold, left_out);
    std::vector<RowBlock> blocks;
    const auto add = [&](int first, int n) {
      RowBlock block{n, column_range(first, n)};
      std::vector<int> more;
      for (int i = first; i < first + n; ++i)
        if (memory[i] >= 0) more.push_back(manifold.ndx() + memory[i]);
      block.columns.insert(block.columns.end(), more.begin(), more.end());
      blocks.push_back(std::move(block));
    };
    for (const auto& segment : manifold.segments()) {
      if (segment.part != StateManifold::Part::flat) {
        add(segment.dx, segment.n);
        continue;
      }
      for (int i = 0; i < segment.n; ++i)
        if (has_row[segment.dx + i]) add(segment.dx + i, 1);
    }
    for (int i = ndx - last; i < ndx; ++i) blocks.push_back({1, {i - last, i}, true});
    return blocks;
  }

  StateManifold manifold_;
  std::vector<double> start_, offset_;
  std::vector<int> memory_;
  std::vector<bool> has_row_;         ///< by tangent coordinate
  int last_, end_;                    ///< rows for the numbers at the end of the state; state size
  std::vector<StateManifold> parts_;  ///< the curved segments
};

}  // namespace

std::shared_ptr<const Residual> cycle_residual(const StateManifold& manifold,
                                               const ChosenStart& start, std::vector<double> offset,
                                               const std::vector<int>& left_out, int last,
                                               int ndx) {
  return std::make_shared<CycleResidual>(manifold, start, std::move(offset), left_out, last, ndx);
}

}  // namespace conddp
