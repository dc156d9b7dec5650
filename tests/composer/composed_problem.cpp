#include "composed_problem.hpp"

#include "composed_terms.hpp"
#include "problem_file/model/enum_names.hpp"
#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

/// Composes one problem, section by section.
class ProblemComposer {
 public:
  explicit ProblemComposer(std::uint64_t seed)
      : seed_(seed), random_(seed), body_(composed_bodies()[seed % composed_bodies().size()]) {}

  ComposedProblem compose() {
    choose_solver();
    const std::string what = body_.text(random_);
    choose_integrator();
    grid_ = compose_grid(body_, collocates_, taken_.control_bounds, random_);
    TermComposer terms(body_, grid_, random_);
    compose_costs(terms);
    compose_constraints(terms);
    ComposedProblem problem{.body = body_.name, .drop = {}};
    if (!constraint_names_.empty() && random_.chance(0.06))
      problem.drop.push_back(pick(constraint_names_, random_));
    problem.text = fmt::format("conddp: 1\nname: composed_{}\n{}", seed_, what);
    if (body_.robot && random_.chance(0.1)) problem.text += "gravity: [0, 0, -3.7]\n";
    problem.text += "initial_state: " + initial_state() + "\n" + integrator_;
    if (random_.chance(0.3)) {
      const std::string kind = pick_word(kRunningCostsWords, random_);
      if (kind != "integrated" || body_.kind != SystemKind::discrete)
        problem.text += "running_costs: " + kind + "\n";
    }
    problem.text += grid_.text + costs_ + constraints_;
    if (!terminal_costs_.empty() || !terminal_constraints_.empty())
      problem.text += "terminal:\n" + terminal_costs_ + terminal_constraints_;
    problem.text += initial_guess();
    if (random_.chance(0.06))
      problem.text += "perturbation: {initial_state: 0.02, guess: 0.1, seed: 3}\n";
    problem.text += solver();
    return problem;
  }

 private:
  /// Chooses `auto` as often as each solver that supports the body's motion.
  void choose_solver() {
    std::vector<const SolverInfo*> able = {nullptr};
    for (const SolverInfo& info : solvers())
      if (info.name != "ipddp" && (!body_.stepping || info.complementarity)) able.push_back(&info);
    solver_ = pick(able, random_);
    // Interior points take every eighth seed, which leaves the draws of the others alone.
    if (seed_ % 8 == 5) solver_ = find_solver("ipddp");
    const bool taken_to_its_limits = random_.chance(0.03);
    if (solver_ == nullptr || taken_to_its_limits) return;
    taken_ = {.control_bounds = solver_->control_bounds != BoundSupport::none,
              .equalities = solver_->constraints != ConstraintSupport::none,
              .inequalities = solver_->constraints == ConstraintSupport::all};
  }

  void choose_integrator() {
    const bool discrete = body_.kind == SystemKind::discrete;
    std::vector<const Choice<Integrator>*> able;
    for (const Choice<Integrator>& word : kIntegratorWords) {
      const bool collocates = info_of(word.value).collocation.has_value();
      if ((word.value == Integrator::discrete) != discrete) continue;
      if (word.value == Integrator::semi_implicit_euler && body_.kind != SystemKind::second_order)
        continue;
      if (collocates && (body_.curved || !taken_.equalities)) continue;
      if (body_.stepping && word.value != Integrator::semi_implicit_euler) continue;
      able.push_back(&word);
    }
    const Choice<Integrator>& word = *pick(able, random_);
    if (random_.chance(0.2)) return;
    integrator_ = fmt::format("integrator: {}\n", word.word);
    collocates_ = info_of(word.value).collocation.has_value();
  }

  std::string initial_state() {
    Entries keys = body_.initial_state;
    const bool says_robots = !keys.empty() && keys.front().starts_with("robots");
    if (!body_.columns.empty() && !body_.robot && random_.chance(0.7)) {
      Entries values;
      for (const std::string& column : pick_some(body_.columns, 4, random_))
        values.push_back(in_quotes(column) + ": " + number_text(random_.uniform(-0.5, 0.5)));
      keys.push_back("values: " + flow_map(values));
    }
    if (!body_.joints.empty() && !says_robots && random_.chance(0.4))
      keys.push_back(fmt::format("velocity: {{joints: {{\"*\": {}}}}}",
                                 number_text(random_.uniform(-0.3, 0.3))));
    if (uses_rate_ && random_.chance(0.4))
      keys.push_back("previous_control: " + number_text(random_.uniform(-0.5, 0.5)));
    return flow_map(keys);
  }

  /// Residuals allowed there; the seed rotates the first one in each round.
  std::vector<const ResidualDefinition*> able(const TermComposer& terms, bool terminal) const {
    std::vector<const ResidualDefinition*> list;
    for (const ResidualDefinition* residual : residual_table())
      if (terms.can(*residual, terminal)) list.push_back(residual);
    const std::uint64_t count = composed_bodies().size(),
                        round = seed_ / count + 5 * (seed_ % count);
    std::rotate(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(round % list.size()),
                list.end());
    return list;
  }

  void use(const ResidualDefinition& residual) {
    uses_rate_ = uses_rate_ || residual.needs.previous_control;
  }

  void compose_costs(TermComposer& terms) {
    const auto running = able(terms, false), terminal = able(terms, true);
    costs_ = "costs:\n";
    const auto add = [&](const ResidualDefinition& residual) {
      use(residual);
      costs_ += fmt::format("  c{}: {}\n", cost_count_++, terms.cost(residual, false));
    };
    add(*running.front());
    for (int i = random_.index(3); i > 0; --i) add(*pick(running, random_));
    if (random_.chance(0.9))
      costs_ += fmt::format("  effort: {{residual: control, weight: {}}}\n",
                            number_text(between_powers(1e-4, 1, random_)));
    if (terminal.empty() || random_.chance(0.2)) return;
    terminal_costs_ = "  costs:\n";
    for (int i = random_.index(2); i >= 0; --i) {
      const ResidualDefinition& residual = *pick(terminal, random_);
      use(residual);
      aims_ = aims_ || (residual.of_positions && residual.has("joints"));
      terminal_costs_ += fmt::format("    end_{}: {}\n", i, terms.cost(residual, true));
    }
  }

  Softness softness(bool hard_at_all) {
    if (grid_.free_duration) return Softness::hard;
    const double soft = hard_at_all ? 0.4 : 1;
    if (!random_.chance(soft)) return Softness::hard;
    return taken_.inequalities && random_.chance(0.6) ? Softness::l1 : Softness::l2;
  }

  void compose_constraints(TermComposer& terms) {
    const auto running = able(terms, false), terminal = able(terms, true);
    std::string lines;
    const auto name = [&] {
      constraint_names_.push_back(fmt::format("k{}", constraint_names_.size()));
      return constraint_names_.back();
    };
    if (taken_.control_bounds && random_.chance(0.5))
      lines += fmt::format("  {}: {}\n", name(),
                           terms.bounds(BoundedQuantity::kControl, Softness::hard));
    if (random_.chance(0.25)) {
      const auto& quantity = pick(kBoundedWords, random_);
      const Softness how = softness(taken_.inequalities);
      const bool bounds_proper =
          quantity.value == BoundedQuantity::kControl && how == Softness::hard;
      if (terms.can(quantity.value) && !bounds_proper &&
          (how != Softness::hard || taken_.inequalities))
        lines += fmt::format("  {}: {}\n", name(), terms.bounds(quantity.value, how));
    }
    // These rounds also cover the whole list.
    for (int i = random_.index(3); i > 0; --i) {
      const ResidualDefinition& residual = i == 1 ? *running.back() : *running[running.size() / 2];
      const bool hard = residual.is_cone ? taken_.inequalities : taken_.equalities;
      const Softness how = softness(hard);
      if (how == Softness::hard && !hard) continue;
      use(residual);
      lines += fmt::format("  {}: {}\n", name(), terms.constraint(residual, false, how, taken_));
    }
    if (!lines.empty()) constraints_ = "constraints:\n" + lines;
    if (terminal.empty() || !random_.chance(0.3)) return;
    const ResidualDefinition& residual = *pick(terminal, random_);
    const Softness how = softness(taken_.equalities);
    if (how == Softness::hard && !taken_.equalities) return;
    use(residual);
    terminal_constraints_ = fmt::format("  constraints:\n    {}: {}\n", name(),
                                        terms.constraint(residual, true, how, taken_));
  }

  std::string initial_guess() {
    Entries keys;
    if (random_.chance(0.3))
      keys.push_back("states: initial");
    else if (aims_ && random_.chance(0.5))
      keys.push_back("states: interpolate");
    else if (random_.chance(0.3) && !body_.columns.empty() && grid_.knots() > 1)
      keys.push_back(fmt::format(
          "states: {{keyframes: [{{knot: {}, state: {{values: {{{}: 0.2}}}}}}], interpolation: "
          "{}}}",
          grid_.knots(), in_quotes(body_.columns.front()),
          pick_word(kInterpolationWords, random_)));
    Entries controls;
    for (const auto& word : kControlsGuessWords)
      if (word.value == GuessSpec::Controls::kZero || body_.robot ||
          body_.kind == SystemKind::second_order)
        controls.emplace_back(word.word);
    controls.push_back(fmt::format("{{constant: {}}}", number_text(random_.uniform(-1, 1))));
    controls.push_back(fmt::format("{{random: {{seed: {}, scale: 0.2}}}}", random_.index(100)));
    if (random_.chance(0.7)) keys.push_back("controls: " + pick(controls, random_));
    return keys.empty() ? "" : fmt::format("initial_guess: {}\n", flow_map(keys));
  }

  bool takes(HessianChoice choice) const {
    if (solver_ == nullptr) return true;
    return choice == HessianChoice::automatic ||
           (choice == HessianChoice::exact ? solver_->exact_hessian
                                           : solver_->gauss_newton_hessian);
  }

  /// An option value slightly off its default.
  std::optional<std::string> option_value(const OptionInfo& info) {
    if (!info.choices.empty()) {
      const std::string_view word = pick(info.choices, random_);
      SolverOptions options;
      info.set(options, std::string(word));
      if (!takes(options.hessian)) return std::nullopt;
      return std::string(word);
    }
    const OptionValue usual = info.default_value();
    const double* number = std::get_if<double>(&usual);
    // Integer options count solves and threads, which determines the run time.
    if (number == nullptr || !std::isfinite(*number) || *number == 0) return std::nullopt;
    const double value = *number * between_powers(0.5, 2, random_);
    if (!(value > info.min && value < info.max)) return std::nullopt;
    return number_text(value);
  }

  std::string solver() {
    Entries keys, homotopy;
    if (solver_ != nullptr || random_.chance(0.5))
      keys.push_back(fmt::format("name: {}", solver_ != nullptr ? solver_->name : kAutoSolver));
    keys.push_back(fmt::format("max_iterations: {}", 20 + random_.index(31)));
    if (random_.chance(0.1)) keys.push_back("threads: 2");
    if (random_.chance(0.06)) keys.push_back("restarts: {count: 1, spread: 0.05}");
    if (random_.chance(0.06) && !costs_.empty())
      keys.push_back("homotopy: [{key: costs.c0.weight, from: 0.1, to: 2}]");
    std::vector<std::pair<std::string, Entries>> groups;
    for (const OptionInfo& info : option_table()) {
      if (!random_.chance(0.06)) continue;
      const auto value = option_value(info);
      if (!value) continue;
      const std::string name(info.name);
      const std::size_t dot = name.find('.');
      if (dot == std::string::npos) {
        keys.push_back(name + ": " + *value);
        continue;
      }
      const std::string group = name.substr(0, dot);
      if (groups.empty() || groups.back().first != group) groups.push_back({group, {}});
      groups.back().second.push_back(name.substr(dot + 1) + ": " + *value);
    }
    for (const auto& [group, entries] : groups)
      if (group != "restarts") keys.push_back(group + ": " + flow_map(entries));
    return fmt::format("solver: {}\n", flow_map(keys));
  }

  const std::uint64_t seed_;
  RandomNumbers random_;
  const ComposedBody& body_;
  const SolverInfo* solver_ = nullptr;  ///< null: auto
  TakenConstraints taken_;
  bool collocates_ = false, uses_rate_ = false, aims_ = false;
  int cost_count_ = 0;
  ComposedGrid grid_;
  std::string integrator_, costs_, constraints_, terminal_costs_, terminal_constraints_;
  Entries constraint_names_;
};

}  // namespace

ComposedProblem compose_problem(std::uint64_t seed) { return ProblemComposer(seed).compose(); }

}  // namespace conddp
