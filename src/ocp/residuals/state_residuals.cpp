#include <algorithm>
#include <stdexcept>

#include "ocp/residuals/residuals.hpp"

namespace conddp {
namespace {

class StateResidual : public ResidualBase<StateResidual> {
 public:
  explicit StateResidual(const StateManifold& manifold)
      : ResidualBase(structure(manifold), manifold.nx(), false), manifold_(manifold) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    manifold_.difference(in.parameters, in.x, r);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (const auto& segment : manifold_.segments()) {
      if (segment.part == StateManifold::Part::flat) {
        for (int i = 0; i < segment.n; ++i) *jacobian++ = S(1.0);
        continue;
      }
      const S* d = r + segment.dx;
      const Vector3<S> first{d[0], d[1], d[2]};
      jacobian =
          segment.n == 3
              ? write_block<3>(inverse_right_jacobian_so3(first), jacobian)
              : write_block<6>(inverse_right_jacobian_se3(Motion<S>{first, {d[3], d[4], d[5]}}),
                               jacobian);
    }
  }

 private:
  /// n x n, by columns.
  template <int n, class Matrix, class S>
  static S* write_block(const Matrix& block, S* jacobian) {
    for (int c = 0; c < n; ++c)
      for (int i = 0; i < n; ++i) *jacobian++ = block(i, c);
    return jacobian;
  }

  static std::vector<RowBlock> structure(const StateManifold& manifold) {
    std::vector<RowBlock> blocks;
    for (const auto& segment : manifold.segments()) {
      if (segment.part == StateManifold::Part::flat)
        for (int i = 0; i < segment.n; ++i) blocks.push_back({1, {segment.dx + i}, true});
      else
        blocks.push_back({segment.n, column_range(segment.dx, segment.n)});
    }
    return blocks;
  }
  StateManifold manifold_;
};

class CoordinateResidual : public ResidualBase<CoordinateResidual> {
 public:
  CoordinateResidual(const StateManifold& manifold, std::vector<int> indices)
      : ResidualBase(structure(manifold, indices), static_cast<int>(indices.size()), false),
        indices_(std::move(indices)) {
    for (const int index : indices_) {
      const StateManifold::Segment& home = home_of(manifold, index);
      poses_.push_back(home.part == StateManifold::Part::flat ? -1 : home.x);
    }
  }

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (std::size_t i = 0; i < indices_.size(); ++i) r[i] = in.x[indices_[i]] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      if (poses_[i] < 0) {
        *jacobian++ = S(1.0);
        continue;
      }
      // The tangent is in the body's axes: p ⊕ δ = p + R δ to first order.
      const S* q = in.x + poses_[i] + 3;
      const Matrix3<S> R = rotation_matrix(Quaternion<S>{q[0], q[1], q[2], q[3]});
      for (int c = 0; c < 3; ++c) *jacobian++ = R(indices_[i] - poses_[i], c);
    }
  }

 private:
  /// The part of the state in which a coordinate lies.
  static const StateManifold::Segment& home_of(const StateManifold& manifold, int index) {
    for (const auto& segment : manifold.segments()) {
      const bool flat = segment.part == StateManifold::Part::flat;
      if (!flat && segment.part != StateManifold::Part::se3) continue;
      if (index >= segment.x && index < segment.x + (flat ? segment.n : 3)) return segment;
    }
    throw std::invalid_argument("not a coordinate of the state");
  }
  static std::vector<RowBlock> structure(const StateManifold& manifold,
                                         const std::vector<int>& indices) {
    std::vector<RowBlock> blocks;
    for (const int index : indices) {
      const StateManifold::Segment& home = home_of(manifold, index);
      if (home.part == StateManifold::Part::flat)
        blocks.push_back({1, {home.dx + index - home.x}, true});
      else
        blocks.push_back({1, column_range(home.dx, 3)});
    }
    return blocks;
  }
  std::vector<int> indices_;
  std::vector<int> poses_;  ///< where the pose starts whose position it is, −1 of flat coordinates
};

std::vector<RowBlock> diagonal_blocks(int first_column, int count) {
  std::vector<RowBlock> blocks;
  for (int i = 0; i < count; ++i) blocks.push_back({1, {first_column + i}, true});
  return blocks;
}

class ControlResidual : public ResidualBase<ControlResidual> {
 public:
  ControlResidual(int ndx, int nu) : ResidualBase(diagonal_blocks(ndx, nu), nu, true) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < size(); ++i) r[i] = in.u[i] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    std::fill_n(jacobian, size(), S(1.0));
  }
};

class ControlRateResidual : public ResidualBase<ControlRateResidual> {
 public:
  ControlRateResidual(const StateManifold& system_manifold, int nu)
      : ResidualBase(structure(system_manifold.ndx(), nu), 0, true),
        previous_(system_manifold.nx()) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < size(); ++i) r[i] = in.u[i] - in.x[previous_ + i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (int i = 0; i < size(); ++i) {
      *jacobian++ = S(-1.0);
      *jacobian++ = S(1.0);
    }
  }

 private:
  static std::vector<RowBlock> structure(int ndx, int nu) {
    std::vector<RowBlock> blocks;
    for (int i = 0; i < nu; ++i) blocks.push_back({1, {ndx + i, ndx + nu + i}, true});
    return blocks;
  }
  int previous_;  ///< where the previous control starts in the state
};

class AccelerationResidual : public ResidualBase<AccelerationResidual> {
 public:
  AccelerationResidual(const System& system, int ndx, std::vector<int> rows)
      : ResidualBase(structure(system, ndx, rows), static_cast<int>(rows.size()), true),
        rows_(std::move(rows)),
        nv_(system.nv()),
        state_columns_(system.ndx()),
        control_columns_(system.nu()) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < size(); ++i) r[i] = in.system.f[rows_[i]] - in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (int c = 0; c < state_columns_; ++c)
      for (int row : rows_) *jacobian++ = in.system.fx[c * nv_ + row];
    for (int c = 0; c < control_columns_; ++c)
      for (int row : rows_) *jacobian++ = in.system.fu[c * nv_ + row];
  }

 private:
  static std::vector<RowBlock> structure(const System& system, int ndx,
                                         const std::vector<int>& rows) {
    if (system.kind() != SystemKind::second_order)
      throw std::invalid_argument("accelerations need a second-order system");
    std::vector<int> columns = column_range(0, system.ndx());
    for (int c : column_range(ndx, system.nu())) columns.push_back(c);
    return {{static_cast<int>(rows.size()), columns}};
  }
  std::vector<int> rows_;
  int nv_, state_columns_, control_columns_;
};

}  // namespace

std::shared_ptr<const Residual> state_residual(const StateManifold& manifold) {
  return std::make_shared<StateResidual>(manifold);
}
std::shared_ptr<const Residual> coordinate_residual(const StateManifold& manifold,
                                                    std::vector<int> state_indices) {
  return std::make_shared<CoordinateResidual>(manifold, std::move(state_indices));
}
std::shared_ptr<const Residual> control_residual(int ndx, int nu) {
  return std::make_shared<ControlResidual>(ndx, nu);
}
std::shared_ptr<const Residual> control_rate_residual(const System& system) {
  return std::make_shared<ControlRateResidual>(system.manifold(), system.nu());
}
std::shared_ptr<const Residual> acceleration_residual(const System& system, int ndx,
                                                      std::vector<int> velocity_indices) {
  return std::make_shared<AccelerationResidual>(system, ndx, std::move(velocity_indices));
}

}  // namespace conddp
