// A seeded random walk over the numbers of answers: verification detects every change except those
// that the schema lists as not compared.
#include <cstdlib>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "base/json/json_document.hpp"
#include "output/report/certificate_report.hpp"
#include "support/sizes.hpp"
#include "support/solved_example.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

OrderedJson not_compared() {
  std::ifstream file(source_tree() / "schemas/solution.schema.json");
  return OrderedJson::parse(file).at("not_compared");
}

/// True if the place is in a list entry whose violation is rounding.
bool is_rounding(const std::vector<std::string>& place, const OrderedJson& document) {
  if (place.size() != 3 || !document.at(place[0]).is_array()) return false;
  const OrderedJson& entry = document.at(place[0]).at(std::stoi(place[1]));
  return entry.contains("violation") && entry.at("violation") < 1e-9;
}

/// True if the list has this place or a parent; '*' matches any list entry or name.
bool listed(const OrderedJson& list, const std::vector<std::string>& place,
            const OrderedJson& document) {
  for (const OrderedJson& entry : list) {
    const std::string where = entry.value("where", "");
    if (where == "constraints" && document.value("constraints", OrderedJson()).empty() &&
        document.value("soft_constraints", OrderedJson()).empty())
      continue;
    if (where == "rounding" && !is_rounding(place, document)) continue;
    std::stringstream key(entry["key"].get<std::string>());
    std::string part;
    std::size_t i = 0;
    bool fits = true;
    while (fits && std::getline(key, part, '.')) {
      fits = i < place.size() && (part == "*" || part == place[i]);
      ++i;
    }
    if (fits) return true;
  }
  return false;
}

/// A number in the document and its path; null if the walk does not end at a number.
OrderedJson* find_number(OrderedJson& document, std::mt19937_64& engine,
                         std::vector<std::string>& place, double& scale) {
  OrderedJson* value = &document;
  place.clear();
  while (value->is_structured()) {
    if (value->empty()) return nullptr;
    scale = 1e-3;
    for (const OrderedJson& sibling : *value)
      if (sibling.is_number()) scale = std::max(scale, std::abs(sibling.get<double>()));
    const std::size_t i = engine() % value->size();
    auto entry = value->begin();
    std::advance(entry, static_cast<std::ptrdiff_t>(i));
    place.push_back(value->is_object() ? entry.key() : std::to_string(i));
    value = &*entry;
  }
  return value->is_number() || value->is_boolean() ? value : nullptr;
}

/// Changes by one to a hundred hundredths of the largest neighboring number, far above rounding.
void change(OrderedJson& number, double scale, std::mt19937_64& engine) {
  const double sign = (engine() >> 63) != 0 ? 1 : -1;
  const double share = 0.01 + 0.99 * static_cast<double>(engine() >> 11) * 0x1p-53;
  if (number.is_boolean())
    number = !number.get<bool>();
  else if (number.is_number_integer())
    number = number.get<long long>() + static_cast<long long>(sign * (1 + engine() % 3));
  else
    number = number.get<double>() + sign * share * scale;
}

std::string join(const std::vector<std::string>& place) {
  std::string text;
  for (const std::string& part : place) text += "." + part;
  return text;
}

class CorruptionWalk : public testing::TestWithParam<std::string> {};

TEST_P(CorruptionWalk, EveryChangeIsDetected) {
  SolvedExample answer(GetParam());
  add_certificate(certificate_json(answer.judge(answer.document)), answer.document);
  answer.document = OrderedJson::parse(answer.document.dump());
  const SolutionCertificate good = answer.judge(answer.document);
  ASSERT_TRUE(good.checks.holds()) << certificate_table(good.checks);
  const OrderedJson list = not_compared();
  const char* asked = std::getenv("CONDDP_CORRUPTIONS");
  const int count = asked != nullptr ? std::atoi(asked) : 5;
  std::mt19937_64 engine(7);
  for (int i = 0; i < count;) {
    OrderedJson changed = answer.document;
    std::vector<std::string> place;
    double scale = 1;
    OrderedJson* number = find_number(changed, engine, place, scale);
    if (number == nullptr || listed(list, place, answer.document)) continue;
    ++i;
    const std::string before = number->dump();
    change(*number, scale, engine);
    try {
      EXPECT_FALSE(answer.judge(changed).checks.holds())
          << join(place) << " from " << before << " to " << number->dump();
    } catch (const MalformedSolution&) {
      // An exception counts as detection.
    }
  }
}

/// Covers bounds, impacts, poses, cones, soft constraints, free durations, and cycles.
std::vector<std::string> walked_problems() {
  std::vector<std::string> names = {"pendulum_swingup", "double_integrator_limits", "arm_reach",
                                    "hopper_jump", "pendulum_goal"};
  if (!kSmallSizes)
    names.insert(names.end(),
                 {"acrobot_swingup", "arm_waypoint", "arm_wipe", "arm_reach_pose", "body_reorient",
                  "cartpole_goal", "double_integrator_fastest", "double_pendulum_swingup",
                  "pendulum_cycle", "powered_descent", "unicycle_escape", "unicycle_obstacles",
                  "quadrotor_waypoints", "quadruped_trot", "quadruped_trot_cones"});
  return names;
}

INSTANTIATE_TEST_SUITE_P(Problems, CorruptionWalk, testing::ValuesIn(walked_problems()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace conddp
