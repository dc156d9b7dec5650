#include <algorithm>
#include <cmath>

#include "problem_file/expand/expand_problem.hpp"

namespace conddp {
namespace {

/// A number that all knots share, or one for each knot.
OrderedJson shared_or_each(const std::vector<double>& values) {
  if (std::ranges::all_of(values, [&](double value) { return value == values.front(); }))
    return finite_or_null(values.front());
  OrderedJson list = OrderedJson::array();
  for (const double value : values) list.push_back(finite_or_null(value));
  return list;
}

/// Prints one phase, or the last node.
class CorePhase {
 public:
  CorePhase(const Phase& phase, const std::vector<Column>& states)
      : phase_(phase), model_(*phase.model), step_(phase.model->step()), states_(states) {}

  OrderedJson json() const {
    OrderedJson json = {{"name", phase_.name}, {"knots", phase_.knots()}};
    if (step_.integrator() != Integrator::none) {
      if (!phase_.instant) json["dt"] = shared_or_each(phase_.dt);
      json["step"] = step();
      json["controls"] = controls();
    }
    json["costs"] = costs();
    json["constraints"] = constraints();
    return json;
  }

 private:
  /// Column of a number behind the system's state.
  std::string tail_name(int number) const {
    return states_[states_.size() - step_.tail() + number].name;
  }

  OrderedJson step() const {
    OrderedJson json;
    if (const auto name = info_of(step_.integrator()).name; !name.empty())
      json["integrator"] = name;
    if (step_.duration()) json["lasts"] = tail_name(step_.duration()->choice);
    const std::vector<Column>& controls = step_.system().control_columns();
    for (int i = 0; i < step_.tail(); ++i)
      if (const auto control = step_.source(i))
        json["becomes"][tail_name(i)] = controls[*control].name;
    for (const IntegralTerm& integral : step_.integrals())
      json["integrates"].push_back(tail_name(integral.number));
    return json;
  }

  OrderedJson controls() const {
    OrderedJson json = OrderedJson::object();
    for (int i = 0; i < step_.nu(); ++i)
      json[step_.system().control_columns()[i].name] = {finite_or_null(model_.control_lower()[i]),
                                                        finite_or_null(model_.control_upper()[i])};
    return json;
  }

  /// One of the numbers of each knot.
  OrderedJson numbers(int index) const {
    std::vector<double> values;
    for (int k = 0; k < phase_.knots(); ++k)
      values.push_back(phase_.parameters[k * model_.parameter_count() + index]);
    return shared_or_each(values);
  }

  OrderedJson costs() const {
    OrderedJson json = OrderedJson::array();
    for (const CostTerm& cost : model_.costs()) {
      json.push_back(
          {{"name", cost.name}, {"rows", cost.residual->size()}, {"weight", numbers(cost.weight)}});
      if (cost.grows_with) json.back()["grows_with"] = tail_name(cost.grows_with->choice);
      if (cost.integrated) json.back()["integrated"] = true;
    }
    return json;
  }

  OrderedJson constraints() const {
    OrderedJson json = OrderedJson::array();
    for (const ConstraintTerm& term : model_.constraints()) {
      json.push_back(
          {{"name", term.name}, {"rows", term.rows}, {"active", numbers(term.active())}});
      if (term.softness != Softness::hard) json.back()["weight"] = numbers(term.weight());
      if (term.grows_with) json.back()["grows_with"] = tail_name(term.grows_with->choice);
    }
    return json;
  }

  const Phase& phase_;
  const KnotModel& model_;
  const Step& step_;
  const std::vector<Column>& states_;
};

}  // namespace

OrderedJson expand_core(const BuiltProblem& built) {
  const ShootingProblem& problem = *built.problem;
  OrderedJson json;
  for (std::size_t i = 0; i < built.state_columns.size(); ++i)
    json["initial_state"][built.state_columns[i].name] = problem.initial_state()[i];
  for (const Phase& phase : problem.phases())
    json["phases"].push_back(CorePhase(phase, built.state_columns).json());
  json["terminal"] = CorePhase(problem.terminal(), built.state_columns).json();
  return json;
}

}  // namespace conddp
