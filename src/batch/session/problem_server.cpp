#include "batch/session/problem_server.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/json/diagnostic_json.hpp"
#include "base/shared_library.hpp"

namespace conddp {
namespace {

/// A defect of a request, apart from those of a problem.
struct BadRequest : std::runtime_error {
  explicit BadRequest(const std::string& message, std::vector<std::string> names = {})
      : std::runtime_error(message), accepted(std::move(names)) {}
  std::vector<std::string> accepted;
};

/// Members of the document that are large. A reply contains those that the request lists.
constexpr std::array<std::string_view, 6> kParts = {"trajectory", "gains",   "multipliers",
                                                    "log",        "problem", "tool"};

constexpr int kMaxDepth = 100;  // as deep as a problem file may be

OrderedJson parse_request(std::string_view text) {
  bool too_deep = false;
  auto request = OrderedJson::parse(
      text,
      [&](int depth, OrderedJson::parse_event_t, OrderedJson&) {
        too_deep = too_deep || depth > kMaxDepth;
        return !too_deep;
      },
      false);
  if (too_deep) throw BadRequest("the request is nested too deeply");
  if (request.is_discarded()) throw BadRequest("the request is not valid JSON");
  if (!request.is_object()) throw BadRequest("the request is not an object");
  return request;
}

/// The identity of a request, which its reply repeats.
OrderedJson id_of(const OrderedJson& request) {
  const auto found = request.find("id");
  if (found == request.end()) return nullptr;
  if (!found->is_string() && !found->is_number() && !found->is_null())
    throw BadRequest("'id' must be a text or a number");
  return *found;
}

std::vector<std::string> names(const auto& list) { return {std::begin(list), std::end(list)}; }

/// Throws for a member with another name.
void check_members(const OrderedJson& request, std::vector<std::string> known) {
  known.insert(known.begin(), {"id", "do"});
  for (const auto& [key, value] : request.items())
    if (std::ranges::find(known, key) == known.end())
      throw BadRequest(fmt::format("unknown member '{}'", key), known);
}

const OrderedJson* find(const OrderedJson& request, const char* key) {
  const auto found = request.find(key);
  return found == request.end() || found->is_null() ? nullptr : &*found;
}

std::optional<std::string> find_text(const OrderedJson& request, const char* key) {
  const OrderedJson* value = find(request, key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) throw BadRequest(fmt::format("'{}' must be a text", key));
  return value->get<std::string>();
}

std::string text(const OrderedJson& request, const char* key) {
  auto value = find_text(request, key);
  if (!value) throw BadRequest(fmt::format("the member '{}' is missing", key));
  return *std::move(value);
}

bool flag(const OrderedJson& request, const char* key, bool fallback) {
  const OrderedJson* value = find(request, key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) throw BadRequest(fmt::format("'{}' must be true or false", key));
  return value->get<bool>();
}

/// What is kept under the name that a member gives.
template <class Kept>
const Kept& kept(const std::map<std::string, Kept, std::less<>>& list, const OrderedJson& request,
                 const char* key) {
  const std::string name = text(request, key);
  const auto found = list.find(name);
  if (found != list.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, value] : list) known.push_back(other);
  throw BadRequest(fmt::format("'{}': nothing is kept under the name '{}'", key, name), known);
}

/// JSON is YAML on one line.
KeptProblem::Settings settings_of(const OrderedJson& request) {
  KeptProblem::Settings settings;
  const OrderedJson* values = find(request, "set");
  if (values == nullptr) return settings;
  if (!values->is_object())
    throw BadRequest("'set' must be an object of key paths and their values");
  for (const auto& [key, value] : values->items()) settings[key] = compact_json(value);
  return settings;
}

/// The large members of the document to leave out.
std::vector<std::string> unwanted_parts(const OrderedJson& request) {
  std::vector<std::string> unwanted = names(kParts);
  const OrderedJson* wanted = find(request, "parts");
  const OrderedJson fallback = {"trajectory"};
  if (wanted == nullptr) wanted = &fallback;
  if (!wanted->is_array()) throw BadRequest("'parts' must be a list", unwanted);
  for (const OrderedJson& part : *wanted) {
    const bool known =
        part.is_string() && std::ranges::find(kParts, part.get<std::string>()) != kParts.end();
    if (!known) throw BadRequest("'parts' has an unknown entry", names(kParts));
    std::erase(unwanted, part.get<std::string>());
  }
  return unwanted;
}

OrderedJson messages_json(const std::vector<Diagnostic>& list) {
  OrderedJson json = OrderedJson::array();
  for (const Diagnostic& d : list) json.push_back(diagnostic_json(d));
  return json;
}

OrderedJson error_json(const std::string& message, const std::vector<std::string>& accepted = {}) {
  return {{"message", message}, {"accepted", accepted}};
}

}  // namespace

OrderedJson ProblemServer::load(const OrderedJson& request) {
  check_members(request, {"problem", "file", "content", "folder"});
  const std::string name = text(request, "problem");
  const auto file = find_text(request, "file");
  const OrderedJson* content = find(request, "content");
  if (file.has_value() == (content != nullptr))
    throw BadRequest("'load' takes either 'file' or 'content'");
  const auto folder = find_text(request, "folder");
  if (folder && file) throw BadRequest("'folder' goes with 'content'");
  KeptProblem problem = file ? KeptProblem::load(*file)
                             : KeptProblem::parse(content->is_string() ? content->get<std::string>()
                                                                       : compact_json(*content),
                                                  folder.value_or("."));
  Diagnostics out = problem.texts();
  const SolveTask task = problem.build({}, out);
  problems_.insert_or_assign(name, std::move(problem));
  return {{"problem", problem_outline(task.built)}, {"messages", messages_json(out.list())}};
}

OrderedJson ProblemServer::solve(const OrderedJson& request) {
  check_members(request, {"problem", "set", "start", "keep", "parts", "verify"});
  const KeptProblem& problem = kept(problems_, request, "problem");
  const auto unwanted = unwanted_parts(request);
  const auto keep = find_text(request, "keep");
  const std::vector<std::string> settings = problem.settings(settings_of(request));
  Diagnostics out = problem.texts();
  SolveTask task = problem.build(settings, out);
  if (find(request, "start") != nullptr) start_from(*kept(answers_, request, "start"), task);
  auto answer = std::make_shared<KeptAnswer>(solve_task(
      std::move(task), {.verify = flag(request, "verify", true), .watch = watch_}, settings));
  OrderedJson document = answer->document();
  for (const std::string& part : unwanted) document.erase(part);
  if (keep) answers_.insert_or_assign(*keep, std::move(answer));
  return {{"solution", std::move(document)}, {"messages", messages_json(out.list())}};
}

OrderedJson ProblemServer::drop(const OrderedJson& request) {
  check_members(request, {"problem", "answer"});
  const bool of_problem = find(request, "problem") != nullptr;
  if (of_problem == (find(request, "answer") != nullptr))
    throw BadRequest("'drop' takes either 'problem' or 'answer'");
  if (of_problem) {
    kept(problems_, request, "problem");
    problems_.erase(text(request, "problem"));
  } else {
    kept(answers_, request, "answer");
    answers_.erase(text(request, "answer"));
  }
  return OrderedJson::object();
}

OrderedJson ProblemServer::answer(const OrderedJson& request) {
  const std::string what = text(request, "do");
  if (what == "load") return load(request);
  if (what == "solve") return solve(request);
  if (what == "drop") return drop(request);
  throw BadRequest(fmt::format("'do': unknown request '{}'", what), {"load", "solve", "drop"});
}

std::string ProblemServer::reply(std::string_view request) {
  OrderedJson reply = {{"id", nullptr}};
  try {
    const OrderedJson parsed = parse_request(request);
    reply["id"] = id_of(parsed);
    reply.update(answer(parsed));
  } catch (const BadRequest& bad) {
    reply["error"] = error_json(bad.what(), bad.accepted);
  } catch (const ProblemFailure& failure) {
    reply["error"] = error_json(failure.what());
    reply["messages"] = messages_json(failure.errors);
  } catch (const LibraryError& error) {
    reply["error"] = error_json(error.what());
  } catch (const std::invalid_argument& error) {
    reply["error"] = error_json(error.what());
  } catch (const std::bad_alloc&) {
    reply["error"] = error_json("there is not enough memory");
  }
  return compact_json(reply);
}

std::string ProblemServer::refusal() {
  return compact_json(
      {{"id", nullptr},
       {"error", error_json(fmt::format("a request may have {} MiB", kLongestRequest >> 20))}});
}

}  // namespace conddp
