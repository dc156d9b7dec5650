#include "coverage.hpp"

#include "problem_file/model/enum_names.hpp"
#include "problem_file/values/activation_keys.hpp"

namespace conddp {
namespace {

std::string part(const std::string& kind, std::string_view name) {
  return fmt::format("{} {}", kind, name);
}

/// Constraint kinds to cover; excluded are numbers and cones whose bounds no constraint has.
constexpr std::pair<ConstraintKind, std::string_view> kSets[] = {
    {ConstraintKind::bounds, "bounds"},
    {ConstraintKind::norm, "norm"},
    {ConstraintKind::second_order_cone, "second_order_cone"},
    {ConstraintKind::complementarity, "complementarity"}};

}  // namespace

Coverage::Coverage(const std::vector<std::string>& bodies) {
  const auto expect = [this](const std::string& kind, std::string_view name) {
    counts_.try_emplace(part(kind, name), 0);
  };
  for (const std::string& body : bodies) expect("body", body);
  for (const ResidualDefinition* residual : residual_table())
    if (residual->name != "library") expect("residual", residual->name);
  const auto expect_words = [&](const std::string& kind, const auto& words) {
    for (const auto& word : words)
      if (word.word == word_of(words, word.value)) expect(kind, word.word);
  };
  expect_words("activation", kActivationWords);
  expect_words("bounds on", kBoundedWords);
  expect_words("integrator", kIntegratorWords);
  expect_words("contact", kContactWords);
  expect_words("scheme", kSchemeWords);
  expect_words("friction", kFrictionWords);
  for (const char* where : {"running", "terminal"})
    for (const char* softness : {"hard", "l1", "l2"}) expect(where, softness);
  for (const auto& [kind, name] : kSets) expect("set", name);
  for (const SolverInfo& info : solvers()) expect("solver", info.name);
  for (const char* other : {"auto", "drop", "homotopy", "restarts", "choice", "impulse",
                            "free duration", "perturbation"})
    expect("with", other);
}

void Coverage::count(const std::string& kind, std::string_view name) {
  ++counts_[part(kind, name)];
}

void Coverage::add(const std::string& body, const BuiltProblem& built, const SolverInfo& used) {
  const ProblemSpec& spec = *built.problem_spec;
  count("body", body);
  for (const auto* list : {&spec.costs, &spec.terminal_costs})
    for (const CostSpec& cost : *list) {
      count("residual", cost.definition->name);
      count("activation", word_of(kActivationWords, cost.activation.kind));
    }
  const auto softness = [](Softness how) {
    const std::string word = word_of(kSoftWords, how);
    return word.empty() ? std::string("hard") : word;
  };
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list) {
      count(list == &spec.constraints ? "running" : "terminal", softness(constraint.softness));
      if (constraint.bounded)
        count("bounds on", word_of(kBoundedWords, constraint.bounded->value));
      else
        count("residual", constraint.function.definition->name);
    }
  if (!spec.control_bounds.empty()) count("bounds on", "control");
  for (const ContactSpec& contact : spec.contacts)
    count("contact", word_of(kContactWords, contact.kind));
  if (spec.stepping) {
    count("scheme", word_of(kSchemeWords, spec.stepping->scheme));
    count("friction", word_of(kFrictionWords, spec.stepping->friction));
  }
  for (const Phase& phase : built.problem->phases())
    if (const std::string word = word_of(kIntegratorWords, phase.model->integrator());
        !word.empty() && !phase.instant)
      count("integrator", word);
  for (const NodeConstraint& constraint : built.problem->constraints())
    for (const auto& [kind, name] : kSets)
      if (constraint.term->kind == kind) count("set", name);
  count("solver", used.name);
  const auto with = [this](bool has, std::string_view name) {
    if (has) count("with", name);
  };
  with(spec.solver.name.value == kAutoSolver, "auto");
  with(!built.dropped.empty(), "drop");
  with(built.homotopy != nullptr, "homotopy");
  with(spec.solver.options.restarts.count > 0, "restarts");
  with(spec.perturbation.any(), "perturbation");
  for (const PhaseSpec& phase : spec.phases) {
    with(phase.choice.has_value(), "choice");
    with(phase.restitution.has_value(), "impulse");
    with(phase.free_duration.has_value(), "free duration");
  }
}

std::string Coverage::missing() const {
  std::string lines;
  for (const auto& [name, times] : counts_)
    if (times == 0) lines += name + "\n";
  return lines;
}

}  // namespace conddp
