// Constant structure of a transcription: variables, rows and sparsity of derivatives.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "nlp/transcription.hpp"
#include "systems/contact/stepping_system.hpp"
#include "systems/initial_choice.hpp"

namespace conddp {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Extends a column of a curved segment to the whole segment, which charts mix.
void close_over_segments(const StateManifold& manifold, std::vector<bool>& columns) {
  for (const StateManifold::Segment& s : manifold.curved()) {
    const auto first = columns.begin() + s.dx;
    if (std::find(first, first + s.n, true) != first + s.n) std::fill(first, first + s.n, true);
  }
}

}  // namespace

void Transcription::add_variables() {
  int count = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    base_.push_back(count - first_column(k));
    count += problem_.knot(k).model->nz() - first_column(k);
  }
  lower_ = Eigen::VectorXd::Constant(count, -kUnbounded);
  upper_ = Eigen::VectorXd::Constant(count, kUnbounded);
  for (int k = 0; k < problem_.knots(); ++k) {
    const KnotModel& model = *problem_.knot(k).model;
    for (int i = 0; i < model.nu(); ++i) {
      lower_[base_[k] + model.ndx() + i] = model.control_lower()[i];
      upper_[base_[k] + model.ndx() + i] = model.control_upper()[i];
    }
  }
}

/// A free initial state moves its chosen coordinates and the numbers that states carry along.
void Transcription::find_given_columns() {
  const KnotModel& model = *problem_.knot(0).model;
  if (!problem_.phases().front().instant || model.integrator() != Integrator::explicit_euler)
    return;
  given_.assign(problem_.ndx(), false);
  std::fill_n(given_.begin(), model.system().ndx(), true);
  for (const int column : chosen_coordinates(model.system())) given_[column] = false;
}

/// True if nothing can change a function of these columns of a node.
bool Transcription::is_given(int node, const std::vector<bool>& columns) const {
  if (node != 1 || given_.empty()) return false;
  for (int c = 0; c < static_cast<int>(columns.size()); ++c)
    if (columns[c] && (c >= problem_.ndx() || !given_[c])) return false;
  return true;
}

/// Columns of z that `count` constraint rows of a node depend on, without x_0. Empty if nothing can
/// change them.
std::vector<int> Transcription::columns_of(int k, int first, int count) const {
  const KnotModel& model = *problem_.knot(k).model;
  const int offset = first - problem_.constraint_offset(k);
  std::vector<bool> depends(model.nz(), false);
  for (const auto& [row, column] : model.constraint_pattern())
    if (row >= offset && row < offset + count) depends[column] = true;
  close_over_segments(problem_.manifold(), depends);
  std::vector<int> columns;
  if (is_given(k, depends)) return columns;
  for (int c = first_column(k); c < model.nz(); ++c)
    if (depends[c]) columns.push_back(c);
  return columns;
}

void Transcription::add_row(const NodeConstraint& constraint, int first, int count, double lower,
                            double upper, double radius) {
  const int k = constraint.node, index = static_cast<int>(row_lower_.size());
  Row row{&constraint, first, count, columns_of(k, first, count), index, radius};
  if (row.columns.empty()) {
    given_nodes_ = std::max(given_nodes_, k + 1);
    return;
  }
  for (const int c : row.columns) jacobian_.add(index, base_[k] + c);
  row_lower_.conservativeResize(index + 1);
  row_upper_.conservativeResize(index + 1);
  row_lower_[index] = lower;
  row_upper_[index] = upper;
  if (constraint.is_soft()) add_slacks(row, index, lower, upper);
  rows_[k].push_back(std::move(row));
}

/// A norm has a kink at 0, where a control within a disc may well be, initially and at the
/// solution. Its square is smooth. Divided by twice the bound, the square is as steep as the norm
/// at the bound, so that the row keeps its unit. If the norm has a lower bound, its own row is
/// better: steps along its tangent stay outside.
void Transcription::add_norm(const NodeConstraint& constraint) {
  const double lower = *constraint.lower, upper = *constraint.upper;
  // A soft row must be the distance itself.
  const bool squared = !constraint.is_soft() && lower <= 0 && upper > 0 && std::isfinite(upper);
  if (squared)
    add_row(constraint, constraint.row, 1, -kUnbounded, 0.5 * upper, upper);
  else if (std::isfinite(lower) || std::isfinite(upper))
    add_row(constraint, constraint.row, 1, lower, upper);
}

/// The gradient of a cone row is √2 long on the surface, so its multiplier η represents a vector of
/// length η √2.
void Transcription::add_slacks(Row& row, int index, double lower, double upper) {
  row.first_slack = static_cast<int>(slacks_.size());
  const double limit = row.constraint->limit;
  const auto add = [&](double sign) {
    slacks_.push_back({variables(), sign, is_cone(row) ? limit * std::sqrt(0.5) : limit});
    jacobian_.add(index, variables());
    lower_.conservativeResize(variables() + 1);
    upper_.conservativeResize(lower_.size());
    lower_[lower_.size() - 1] = 0;
    upper_[upper_.size() - 1] = kUnbounded;
    ++row.slacks;
  };
  if (std::isfinite(lower)) add(1);
  if (std::isfinite(upper)) add(-1);
}

/// Adds complementary controls: their bounds, and the relaxed rows.
void Transcription::add_pairs(const NodeConstraint& constraint) {
  const ConstraintTerm& term = *constraint.term;
  const int variable = base_[constraint.node];
  const bool by_node = options_.relaxation == PairRelaxation::inner_product;
  for (int i = 0; i < term.rows; i += 2) {
    const int z = variable + term.blocks[i].columns[0],
              s = variable + term.blocks[i + 1].columns[0];
    pairs_.push_back({constraint.node, z, s, constraint.row + i});
    for (const int v : {z, s}) lower_[v] = std::max(lower_[v], 0.0);
    if (!by_node && !is_penalty()) add_row(constraint, constraint.row + i, 2, -kUnbounded, 0);
  }
  if (by_node && term.rows > 0) add_row(constraint, constraint.row, term.rows, -kUnbounded, 0);
}

std::vector<int> Transcription::find_kinematic_rows(int node) const {
  const KnotModel& model = *problem_.knot(node).model;
  if (!model.semi_implicit() || model.system().as_stepping() != nullptr) return {};
  std::vector<bool> is_flat(problem_.ndx() / 2, true);
  for (const StateManifold::Segment& s : problem_.manifold().curved())
    std::fill_n(is_flat.begin() + s.dx, s.n, false);
  std::vector<int> rows;
  for (int i = 0; i < problem_.ndx() / 2; ++i)
    if (is_flat[i]) rows.push_back(i);
  return rows;
}

namespace {

/// Sparsity of a gap's rows in the columns of z. With a stepping system, each configuration
/// coordinate depends on itself, on its velocity and on that velocity's acceleration. On a curved
/// part, each coordinate depends on the whole part.
class GapPattern {
 public:
  GapPattern(const ShootingProblem& problem, const KnotModel& model,
             const std::vector<int>& kinematic_rows)
      : manifold_(problem.manifold()), ndx_(problem.ndx()), kinematic_rows_(kinematic_rows) {
    const SteppingSystem* system = model.system().as_stepping();
    if (system != nullptr && model.semi_implicit()) first_a_ = ndx_ + system->layout().acceleration;
  }

  bool has(int row, int column) const {
    if (std::binary_search(kinematic_rows_.begin(), kinematic_rows_.end(), row))
      return column == row;
    return !first_a_ || has_in_linear_step(row, column);
  }

 private:
  bool has_in_linear_step(int row, int column) const {
    const int nv = ndx_ / 2;
    // Accelerations of a stepping system are controls.
    const bool is_a = column >= *first_a_ && column < *first_a_ + nv;
    if (column >= ndx_ && !is_a) return false;
    const int joint = is_a ? column - *first_a_ : column % nv;
    if (row < nv) return share_part(row, joint);
    return joint == row - nv && (is_a || column >= nv);
  }
  bool share_part(int a, int b) const {
    if (a == b) return true;
    return std::ranges::any_of(manifold_.curved(), [&](const StateManifold::Segment& s) {
      return s.dx <= std::min(a, b) && std::max(a, b) < s.dx + s.n;
    });
  }

  const StateManifold& manifold_;
  int ndx_;
  const std::vector<int>& kinematic_rows_;
  std::optional<int> first_a_;  ///< first acceleration column of a linear step
};

}  // namespace

/// Adds the gap rows (f(x, u) ⊖ c) − w.
void Transcription::add_gap_rows(int k) {
  const int ndx = problem_.ndx();
  const KnotModel& model = *problem_.knot(k).model;
  const int first = static_cast<int>(row_lower_.size());
  gap_row_.push_back(first);
  row_lower_.conservativeResize(first + ndx);
  row_upper_.conservativeResize(first + ndx);
  row_lower_.tail(ndx).setZero();
  row_upper_.tail(ndx).setZero();
  const std::vector<int>& kinematic = kinematic_rows_.emplace_back(find_kinematic_rows(k));
  const GapPattern pattern(problem_, model, kinematic);
  std::vector<std::pair<int, int>>& entries = gap_entries_.emplace_back();
  for (int c = first_column(k); c < model.nz(); ++c)
    for (int i = 0; i < ndx; ++i)
      if (pattern.has(i, c)) {
        entries.emplace_back(i, c);
        jacobian_.add(first + i, base_[k] + c);
      }
  for (int i = 0; i < ndx; ++i) jacobian_.add(first + i, base_[k + 1] + i);
  for (const int i : kinematic) jacobian_.add(first + i, base_[k + 1] + ndx / 2 + i);
}

namespace {

bool is_equality(const NodeConstraint& c, int row) {
  return !c.is_soft() && c.term->kind == ConstraintKind::bounds && c.lower[row] == c.upper[row];
}

/// The only column of z that a row depends on, and affinely; −1 otherwise.
int lone_column(const ConstraintTerm& term, int row) {
  for (const RowBlock& block : term.blocks) {
    if (row < block.rows)
      return block.affine && block.columns.size() == 1 ? block.columns.front() : -1;
    row -= block.rows;
  }
  return -1;
}

}  // namespace

/// Finds the columns that equalities of a node fix.
void Transcription::find_fixed_columns(std::span<const NodeConstraint> of_node, int node) {
  fixed_.assign(problem_.knot(node).model->nz(), false);
  for (const NodeConstraint& c : of_node)
    for (int i = 0; i < c.term->rows; ++i)
      if (const int column = lone_column(*c.term, i); column >= 0 && is_equality(c, i))
        fixed_[column] = true;
}

void Transcription::add_rows() {
  const std::vector<NodeConstraint>& all = problem_.constraints();
  auto first = all.begin();
  for (int k = 0; k <= problem_.knots(); ++k) {
    const auto last = std::find_if(first, all.end(), [k](const auto& c) { return c.node != k; });
    find_fixed_columns({first, last}, k);
    for (; first != last; ++first) add_constraint(*first);
    if (k < problem_.knots()) add_gap_rows(k);
  }
  relax(options_.epsilon);
}

void Transcription::add_constraint(const NodeConstraint& constraint) {
  switch (constraint.term->kind) {
    case ConstraintKind::complementarity:
      return add_pairs(constraint);
    case ConstraintKind::second_order_cone:
      return add_row(constraint, constraint.row, constraint.term->rows, 0, kUnbounded);
    case ConstraintKind::norm:
      return add_norm(constraint);
    case ConstraintKind::bounds:
      return add_bounds(constraint);
  }
}

/// Bounds on a column that an equality fixes are omitted: if its value is at a bound, the two
/// multipliers are not unique.
void Transcription::add_bounds(const NodeConstraint& constraint) {
  for (int i = 0; i < constraint.term->rows; ++i) {
    if (!std::isfinite(constraint.lower[i]) && !std::isfinite(constraint.upper[i])) continue;
    const int column = is_equality(constraint, i) ? -1 : lone_column(*constraint.term, i);
    if (column < 0 || !fixed_[column])
      add_row(constraint, constraint.row + i, 1, constraint.lower[i], constraint.upper[i]);
  }
}

/// Sparsity of a knot's Hessian.
class Transcription::BlockPattern {
 public:
  BlockPattern(int size, bool full) : used_(size, std::vector<bool>(size, full)) {}

  bool has(int row, int column) const { return used_[row][column]; }
  /// Adds this entry and its mirror image.
  void add(int a, int b) { used_[a][b] = used_[b][a] = true; }
  void add_all(const std::vector<int>& columns) {
    for (const int a : columns)
      for (const int b : columns) used_[a][b] = true;
  }
  /// Charts mix the coordinates of curved parts.
  void close(const StateManifold& manifold) {
    for (std::vector<bool>& row : used_) close_over_segments(manifold, row);
    for (const StateManifold::Segment& s : manifold.curved()) close_rows(s);
  }

 private:
  void close_rows(const StateManifold::Segment& s) {
    for (std::size_t c = 0; c < used_.size(); ++c) {
      bool any = false;
      for (int i = 0; i < s.n; ++i) any = any || used_[s.dx + i][c];
      for (int i = 0; i < s.n; ++i) used_[s.dx + i][c] = any;
    }
  }

  std::vector<std::vector<bool>> used_;
};

/// Adds the entries that the curvature of steps on curved parts fills.
void Transcription::add_step_curvature(const KnotModel& model, BlockPattern& used) const {
  const SteppingSystem* system = model.system().as_stepping();
  if (system == nullptr) return;
  const int ndx = problem_.ndx(), nv = ndx / 2;
  const int first_a = ndx + system->layout().acceleration;
  for (const StateManifold::Segment& s : problem_.manifold().curved()) {
    std::vector<int> columns;
    for (const int first : {0, nv, first_a})
      for (int i = 0; i < s.n; ++i) columns.push_back(first + s.dx + i);
    used.add_all(columns);
  }
}

/// Adds the entries of relaxed pairs, in rows or in the objective.
void Transcription::add_pair_entries(int k, BlockPattern& used) const {
  for (const Row& row : rows_[k]) {
    if (!has_pairs(row)) continue;
    for (int i = 0; i < row.count; i += 2) {
      const auto& blocks = row.constraint->term->blocks;
      const int at = row.first - row.constraint->row + i;
      used.add_all({blocks[at].columns[0], blocks[at + 1].columns[0]});
    }
  }
  if (!is_penalty()) return;
  for (const Pair& pair : pairs_)
    if (pair.node == k) used.add(pair.z - base_[k], pair.s - base_[k]);
}

/// True if the dynamics fill a knot's block of an exact Hessian. Linear steps leave it sparse.
/// Steps that are nonlinear only on curved parts fill the entries of these parts, their velocities
/// and accelerations. Gauss-Newton Hessians are sparse, too.
bool Transcription::has_full_hessian(int k) const {
  if (options_.gauss_newton || k == problem_.knots()) return false;
  return !problem_.knot(k).model->step().is_linear();
}

Transcription::BlockPattern Transcription::hessian_pattern(int k) const {
  const KnotModel& model = *problem_.knot(k).model;
  const bool full = has_full_hessian(k);
  BlockPattern used(model.nz(), full);
  add_pair_entries(k, used);
  if (full) return used;
  for (const auto& [row, column] : model.hessian_pattern()) used.add(row, column);
  used.close(problem_.manifold());
  if (!options_.gauss_newton && k < problem_.knots()) add_step_curvature(model, used);
  return used;
}

void Transcription::index_hessian() {
  hessian_entries_.resize(problem_.knots() + 1);
  for (int k = 0; k <= problem_.knots(); ++k) {
    const int nz = problem_.knot(k).model->nz();
    const BlockPattern used = hessian_pattern(k);
    for (int c = first_column(k); c < nz; ++c)
      for (int r = c; r < nz; ++r) {
        if (!used.has(r, c)) continue;
        hessian_entries_[k].emplace_back(r, c);
        hessian_.add(base_[k] + r, base_[k] + c);
      }
  }
  if (pairs_.empty()) return;
  spare_ = variables();
  lower_.conservativeResize(spare_ + 1);
  upper_.conservativeResize(spare_ + 1);
  lower_[spare_] = -kUnbounded;
  upper_[spare_] = kUnbounded;
  hessian_.add(spare_, spare_);
}

}  // namespace conddp
