#include "output/solution/finding_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/problem_names.hpp"

namespace conddp {
namespace {

/// Number of findings printed per kind.
constexpr int kShown = 3;

}  // namespace

std::vector<Finding> findings_of(const BuiltProblem& built, const Trajectory& trajectory,
                                 const std::vector<Eigen::MatrixXd>& gains,
                                 const NodeValues& values) {
  return find_in_motion(*built.problem, trajectory, gains, values, finding_names(built));
}

OrderedJson findings_json(const std::vector<Finding>& findings) {
  OrderedJson list = OrderedJson::array();
  for (const Finding& f : findings) {
    OrderedJson entry = json_object(8);
    entry["kind"] = to_string(f.kind);
    entry["subject"] = f.subject;
    entry["value"] = f.value;
    entry["unit"] = f.unit;
    entry["message"] = f.message;
    if (f.knot >= 0) {
      entry["knot"] = f.knot;
      entry["time_s"] = f.time;
    }
    if (!f.remedy.empty()) entry["remedy"] = f.remedy;
    list.push_back(std::move(entry));
  }
  return list;
}

namespace {

std::string line_of(const Finding& f) {
  if (f.knot < 0) return f.message;
  return f.message + fmt::format(" (knot {}, {:.3g} s)", f.knot, f.time);
}

}  // namespace

std::vector<std::string> finding_lines(const std::vector<Finding>& findings) {
  std::vector<std::string> lines;
  for (std::size_t first = 0, last = 0; first < findings.size(); first = last) {
    const auto end = std::find_if(findings.begin() + first, findings.end(),
                                  [&](const Finding& f) { return f.kind != findings[first].kind; });
    last = end - findings.begin();
    for (std::size_t i = first; i < std::min(first + kShown, last); ++i) {
      lines.push_back(line_of(findings[i]));
      if (i == first && !findings[i].remedy.empty()) lines.back() += "; try " + findings[i].remedy;
    }
    if (last > first + kShown)
      lines.push_back(fmt::format("and {} more of the kind '{}'", last - first - kShown,
                                  to_string(findings[first].kind)));
  }
  return lines;
}

}  // namespace conddp
