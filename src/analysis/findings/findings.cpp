#include "analysis/findings/findings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "analysis/findings/contact_findings.hpp"
#include "analysis/findings/grid_findings.hpp"
#include "base/exceeds.hpp"
#include "base/matrix_decompositions.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/node_values.hpp"
#include "systems/collocation_system.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// Slack for limits and constraints that are met exactly, up to rounding and tolerances.
constexpr double kSlack = 1e-6;
/// A violation between knots is reported if it exceeds that at knots by this, in its unit.
constexpr double kBetween = 1e-4;
/// The path between two knots is sampled at quarters, and more closely where a row may be violated
/// between two samples.
constexpr int kPartsOfAStep = 4;
constexpr double kShortestPart = 1.0 / 64;
/// Rows may change along a path at this multiple of their rate between its samples.
constexpr double kRateMargin = 1.5;
/// Distances from violations beyond this are equal.
constexpr double kFar = 1e9;

/// True if a control is at its limit or beyond. Limits of 0 or infinity do not count.
bool is_at(double control, double limit) {
  return limit != 0 && std::isfinite(limit) && std::abs(control) >= (1 - kSlack) * std::abs(limit);
}

bool is_beyond(double off, double limit) { return off > kSlack * std::max(1.0, std::abs(limit)); }

bool is_finite(const Trajectory& trajectory) {
  for (int k = 0; k <= trajectory.knots(); ++k)
    if (!trajectory.x(k).allFinite() || (k < trajectory.knots() && !trajectory.u(k).allFinite()))
      return false;
  return true;
}

class Search {
 public:
  Search(const ShootingProblem& problem, const Trajectory& trajectory,
         const std::vector<Eigen::MatrixXd>& gains, const NodeValues& values,
         const FindingNames& names)
      : problem_(problem),
        trajectory_(trajectory),
        gains_(gains),
        values_(values),
        names_(names),
        times_(problem.times(trajectory)),
        nodes_(problem) {}

  /// Findings on obstacles that the motion jumps through.
  std::vector<Finding> jumps() {
    between();
    std::erase_if(list_, [](const Finding& f) { return !f.jumps; });
    return std::move(list_);
  }

  std::vector<Finding> run() {
    for (int k = 0; k <= problem_.knots(); ++k) joints(k);
    tell_of_joints();
    for (int k = 0; k < problem_.knots(); ++k) efforts(k);
    for (auto& [name, effort] : efforts_) report(name, effort);
    find_in_contacts(problem_, trajectory_, values_, names_, list_);
    rows();
    between();
    tables();
    last_knot();
    thrusters();
    find_in_grid(problem_, trajectory_, gains_, list_);
    sort();
    return std::move(list_);
  }

 private:
  struct Effort {
    std::string unit;
    double limit = 0, beyond = 0, seconds = 0, all = 0;
    int knot = -1;

    /// Records a control, and how long it keeps its value.
    void meet(double control, double limit_here, double length, int k) {
      if (!is_at(control, limit_here)) return;
      const double off = std::abs(control) - std::abs(limit_here);
      seconds += length;
      if (knot >= 0 && !(is_beyond(off, limit_here) && exceeds(off, beyond))) return;
      knot = k;
      limit = limit_here;
      beyond = is_beyond(off, limit_here) ? off : 0;
    }
  };

  /// Sorts by kind, the worst of each kind first.
  void sort() {
    std::stable_sort(list_.begin(), list_.end(),
                     [](const Finding& a, const Finding& b) { return a.kind < b.kind; });
    for (auto first = list_.begin(), next = first; first != list_.end(); first = next) {
      next =
          std::find_if(first, list_.end(), [&](const Finding& f) { return f.kind != first->kind; });
      sort_worst_first(first, next, [](const Finding& f) { return f.value; });
    }
  }

  Finding& add(FindingKind kind, const std::string& subject, double value, std::string unit,
               int k) {
    Finding& f = list_.emplace_back();
    f.kind = kind;
    f.subject = subject;
    f.value = value;
    f.unit = std::move(unit);
    f.knot = k;
    f.time = k < 0 ? 0 : times_[k];
    return f;
  }

  /// The finding of this kind and subject if `value` is a new worst case; otherwise null.
  Finding* worst(FindingKind kind, const std::string& subject, double value, const char* unit,
                 int k) {
    if (!(value > kSlack)) return nullptr;
    for (Finding& f : list_)
      if (f.kind == kind && f.subject == subject) {
        if (!exceeds(value, f.value)) return nullptr;
        f.value = value;
        f.knot = k;
        f.time = times_[k];
        return &f;
      }
    return &add(kind, subject, value, unit, k);
  }

  void joints(int k) {
    const MultibodySystem* robot = problem_.knot(k).model->system().robot_inside();
    if (robot == nullptr) return;
    const auto x = trajectory_.x(k);
    for (int j = 0; j < robot->robot().joint_count(); ++j) {
      const Joint& joint = robot->robot().joints[j];
      const auto q = robot->position_index(j), v = robot->velocity_index(j);
      if (!q || !v || joint.type == JointType::floating) continue;
      const auto limits = robot->limits(j);
      const bool slides = joint.type == JointType::prismatic;
      const double limit = x[*q] > limits.upper ? limits.upper : limits.lower;
      const double off = std::max(limits.lower - x[*q], x[*q] - limits.upper);
      beyond_limit({FindingKind::position_limit, "position", "configuration", slides ? "m" : "rad"},
                   joint.name, limit, off, k);
      beyond_limit({FindingKind::velocity_limit, "velocity", "velocity", slides ? "m/s" : "rad/s"},
                   joint.name, limits.max_velocity, std::abs(x[*v]) - limits.max_velocity, k);
    }
  }

  /// A limited quantity of a joint, and the bounds of the problem file that enforce it.
  struct Limited {
    FindingKind kind;
    const char *what, *bounds, *unit;
    double limit = 0;
  };
  void beyond_limit(Limited of, const std::string& joint, double limit, double off, int k) {
    const Finding* f = worst(of.kind, joint, off, of.unit, k);
    if (f == nullptr) return;
    of.limit = limit;
    limited_.resize(list_.size());
    limited_[f - list_.data()] = of;
  }

  /// Writes the messages once the worst cases are known. The list contains only these findings so
  /// far.
  void tell_of_joints() {
    for (std::size_t i = 0; i < list_.size(); ++i) {
      Finding& f = list_[i];
      const Limited& of = limited_[i];
      f.message = fmt::format("the {} of '{}' is beyond its limit of {:.4g} {} by {:.3g}", of.what,
                              f.subject, of.limit, of.unit, f.value);
      // Bounds count where knots of their phases begin, and by 'nodes: ends' before an impulse,
      // too.
      const bool ends = f.knot < problem_.knots() && problem_.takes_no_time(f.knot);
      const auto& present = ends ? names_.bounded_to_the_end : names_.bounded;
      // If the file has these bounds, they are violated; a limit of 0 lets nothing move.
      if (of.limit != 0 && !present.contains(of.bounds))
        f.remedy = fmt::format("constraints: {{NAME: {{bounds: {}, from: urdf{}}}}}", of.bounds,
                               ends ? ", nodes: ends" : "");
    }
  }

  void efforts(int k) {
    const MultibodySystem* robot = problem_.knot(k).model->system().robot_inside();
    if (robot == nullptr || problem_.takes_no_time(k)) return;
    const Actuation& actuation = robot->actuation();
    if (robot != efforts_of_) find_efforts(*robot);
    const double step = times_[k + 1] - times_[k];
    for (int i = 0; i < actuation.nu; ++i) {
      Effort& effort = *effort_[i];
      effort.all += step;
      const auto limit = [&](double u) { return u > 0 ? actuation.upper[i] : actuation.lower[i]; };
      const double begin = control_at_beginning(k, i), end = trajectory_.u(k)[i];
      // Linear controls stay at a limit if both ends of the knot are at it.
      const bool stays =
          begin == end || (is_at(begin, limit(begin)) && begin * end > 0 && is_at(end, limit(end)));
      effort.meet(begin, limit(begin), stays ? step : 0, k);
      if (begin != end) effort.meet(end, limit(end), 0, k + 1);
    }
  }

  /// Looks up the efforts of a robot's actuators; phases with other contacts have other systems.
  void find_efforts(const MultibodySystem& robot) {
    efforts_of_ = &robot;
    effort_.clear();
    for (const Column& column : robot.actuation().columns) {
      effort_.push_back(&efforts_[column.name]);
      effort_.back()->unit = column.unit;
    }
  }

  double control_at_beginning(int k, int control) const {
    const Step& step = problem_.knot(k).model->step();
    return step.first_control(trajectory_.x(k), trajectory_.u(k))[control];
  }

  void report(const std::string& name, const Effort& effort) {
    const bool beyond = effort.beyond > 0;
    if (effort.knot < 0 || (!beyond && effort.seconds == 0)) return;
    Finding& f = add(FindingKind::effort_limit, name, beyond ? effort.beyond : effort.seconds,
                     beyond ? effort.unit : "s", effort.knot);
    if (beyond) {
      f.message = fmt::format("{} is {:.3g} {} beyond its limit of {:.3g}", name, effort.beyond,
                              effort.unit, effort.limit);
      if (!names_.bounded.contains("control"))
        f.remedy = "constraints: {NAME: {bounds: control, from: urdf}}";
    } else {
      f.message = fmt::format("{} is at its limit of {:.3g} {} for {:.3g} s of {:.3g} s", name,
                              effort.limit, effort.unit, effort.seconds, effort.all);
    }
  }

  std::string name_of(const NodeConstraint& c) const { return constraint_name(problem_, c); }

  /// Finds violated rows of constraints with several rows: each row of distances, and otherwise the
  /// worst row of constraints that are not soft.
  void rows() {
    for (const auto* constraints : {&problem_.constraints(), &problem_.soft_constraints()})
      for (const NodeConstraint& c : *constraints) {
        const auto names = names_.rows.find(name_of(c));
        if (names == names_.rows.end() || c.lower == nullptr ||
            static_cast<int>(names->second.names.size()) != c.term->rows)
          continue;
        const std::string& unit = names->second.unit;
        if (unit.empty() && c.is_soft()) continue;
        evaluate(c.node, trajectory_.x(c.node));
        const Eigen::VectorXd values = values_of(c);
        for (int i = 0; i < c.term->rows; ++i) {
          const double off = std::max(c.lower[i] - values[i], values[i] - c.upper[i]);
          const std::string& row = names->second.names[i];
          const std::string subject = unit.empty() ? name_of(c) : row + " (" + name_of(c) + ")";
          if (Finding* f = worst(FindingKind::constraint_row, subject, off, unit.c_str(), c.node))
            f->message = fmt::format("'{}' is violated by {:.3g}{} by {}", name_of(c), off,
                                     unit.empty() ? "" : " " + unit, row);
        }
      }
  }

  /// Evaluates the constraints of a node at a state, with the node's controls.
  void evaluate(int k, const Eigen::VectorXd& x) {
    const double* u = k < problem_.knots() ? trajectory_.u(k).data() : nullptr;
    evaluated_ = &nodes_.at(k, x.data(), u);
  }
  /// Values g of one of these constraints, as evaluated.
  Eigen::VectorXd values_of(const NodeConstraint& c) const {
    return Eigen::Map<const Eigen::VectorXd>(evaluated_->constraint.data() + c.term->row,
                                             c.term->rows);
  }

  std::vector<const NodeConstraint*> state_inequalities() const {
    std::vector<const NodeConstraint*> list;
    for (const NodeConstraint& c : problem_.constraints())
      if (is_state_inequality(c)) list.push_back(&c);
    return list;
  }

  /// Largest violation of each constraint, by name.
  std::map<std::string, double> violations_at_nodes(
      const std::vector<const NodeConstraint*>& constraints) {
    std::map<std::string, double> largest;
    int evaluated = -1;
    for (const NodeConstraint* c : constraints) {
      if (c->node != evaluated) evaluate(evaluated = c->node, trajectory_.x(c->node));
      const Eigen::VectorXd values = values_of(*c);
      double& most = largest[c->term->name];
      most = std::max(most, distance_to_set(*c->term, values.data(), c->lower, c->upper));
    }
    return largest;
  }

  /// Checks state inequalities along the straight path from one node to the next.
  void between() {
    const std::vector<const NodeConstraint*> all = state_inequalities();
    const std::map<std::string, double> at_knots = violations_at_nodes(all);
    const std::vector<const NodeConstraint*> watched = those_that_go_on(all);
    for (std::size_t first = 0, last = 0; first < watched.size(); first = last) {
      const int k = watched[first]->node;
      while (last < watched.size() && watched[last]->node == k) ++last;
      if (k < problem_.knots() && !problem_.takes_no_time(k))
        look_along(k, std::span(watched).subspan(first, last - first), at_knots);
    }
  }

  /// Constraints that also hold at the next node. At the end of a phase, only constraints of that
  /// node hold. A constraint that already held at the previous node therefore continues to the end.
  std::vector<const NodeConstraint*> those_that_go_on(
      const std::vector<const NodeConstraint*>& constraints) {
    for (const NodeConstraint* c : constraints) places_.emplace(c->term->name, c->node);
    std::vector<const NodeConstraint*> list;
    for (const NodeConstraint* c : constraints) {
      const int other = c->node + (ends_phase(c->node) ? -1 : 1);
      if (places_.contains({c->term->name, c->node + 1}) ||
          places_.contains({c->term->name, other}))
        list.push_back(c);
    }
    return list;
  }

  /// True if the next node is the last one or belongs to another phase.
  bool ends_phase(int k) const {
    return k + 1 == problem_.knots() ||
           (k < problem_.knots() && problem_.knot(k + 1).phase != problem_.knot(k).phase);
  }

  bool is_state_inequality(const NodeConstraint& c) const {
    const Step& end = problem_.terminal().model->step();
    if (!c.term->has_bounds() || c.is_soft() || c.term->depends_on_control(end.control_column(0)))
      return false;
    for (int i = 0; i < c.term->rows; ++i)
      if (c.lower[i] < c.upper[i]) return true;
    return false;
  }

  /// The constraints of a node along the path to the next one.
  struct Path {
    int k;
    Eigen::VectorXd way;
    std::span<const NodeConstraint* const> constraints;
    const std::map<std::string, double>& at_knots;
    Eigen::VectorXd rate;   ///< largest change of each row per step
    Eigen::VectorXd least;  ///< smallest distance of each row so far, at most 0
  };
  /// Distance of each row from a violation between knots, at a part of the way.
  struct Sample {
    double part;
    Eigen::VectorXd room;
  };

  /// Checks constraints of a node along the path to the next one.
  void look_along(int k, std::span<const NodeConstraint* const> constraints,
                  const std::map<std::string, double>& at_knots) {
    Path path{k, Eigen::VectorXd(problem_.ndx()), constraints, at_knots, {}, {}};
    problem_.manifold().difference(trajectory_.x(k).data(), trajectory_.x(k + 1).data(),
                                   path.way.data());
    std::vector<Sample> samples;
    for (int part = 0; part <= kPartsOfAStep; ++part)
      samples.push_back(sample(path, static_cast<double>(part) / kPartsOfAStep));
    path.rate = path.least = Eigen::VectorXd::Zero(samples[0].room.size());
    for (const Sample& sample : samples) path.least = path.least.cwiseMin(sample.room);
    for (int part = 0; part < kPartsOfAStep; ++part)
      path.rate = path.rate.cwiseMax(kPartsOfAStep *
                                     (samples[part + 1].room - samples[part].room).cwiseAbs());
    for (int part = 0; part < kPartsOfAStep; ++part)
      look_closer(path, samples[part], samples[part + 1]);
    if (!ends_phase(k)) return;
    evaluate(k, trajectory_.x(k + 1));
    for (const NodeConstraint* c : constraints) look_at_end(*c, at_knots);
  }

  /// Evaluates the constraints at a part of the way, and notes violations inside it.
  Sample sample(const Path& path, double part) {
    Eigen::VectorXd x(problem_.nx());
    const Eigen::VectorXd dx = path.way * part;
    problem_.manifold().integrate(trajectory_.x(path.k).data(), dx.data(), x.data());
    evaluate(path.k, x);
    std::vector<double> room;
    for (const NodeConstraint* c : path.constraints) {
      if (part > 0 && part < 1) look_between(*c, path.at_knots);
      const Eigen::VectorXd values = values_of(*c);
      const double allowed = path.at_knots.at(c->term->name) + kBetween;
      for (int i = 0; i < c->term->rows; ++i)
        room.push_back(std::clamp(
            std::min(values[i] - c->lower[i], c->upper[i] - values[i]) + allowed, -kFar, kFar));
    }
    return {part, Eigen::Map<Eigen::VectorXd>(room.data(), static_cast<Eigen::Index>(room.size()))};
  }

  /// Halves a part of the way while a row may be violated there, by its rate, more than twice as
  /// far as at all samples (Piyavskii 1972): an obstacle may be thinner than the part.
  void look_closer(Path& path, const Sample& begin, const Sample& end) {
    const double length = end.part - begin.part;
    if (length <= kShortestPart) return;
    const auto least = 0.5 * (begin.room + end.room - kRateMargin * length * path.rate);
    if ((least.array() >= 2 * path.least.array()).all()) return;
    const Sample middle = sample(path, begin.part + length / 2);
    path.least = path.least.cwiseMin(middle.room);
    look_closer(path, begin, middle);
    look_closer(path, middle, end);
  }

  /// Constraints do not hold automatically at the node that ends their phase.
  void look_at_end(const NodeConstraint& c, const std::map<std::string, double>& at_knots) {
    const Eigen::VectorXd values = values_of(c);
    const double off = distance_to_set(*c.term, values.data(), c.lower, c.upper);
    if (off <= at_knots.at(c.term->name) + kBetween) return;
    const int end = c.node + 1;
    if (places_.contains({c.term->name, end})) return;
    Finding* f = worst(FindingKind::between_knots, c.term->name, off, "", end);
    if (f == nullptr) return;
    f->message = fmt::format(
        "'{}' is violated by {:.3g}{} at {}, where it is not enforced", c.term->name, off,
        offender(c, values),
        end == problem_.knots() ? "the last node"
                                : fmt::format("node {}, the end of the phase '{}'", end,
                                              problem_.phases()[problem_.knot(c.node).phase].name));
    f->remedy = "'nodes: ends'";
  }

  void look_between(const NodeConstraint& c, const std::map<std::string, double>& at_knots) {
    const double usual = at_knots.at(c.term->name);
    const Eigen::VectorXd values = values_of(c);
    const double off = distance_to_set(*c.term, values.data(), c.lower, c.upper);
    if (off <= usual + kBetween) return;
    Finding* f = worst(FindingKind::between_knots, c.term->name, off, "", c.node);
    if (f == nullptr) return;
    f->message =
        fmt::format("'{}' is violated by {:.3g}{} between knots {} and {}, by {:.1e} at knots",
                    c.term->name, off, offender(c, values), c.node, c.node + 1, usual);
    f->jumps = jumps_through(c, off);
    f->remedy = f->jumps
                    ? std::string(
                          "another first guess, or many of them (solver.restarts): the motion "
                          "jumps through an obstacle that it should avoid")
                    : fmt::format("more knots (about {:.0f} times as many), or wider distances",
                                  std::ceil(std::sqrt(off / kBetween)));
  }

  /// True if a row is violated by so large a part of its bound that the path between knots passes
  /// through an obstacle. For a distance from a center, the bound is the obstacle's radius.
  static bool jumps_through(const NodeConstraint& c, double off) {
    constexpr double kDeep = 0.3;
    for (int i = 0; i < c.term->rows; ++i)
      if (c.lower[i] > 0 && std::isinf(c.upper[i]) && off > kDeep * c.lower[i]) return true;
    return false;
  }

  /// " m by forearm - table", if the rows have names.
  std::string offender(const NodeConstraint& c, const Eigen::VectorXd& values) const {
    const auto names = names_.rows.find(name_of(c));
    if (names == names_.rows.end() || static_cast<int>(names->second.names.size()) != c.term->rows)
      return {};
    int row = 0;
    double most = 0;
    for (int i = 0; i < c.term->rows; ++i)
      if (const double off = std::max(c.lower[i] - values[i], values[i] - c.upper[i]);
          exceeds(off, most)) {
        most = off;
        row = i;
      }
    const auto& [rows, unit] = names->second;
    return (unit.empty() ? "" : " " + unit) + " by " + rows[row];
  }

  /// Largest change of a control between two knots before the last step, and its range.
  std::pair<double, double> changes(int control, int first, int last) const {
    double most = 0, low = trajectory_.u(first)[control], high = low;
    for (int k = first + 1; k <= last; ++k) {
      const double u = trajectory_.u(k)[control];
      if (k < last) most = std::max(most, std::abs(u - trajectory_.u(k - 1)[control]));
      low = std::min(low, u);
      high = std::max(high, u);
    }
    return {most, high - low};
  }

  /// Finds tables that are read beyond their points: the worst place, and the knots concerned.
  void tables() {
    for (int k = 0; k <= problem_.knots(); ++k) {
      const KnotView& knot = problem_.knot(k);
      const double* x = trajectory_.x(k).data();
      const double* u = k < problem_.knots() ? trajectory_.u(k).data() : nullptr;
      if (u != nullptr) read_beyond(knot.model->system().table_readings(x, u), k);
      for (const CostTerm& cost : knot.model->costs())
        if (knot.parameters[cost.weight] != 0)
          read_beyond(cost.residual->table_readings(x, u, knot.parameters + cost.parameters), k);
      for (const ConstraintTerm& term : knot.model->constraints())
        if (knot.parameters[term.active()] != 0)
          read_beyond(term.residual->table_readings(x, u, knot.parameters + term.parameters), k);
    }
    for (const auto& [end, range] : ranges_) report_range(range);
  }

  /// Use of a table beyond one of its ends.
  struct BeyondEnd {
    TableReading worst;
    int knot = 0, first = 0, last = 0;  ///< the worst, the first and the last knot
  };

  void read_beyond(const std::vector<TableReading>& readings, int k) {
    for (const TableReading& reading : readings) {
      if (!(reading.beyond() > kSlack * (reading.last - reading.first))) continue;
      const bool high = reading.at > reading.last;
      const auto key = std::tuple(reading.table, high ? reading.last : reading.first, high);
      auto& range = ranges_.try_emplace(key, BeyondEnd{reading, k, k, k}).first->second;
      range.last = k;
      if (!exceeds(reading.beyond(), range.worst.beyond())) continue;
      range.worst = reading;
      range.knot = k;
    }
  }

  void report_range(const BeyondEnd& range) {
    const TableReading& worst = range.worst;
    const bool high = worst.at > worst.last;
    Finding& f = add(FindingKind::table_range, worst.table, worst.beyond(), "", range.knot);
    f.message = fmt::format(
        "the table '{}' is read at {:.4g}, beyond its {} point {:.4g}, {}", worst.table, worst.at,
        high ? "last" : "first", high ? worst.last : worst.first,
        range.first == range.last ? fmt::format("at knot {}", range.first)
                                  : fmt::format("at knots {} to {}", range.first, range.last));
    f.remedy = "more points, or a bound on its argument: beyond its points the table is linear";
  }

  int first_of_last_phase() const {
    int first = problem_.knots() - 1;
    const auto phase = problem_.knot(first).phase;
    while (first > 0 && problem_.knot(first - 1).phase == phase) --first;
    return first;
  }

  /// Finds controls that change in the last step as nowhere before in their phase.
  void last_knot() {
    constexpr int kFewestKnots = 6;
    constexpr double kFactor = 3, kShare = 0.2;
    constexpr double kUnseen = 1e-3;  // share of the limit of a control
    const int N = problem_.knots(), first = first_of_last_phase();
    const System& system = problem_.knot(N - 1).model->system();
    if (N - first < kFewestKnots || problem_.takes_no_time(N - 1)) return;
    for (int i = 0; i < system.actuators(); ++i) {
      const auto [most, range] = changes(i, first, N - 1);
      const double jump = std::abs(trajectory_.u(N - 1)[i] - trajectory_.u(N - 2)[i]);
      if (jump <= kFactor * most || jump <= kShare * range) continue;
      if (jump <= std::max(kSlack, kUnseen * limit_of(i))) continue;
      const Column& column = system.control_columns()[i];
      Finding& f = add(FindingKind::last_knot, column.name, jump, column.unit, N - 1);
      f.message = fmt::format("{} jumps by {:.3g} {} at the last knot, by {:.3g} at most before",
                              column.name, jump, column.unit, most);
      f.remedy = problem_.terminal().model->costs().empty()
                     ? "a cost 'control_rate', or more time"
                     : "smaller weights of terminal costs, a cost 'control_rate', or more time";
    }
  }

  /// Largest limit of a control at the last knot, from its system or the file; 0 without a limit.
  double limit_of(int control) const {
    const KnotModel& model = *problem_.knot(problem_.knots() - 1).model;
    double largest = 0;
    for (const double limit :
         {model.system().control_lower()[control], model.system().control_upper()[control],
          model.control_lower()[control], model.control_upper()[control]})
      if (std::isfinite(limit)) largest = std::max(largest, std::abs(limit));
    return largest;
  }

  /// Finds bodies that only thrusters drive, and the axes about which these cannot turn them.
  void thrusters() {
    const MultibodySystem* robot = problem_.knot(0).model->system().robot_inside();
    if (robot == nullptr || !floats_throughout()) return;
    const Actuation& actuation = robot->actuation();
    const Eigen::Map<const Eigen::MatrixXd> B(actuation.B.data(), robot->nv(), actuation.nu);
    for (int j = 0; j < robot->robot().joint_count(); ++j) {
      const Joint& joint = robot->robot().joints[j];
      const auto row = robot->velocity_row(j);
      if (joint.type != JointType::floating || !row) continue;
      const bool moves_others =
          j + 1 < robot->robot().joint_count() && robot->robot().root[j + 1] == j;
      const Eigen::MatrixXd force = B.middleRows(*row, 3);
      if (moves_others || force.isZero(0)) continue;
      const Vector3<double> c = (1 / joint.inertia.mass) * joint.inertia.moment;
      Eigen::Matrix3d arm;
      arm << 0, -c.z, c.y, c.z, 0, -c.x, -c.y, c.x, 0;
      judge_thrusters(joint.name, B.middleRows(*row + 3, 3) - arm * force,
                      force.cwiseAbs().maxCoeff());
    }
  }

  /// True if the robot never has contact with the world.
  bool floats_throughout() const {
    for (int k = 0; k < problem_.knots(); ++k) {
      const System& system = problem_.knot(k).model->system();
      const MultibodySystem* robot = system.robot_inside();
      if (robot == nullptr || !robot->contacts().empty() || system.as_stepping() != nullptr)
        return false;
    }
    return true;
  }

  /// Judges torques about the center of mass; their rounding is relative to the forces at one
  /// meter.
  void judge_thrusters(const std::string& body, const Eigen::MatrixXd& torque, double force) {
    const double rounding = 1e-9 * force;
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(torque);
    const int rank = static_cast<int>((svd.singularValues().array() > rounding).count());
    if (rank == 3) return;
    std::string axes;
    for (int i = 0; i < 3; ++i)
      if (torque.row(i).cwiseAbs().maxCoeff() < rounding)
        axes += (axes.empty() ? "" : ", ") + std::string(1, "xyz"[i]);
    Finding& f = add(FindingKind::thrusters, body, 3 - rank, "1", -1);
    f.message = fmt::format(
        "the thrusters cannot turn the body of '{}' about {}", body,
        axes.empty() ? fmt::format("{} of 3 directions", 3 - rank) : "its axes " + axes);
    f.remedy = "thrusters off the center of mass in other directions, or with a torque_ratio";
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const std::vector<Eigen::MatrixXd>& gains_;
  const NodeValues& values_;
  const FindingNames& names_;
  const std::vector<double> times_;
  NodeEvaluation nodes_;
  const KnotWorkspace<double>* evaluated_ = nullptr;   ///< workspace of the last evaluated node
  std::set<std::pair<std::string_view, int>> places_;  ///< state inequalities: name and node
  std::map<std::string, Effort> efforts_;
  const MultibodySystem* efforts_of_ = nullptr;
  std::vector<Effort*> effort_;  ///< efforts of that robot's actuators
  /// Key: table, point at the end, and true if that is the last point.
  std::map<std::tuple<std::string, double, bool>, BeyondEnd> ranges_;
  std::vector<Finding> list_;
  std::vector<Limited> limited_;  ///< limits of joint findings, which come first in the list
};

}  // namespace

std::vector<Finding> find_in_motion(const ShootingProblem& problem, const Trajectory& trajectory,
                                    const std::vector<Eigen::MatrixXd>& gains,
                                    const NodeValues& values, const FindingNames& names) {
  if (!is_finite(trajectory)) return {};
  return Search(problem, trajectory, gains, values, names).run();
}

std::vector<Finding> find_jumps(const ShootingProblem& problem, const Trajectory& trajectory) {
  if (!is_finite(trajectory)) return {};
  return Search(problem, trajectory, {}, NodeValues(problem, trajectory), {}).jumps();
}

}  // namespace conddp
