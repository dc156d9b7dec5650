#include "batch/plan/varied_keys.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

/// The location of a key in a document.
struct Target {
  const YamlNode* node;  ///< the last node on the key's path that exists
  std::string rest;      ///< the remaining steps
};

Target target_of(YamlNode& root, const std::string& key) {
  for (std::size_t end = key.size(); end != std::string::npos && end > 0;
       end = key.rfind('.', end - 1))
    if (const YamlNode* node = find_present(root, key.substr(0, end)))
      return {node, end < key.size() ? key.substr(end + 1) : std::string()};
  return {&root, key};
}

/// True if a node is part of another one.
bool is_inside(const YamlNode* node, const YamlNode& whole) {
  const auto is_or_holds = [node](const YamlNode& part) {
    return &part == node || is_inside(node, part);
  };
  return std::any_of(whole.items.begin(), whole.items.end(), is_or_holds) ||
         std::any_of(whole.entries.begin(), whole.entries.end(),
                     [&](const YamlNode::Entry& entry) { return is_or_holds(entry.value); });
}

/// True if the first target contains or equals the second.
bool has_part(const Target& whole, const Target& part) {
  if (whole.node == part.node)
    return whole.rest.empty() || whole.rest == part.rest || part.rest.starts_with(whole.rest + '.');
  return whole.rest.empty() && is_inside(part.node, *whole.node);
}

bool overlap(const Target& a, const Target& b) { return has_part(a, b) || has_part(b, a); }

bool is_same(const Target& a, const Target& b) { return has_part(a, b) && has_part(b, a); }

/// Compares the keys of a plan by their meaning in one document.
class KeyCheck {
 public:
  KeyCheck(const BatchPlan& plan, const ProblemFamily& family, Diagnostics& out)
      : plan_(plan), family_(family), root_(family.document().root), out_(out) {}

  void run() {
    for (const Axis& axis : plan_.axes)
      for (const AxisColumn& column : axis.columns) {
        const Varied varied{column.key, target_of(root_, column.key.value)};
        for (const Varied& other : varied_) check_pair(varied, other);
        check_against_plan(varied);
        varied_.push_back(varied);
      }
    for (const Varied& varied : varied_) check_against_homotopy(varied);
  }

 private:
  struct Varied {
    const Name& key;
    Target target;
  };

  void check_pair(const Varied& varied, const Varied& other) {
    if (!overlap(varied.target, other.target)) return;
    const std::string &a = varied.key.value, &b = other.key.value;
    out_.error(varied.key.place, fmt::format("'{}' is varied twice", a), hint_of_pair(a, b));
  }

  static std::string hint_of_pair(const std::string& a, const std::string& b) {
    if (a == b && a == "perturbation.seed")
      return "'perturb: [initial_state, guess]' moves both with one seed";
    return a == b ? std::string() : fmt::format("'{}' is varied, too", b);
  }

  /// Reports an axis that varies a key which the plan sets for all items.
  void check_against_plan(const Varied& varied) {
    const auto check = [&](bool is_set, const char* key, const char* words) {
      if (is_set && overlap(varied.target, target_of(root_, key)))
        out_.error(varied.key.place, fmt::format("'{}' is varied, and {}", varied.key.value, words),
                   "leave one of them out");
    };
    check(!plan_.solvers.empty(), "solver.name", "'solvers' says which solvers items have");
    check(plan_.max_time.has_value(), "solver.max_time_s",
          "'limits.max_time_s' sets the time of all items");
    check(plan_.start_file.has_value(), "initial_guess",
          "by 'warm_start' all items start from a file");
    if (plan_.command == BatchCommand::kSolve && first_step(varied.key.value) == "mpc")
      out_.error(varied.key.place,
                 fmt::format("'{}' is varied, but solves do not use keys of closed loops",
                             varied.key.value),
                 "write 'command: mpc': items are closed loops then");
  }

  /// Reports varied keys that a homotopy moves, because its final values override them.
  void check_against_homotopy(const Varied& varied) {
    const auto& moved = family_.base().facts().solver.homotopy;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const std::string entry = fmt::format("solver.homotopy.{}", i);
      if (!is_same(varied.target, target_of(root_, moved[i].key.value)) || varies(entry + ".key"))
        continue;
      out_.error(varied.key.place,
                 fmt::format("'{}' is varied, and the homotopy of '{}' takes this number to {}",
                             varied.key.value, family_.document().file.string(), moved[i].to.value),
                 fmt::format("vary '{}.to' instead", entry));
    }
  }

  bool varies(const std::string& key) {
    const Target target = target_of(root_, key);
    return std::any_of(varied_.begin(), varied_.end(),
                       [&](const Varied& varied) { return overlap(varied.target, target); });
  }

  const BatchPlan& plan_;
  const ProblemFamily& family_;
  YamlNode root_;
  Diagnostics& out_;
  std::vector<Varied> varied_;
};

}  // namespace

void check_varied_keys(const BatchPlan& plan, const ProblemFamily& family, Diagnostics& out) {
  KeyCheck(plan, family, out).run();
}

}  // namespace conddp
