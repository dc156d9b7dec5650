#include "batch/results/result.hpp"

#include "base/json/ordered_json.hpp"

namespace conddp {

std::string result_line(const ItemResult& result) {
  const OrderedJson json = {
      {"id", result.id},
      {"status", result.status},
      {"success", result.success},
      {"attempt", result.attempt},
      {"solution", {result.solution_offset, result.solution_bytes, result.solution_sum}},
      {"answer", result.answer},
      {"times", result.times}};
  return compact_json(json);
}

namespace {

/// Throws OrderedJson::exception if members of an answer or of the times, in a line of another
/// program, have wrong types.
void check_types(const OrderedJson& json) {
  using Object = const OrderedJson::object_t&;
  for (const auto& [name, time] : json.at("times").get_ref<Object>())
    [[maybe_unused]] const double seconds = time.get<double>();
  const OrderedJson& answer = json.at("answer");
  if (answer.is_null()) return;
  for (const auto& [key, value] : answer.get_ref<Object>()) {
    if (key == "residuals") static_cast<void>(value.get_ref<Object>());
    if (key != "constraints") continue;
    for (const OrderedJson& constraint : value.get_ref<const OrderedJson::array_t&>())
      [[maybe_unused]] const std::string name = constraint.at("name");
  }
}

}  // namespace

ItemResult parse_result(std::string_view line) {
  const OrderedJson json = OrderedJson::parse(line);
  check_types(json);
  return {.id = json.at("id"),
          .status = json.at("status"),
          .success = json.at("success"),
          .attempt = json.at("attempt"),
          .solution_offset = json.at("solution").at(0),
          .solution_bytes = json.at("solution").at(1),
          .solution_sum = json.at("solution").at(2),
          .answer = json.at("answer"),
          .times = json.at("times")};
}

}  // namespace conddp
