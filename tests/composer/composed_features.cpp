#include "composed_features.hpp"

#include <algorithm>
#include <regex>

#include "composed_body.hpp"
#include "composed_terms.hpp"

namespace conddp {
namespace {

bool has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

void insert_before(std::string& text, std::string_view anchor, const std::string& line) {
  if (const std::size_t at = text.find(anchor); at != std::string::npos) text.insert(at, line);
}

/// Adds features to the text of a problem, each where it has a meaning.
class FeatureComposer {
 public:
  FeatureComposer(ComposedProblem& problem, std::uint64_t seed)
      : text_(problem.text), body_(body_of(problem)), random_(seed ^ 0x9e3779b97f4a7c15) {}

  void add() {
    const bool discrete = body_.kind == SystemKind::discrete;
    if (!discrete && random_.chance(0.4)) add_integral();
    if (has(text_, "\nrobot:") && random_.chance(0.3)) add_parameter();
    if (!discrete && random_.chance(0.3)) add_durations();
    if (!discrete && random_.chance(0.4)) make_linear();
    if (!discrete && random_.chance(0.2)) text_ += "mesh: {error: 1.0e-3, factor: 2}\n";
    if (has(text_, "\ngait:") && random_.chance(0.5))
      insert_before(text_, "gait:", "phases: [{choose: all}]\n");
  }

 private:
  static const ComposedBody& body_of(const ComposedProblem& problem) {
    const bool robot = has(problem.text, "\nrobot");
    return *std::ranges::find_if(composed_bodies(), [&](const ComposedBody& body) {
      return body.name == problem.body && body.robot == robot;
    });
  }

  void add_integral() {
    const Entries names = names_in_expressions(body_);
    if (names.empty()) return;
    insert_before(text_, "costs:\n",
                  fmt::format("integrals: {{sum: {}}}\n", in_quotes(pick(names, random_) + "^2")));
    if (random_.chance(0.5))
      text_ = std::regex_replace(text_, std::regex("\ncosts:\n"),
                                 "\ncosts:\n  total: {residual: expression, rows: [sum + 1]}\n");
  }

  void add_parameter() {
    insert_before(text_, "robot:", "parameters: {spare: {free: true, lower: 0.5, upper: 2}}\n");
    text_ = std::regex_replace(text_, std::regex("\ncosts:\n"),
                               "\ncosts:\n  spare: {residual: expression, rows: [spare - 1]}\n");
  }

  void add_durations() {
    if (has(text_, "free_duration")) return;
    text_ = std::regex_replace(text_, std::regex("(  - \\{name: part_[^\n]*)\\}\n"),
                               "$1, free_duration: {}}\n");
  }

  void make_linear() {
    text_ = std::regex_replace(text_, std::regex("integrator: [a-z0-9_]*\n"), "");
    insert_before(text_, "initial_state:",
                  fmt::format("integrator: {}\ncontrols: linear\n",
                              random_.chance(0.7) || body_.curved ? "rk4" : "trapezoidal"));
  }

  std::string& text_;
  const ComposedBody& body_;
  RandomNumbers random_;
};

}  // namespace

ComposedProblem with_features(ComposedProblem problem, std::uint64_t seed) {
  FeatureComposer(problem, seed).add();
  return problem;
}

}  // namespace conddp
