#include "systems/collocation_system.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

/// A row for each later stage of a rule: the velocity part is h Σ_j velocity[j] k_j. In
/// second-order systems, the position part is h · time · v + h² Σ_j position[j] k_j, with the
/// matrices A and A² of the rule. The slope k_0 is that at the beginning of the step; Radau rules
/// do not depend on it.
struct StageRow {
  double time;
  double velocity[4];
  double position[4];

  /// The first stage whose slope the row uses. Stage 0 is skipped if its weights are zero, because
  /// its slope may be undefined.
  int first() const { return velocity[0] == 0 && position[0] == 0 ? 1 : 0; }
};
struct Rule {
  int later;
  StageRow rows[3];
  const char* names[3];
};

constexpr Rule kTrapezoidal{1, {{1, {1.0 / 2, 1.0 / 2}, {1.0 / 4, 1.0 / 4}}}, {"end"}};
constexpr Rule kHermiteSimpson{
    2,
    {{0.5, {5.0 / 24, 1.0 / 3, -1.0 / 24}, {1.0 / 16, 1.0 / 12, -1.0 / 48}},
     {1, {1.0 / 6, 2.0 / 3, 1.0 / 6}, {1.0 / 6, 1.0 / 3, 0}}},
    {"middle", "end"}};
constexpr Rule kRadau3{2,
                       {{1.0 / 3, {0, 5.0 / 12, -1.0 / 12}, {0, 1.0 / 9, -1.0 / 18}},
                        {1, {0, 3.0 / 4, 1.0 / 4}, {0, 1.0 / 2, 0}}},
                       {"first", "end"}};

/// Computes `time` and `position` of a rule from its matrix A. All stages of the rule are later
/// ones.
constexpr Rule completed(Rule rule) {
  for (int i = 0; i < rule.later; ++i) {
    rule.rows[i].time = 0;
    for (int j = 1; j <= rule.later; ++j) {
      rule.rows[i].time += rule.rows[i].velocity[j];
      rule.rows[i].position[j] = 0;
      for (int k = 1; k <= rule.later; ++k)
        rule.rows[i].position[j] += rule.rows[i].velocity[k] * rule.rows[k - 1].velocity[j];
    }
  }
  return rule;
}

constexpr double kRoot6 = 2.449489742783178098;
constexpr Rule kRadau5 = completed(
    {3,
     {{0, {0, (88 - 7 * kRoot6) / 360, (296 - 169 * kRoot6) / 1800, (-2 + 3 * kRoot6) / 225}, {}},
      {0, {0, (296 + 169 * kRoot6) / 1800, (88 + 7 * kRoot6) / 360, (-2 - 3 * kRoot6) / 225}, {}},
      {0, {0, (16 - kRoot6) / 36, (16 + kRoot6) / 36, 1.0 / 9}, {}}},
     {"first", "middle", "end"}});

const Rule& table(CollocationRule rule) {
  switch (rule) {
    case CollocationRule::trapezoidal:
      return kTrapezoidal;
    case CollocationRule::hermite_simpson:
      return kHermiteSimpson;
    case CollocationRule::radau3:
      return kRadau3;
    case CollocationRule::radau5:
      break;
  }
  return kRadau5;
}

/// Adds the effect of the slopes at stage j on a later stage to the columns of the slopes'
/// variables.
template <class S>
struct SlopeColumns {
  const StageRow& row;
  S h;
  int n, top;  ///< sizes of the slopes and of the coordinates before theirs

  void add(int j, int r, const S& slope, S* column) const {
    column[top + r] += h * S(row.velocity[j]) * slope;
    if (top > 0) column[r] += h * h * S(row.position[j]) * slope;
  }
  /// Adds the slopes at the knot, given their derivatives with respect to `count` variables.
  void add_first(int count, const S* by_variables, S* columns) const {
    for (int c = 0; c < count; ++c)
      for (int r = 0; r < n; ++r) add(0, r, by_variables[c * n + r], columns + c * (top + n));
  }
};

/// The unit of a quantity's time derivative.
std::string rate_unit(const std::string& unit) {
  if (unit == "1") return "1/s";
  return unit.ends_with("/s") ? unit + "²" : unit + "/s";
}

}  // namespace

CollocationSystem::CollocationSystem(std::shared_ptr<const System> inside, CollocationRule rule)
    : System(inside->kind(), inside->manifold(), 0), inside_(std::move(inside)), rule_(rule) {
  if (!manifold_.curved().empty())
    throw std::invalid_argument("collocation needs a flat state space");
  if (kind_ != SystemKind::second_order && kind_ != SystemKind::first_order)
    throw std::invalid_argument("collocation needs a system that gives slopes");
  state_columns_ = inside_->state_columns();
  for (int i = 0; i < nx(); ++i) at_rest_.push_back(!inside_->has_state(i));
  control_columns_ = inside_->control_columns();
  control_lower_ = inside_->control_lower();
  control_upper_ = inside_->control_upper();
  for (int i = 0; i < later_stages(); ++i)
    for (int row = 0; row < rows(); ++row) {
      const Column& state = state_columns_[ndx() - rows() + row];
      control_columns_.push_back({std::string("slope_") + table(rule_).names[i] + "/" + state.name,
                                  rate_unit(state.unit)});
    }
  nu_ = static_cast<int>(control_columns_.size());
  control_lower_.resize(nu_, -std::numeric_limits<double>::infinity());
  control_upper_.resize(nu_, std::numeric_limits<double>::infinity());
}

int CollocationSystem::later_stages() const { return table(rule_).later; }

double CollocationSystem::time(int stage) const { return table(rule_).rows[stage - 1].time; }

double CollocationSystem::weight(int stage) const {
  return table(rule_).rows[later_stages() - 1].velocity[stage];
}

template <class S>
CollocationSystem::Later<S>::Later(const CollocationSystem& system,
                                   std::unique_ptr<SystemData<S>> inside_data)
    : inside(std::move(inside_data)),
      x(system.nx(), S(0.0)),
      X(system.ndx() * (system.ndx() + system.nu() + 1), S(0.0)),
      u(system.actuators(), S(0.0)) {}

template <class S>
void CollocationSystem::stage(int i, const S* x, const S* w, const S& h, const SystemData<S>& data,
                              S* out) const {
  const StageRow& row = table(rule_).rows[i - 1];
  const int n = rows(), top = ndx() - n;
  for (int r = 0; r < n; ++r) {
    S velocity(0.0), position(0.0);
    for (int j = row.first(); j <= later_stages(); ++j) {
      const S& slope = j == 0 ? data.f[r] : w[slopes(j) + r];
      velocity += S(row.velocity[j]) * slope;
      position += S(row.position[j]) * slope;
    }
    if (top > 0) out[r] = x[r] + h * (S(row.time) * x[top + r] + h * position);
    out[top + r] = x[top + r] + h * velocity;
  }
}

template <class S>
void CollocationSystem::differentiate_stage(int i, const S* x, const S* w, const S& h,
                                            const SystemData<S>& data, bool by_step, S* X) const {
  const StageRow& row = table(rule_).rows[i - 1];
  const int n = rows(), top = ndx() - n, nz = ndx() + nu();
  std::fill_n(X, ndx() * (nz + by_step), S(0.0));
  for (int c = 0; c < ndx(); ++c) {
    X[c * ndx() + c] = S(1.0);
    if (top > 0 && c >= top) X[c * ndx() + c - top] = h * S(row.time);
  }
  const SlopeColumns<S> slope_columns{row, h, n, top};
  if (row.first() == 0) {
    slope_columns.add_first(ndx(), data.fx.data(), X);
    slope_columns.add_first(actuators(), data.fu.data(), X + ndx() * ndx());
  }
  for (int j = 1; j <= later_stages(); ++j)
    for (int r = 0; r < n; ++r)
      slope_columns.add(j, r, S(1.0), X + (ndx() + slopes(j) + r) * ndx());
  if (by_step) differentiate_by_step(i, x, w, h, data, X + nz * ndx());
}

/// Writes the derivative with respect to h into a column; overwrites it.
template <class S>
void CollocationSystem::differentiate_by_step(int i, const S* x, const S* w, const S& h,
                                              const SystemData<S>& data, S* column) const {
  const StageRow& row = table(rule_).rows[i - 1];
  const int n = rows(), top = ndx() - n;
  for (int r = 0; r < n; ++r) {
    if (top > 0) column[r] = S(row.time) * x[top + r];
    for (int j = row.first(); j <= later_stages(); ++j) {
      const S& slope = j == 0 ? data.f[r] : w[slopes(j) + r];
      column[top + r] += S(row.velocity[j]) * slope;
      if (top > 0) column[r] += S(2 * row.position[j]) * h * slope;
    }
  }
}

#define CONDDP_INSTANTIATE(S)                                                                     \
  std::unique_ptr<SystemData<S>> CollocationSystem::create_data(S) const {                        \
    auto data = inside_->create_data(S{});                                                        \
    data->fu.assign(rows() * nu(), S(0.0)); /* the columns of slopes stay zero */                 \
    auto at_stage = inside_->create_data(S{});                                                    \
    at_stage->fu.assign(rows() * nu(), S(0.0));                                                   \
    data->later = std::make_unique<Later<S>>(*this, std::move(at_stage));                         \
    return data;                                                                                  \
  }                                                                                               \
  template struct CollocationSystem::Later<S>;                                                    \
  template void CollocationSystem::stage(int, const S*, const S*, const S&, const SystemData<S>&, \
                                         S*) const;                                               \
  template void CollocationSystem::differentiate_stage(int, const S*, const S*, const S&,         \
                                                       const SystemData<S>&, bool, S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
