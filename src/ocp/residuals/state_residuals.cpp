#include <algorithm>
#include <stdexcept>

#include "ocp/residuals/residuals.hpp"

namespace conddp {
namespace {

class CombinationResidual : public ResidualBase<CombinationResidual> {
 public:
  CombinationResidual(int ndx, std::vector<LinearCombination> rows, bool needs_control)
      : ResidualBase(structure(ndx, rows), 0, needs_control), rows_(std::move(rows)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      r[i] = S(rows_[i].constant);
      for (const auto& term : rows_[i].terms)
        r[i] += S(term.factor) * (term.of_control ? in.u[term.index] : in.x[term.index]);
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (const LinearCombination& row : rows_)
      for (const auto& term : row.terms) *jacobian++ = S(term.factor);
  }

 private:
  /// One block per row; the columns of its terms ascend.
  static std::vector<RowBlock> structure(int ndx, std::vector<LinearCombination>& rows) {
    std::vector<RowBlock> blocks;
    for (LinearCombination& row : rows) {
      const auto column = [ndx](const LinearCombination::Term& term) {
        return term.of_control ? ndx + term.index : term.tangent;
      };
      std::sort(row.terms.begin(), row.terms.end(),
                [&](const auto& a, const auto& b) { return column(a) < column(b); });
      RowBlock& block = blocks.emplace_back(RowBlock{1, {}, true});
      for (const auto& term : row.terms) block.columns.push_back(column(term));
    }
    return blocks;
  }
  std::vector<LinearCombination> rows_;
};

/// Consecutive coordinates of a state.
struct StateRun {
  StateManifold manifold;
  int x, dx;  ///< first index, in the state and in tangent vectors
};

/// Runs of the state without the coordinates left out.
std::vector<StateRun> runs_of(const StateManifold& manifold, const std::vector<int>& left_out) {
  std::vector<StateRun> runs;
  bool open = false;
  const auto append = [&](StateManifold::Part part, int x, int dx) {
    if (std::binary_search(left_out.begin(), left_out.end(), x)) {
      open = false;
      return;
    }
    if (!open) runs.push_back({{}, x, dx});
    open = true;
    runs.back().manifold.append(part, 1);
  };
  for (const auto& segment : manifold.segments()) {
    if (segment.part != StateManifold::Part::flat) {
      append(segment.part, segment.x, segment.dx);
      continue;
    }
    for (int i = 0; i < segment.n; ++i) append(segment.part, segment.x + i, segment.dx + i);
  }
  return runs;
}

class StateResidual : public ResidualBase<StateResidual> {
 public:
  explicit StateResidual(const std::vector<StateRun>& runs)
      : ResidualBase(structure(runs), count_numbers(runs), false), runs_(runs) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const S* reference = in.parameters;
    for (const StateRun& run : runs_) {
      run.manifold.difference(reference, in.x + run.x, r);
      reference += run.manifold.nx();
      r += run.manifold.ndx();
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (const StateRun& run : runs_) {
      jacobian = differentiate_run(run.manifold, r, jacobian);
      r += run.manifold.ndx();
    }
  }

 private:
  template <class S>
  static S* differentiate_run(const StateManifold& manifold, const S* r, S* jacobian) {
    for (const auto& segment : manifold.segments()) {
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
    return jacobian;
  }
  /// Writes an n x n block by columns.
  template <int n, class Matrix, class S>
  static S* write_block(const Matrix& block, S* jacobian) {
    for (int c = 0; c < n; ++c)
      for (int i = 0; i < n; ++i) *jacobian++ = block(i, c);
    return jacobian;
  }

  static std::vector<RowBlock> structure(const std::vector<StateRun>& runs) {
    std::vector<RowBlock> blocks;
    for (const StateRun& run : runs)
      for (const auto& segment : run.manifold.segments()) {
        const int first = run.dx + segment.dx;
        if (segment.part == StateManifold::Part::flat)
          for (int i = 0; i < segment.n; ++i) blocks.push_back({1, {first + i}, true});
        else
          blocks.push_back({segment.n, column_range(first, segment.n)});
      }
    return blocks;
  }
  static int count_numbers(const std::vector<StateRun>& runs) {
    int numbers = 0;
    for (const StateRun& run : runs) numbers += run.manifold.nx();
    return numbers;
  }
  std::vector<StateRun> runs_;
};

class CoordinateResidual : public ResidualBase<CoordinateResidual> {
 public:
  CoordinateResidual(const StateManifold& manifold, const std::vector<int>& indices)
      : ResidualBase(structure(pieces_of(manifold, indices)), static_cast<int>(indices.size()),
                     false),
        pieces_(pieces_of(manifold, indices)) {
    rotation_.append(StateManifold::Part::so3);
  }

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const S* reference = in.parameters;
    for (const Piece& piece : pieces_) {
      if (piece.is_rotation) {
        rotation_.difference(reference, in.x + piece.index, r);
        r += 3;
        reference += 4;
      } else {
        *r++ = in.x[piece.index] - *reference++;
      }
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (const Piece& piece : pieces_) {
      if (piece.is_rotation) {
        const Matrix3<S> J = inverse_right_jacobian_so3(Vector3<S>{r[0], r[1], r[2]});
        for (int c = 0; c < 3; ++c)
          for (int i = 0; i < 3; ++i) *jacobian++ = J(i, c);
        r += 3;
        continue;
      }
      ++r;
      if (piece.pose < 0) {
        *jacobian++ = S(1.0);
        continue;
      }
      // The tangent is in the body's axes: p ⊕ δ = p + R δ to first order.
      const S* q = in.x + piece.pose + 3;
      const Matrix3<S> R = rotation_matrix(Quaternion<S>{q[0], q[1], q[2], q[3]});
      for (int c = 0; c < 3; ++c) *jacobian++ = R(piece.index - piece.pose, c);
    }
  }

 private:
  /// A coordinate with one row, or a rotation with three.
  struct Piece {
    int index;      ///< into the state; the first number of a rotation
    int tangent;    ///< first of its tangent coordinates
    int pose = -1;  ///< start of the pose if it is part of a position
    bool is_rotation = false;
  };

  /// The segment of the state that contains a number.
  static const StateManifold::Segment& home_of(const StateManifold& manifold, int index) {
    for (const auto& segment : manifold.segments()) {
      const int size = segment.part == StateManifold::Part::flat ? segment.n : segment.n + 1;
      if (index >= segment.x && index < segment.x + size) return segment;
    }
    throw std::invalid_argument("not a coordinate of the state");
  }
  static std::vector<Piece> pieces_of(const StateManifold& manifold,
                                      const std::vector<int>& indices) {
    using Part = StateManifold::Part;
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const StateManifold::Segment& home = home_of(manifold, indices[i]);
      const int inside = indices[i] - home.x, position = home.part == Part::se3 ? 3 : 0;
      if (home.part == Part::flat) {
        pieces.push_back({indices[i], home.dx + inside});
      } else if (inside < position) {
        pieces.push_back({indices[i], home.dx, home.x});
      } else {
        for (std::size_t j = 0; j < 4; ++j)
          if (i + j >= indices.size() || indices[i + j] != home.x + position + static_cast<int>(j))
            throw std::invalid_argument("a part of a rotation is not a coordinate of the state");
        pieces.push_back({indices[i], home.dx + position, -1, true});
        i += 3;
      }
    }
    return pieces;
  }
  static std::vector<RowBlock> structure(const std::vector<Piece>& pieces) {
    std::vector<RowBlock> blocks;
    for (const Piece& piece : pieces) {
      if (piece.is_rotation)
        blocks.push_back({3, column_range(piece.tangent, 3)});
      else if (piece.pose >= 0)
        blocks.push_back({1, column_range(piece.tangent, 3)});
      else
        blocks.push_back({1, {piece.tangent}, true});
    }
    return blocks;
  }
  std::vector<Piece> pieces_;
  StateManifold rotation_;
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
  ControlRateResidual(const StateManifold& system_manifold, int nu, int carried)
      : ResidualBase(structure(system_manifold.ndx() + carried, nu), 0, true),
        previous_(system_manifold.nx() + carried) {}

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
  int previous_;  ///< start of the previous control in the state
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

std::shared_ptr<const Residual> state_residual(const StateManifold& manifold,
                                               const std::vector<int>& left_out) {
  return std::make_shared<StateResidual>(runs_of(manifold, left_out));
}
StateManifold without_coordinates(const StateManifold& manifold, const std::vector<int>& left_out) {
  StateManifold rest;
  for (const StateRun& run : runs_of(manifold, left_out)) rest.append(run.manifold);
  return rest;
}
std::shared_ptr<const Residual> coordinate_residual(const StateManifold& manifold,
                                                    std::vector<int> state_indices) {
  return std::make_shared<CoordinateResidual>(manifold, state_indices);
}
std::shared_ptr<const Residual> control_residual(int ndx, int nu) {
  return std::make_shared<ControlResidual>(ndx, nu);
}
std::shared_ptr<const Residual> control_rate_residual(const System& system, int carried) {
  return std::make_shared<ControlRateResidual>(system.manifold(), system.nu(), carried);
}
std::shared_ptr<const Residual> acceleration_residual(const System& system, int ndx,
                                                      std::vector<int> velocity_indices) {
  return std::make_shared<AccelerationResidual>(system, ndx, std::move(velocity_indices));
}

std::shared_ptr<const Residual> combination_residual(int ndx, std::vector<LinearCombination> rows) {
  const bool needs_control =
      std::any_of(rows.begin(), rows.end(), [](const LinearCombination& row) {
        return std::any_of(row.terms.begin(), row.terms.end(),
                           [](const auto& term) { return term.of_control; });
      });
  return std::make_shared<CombinationResidual>(ndx, std::move(rows), needs_control);
}

}  // namespace conddp
